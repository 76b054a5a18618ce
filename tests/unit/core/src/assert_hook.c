/* SPDX-License-Identifier: Apache-2.0 */
#include "assert_hook.h"

#include <stdbool.h>

#include <zephyr/kernel.h>
#include <zephyr/ztest.h>

#include "core/assert.h"

static bool expected;

void expect_assert(void)
{
	expected = true;
}

void pharos_assert_failed(const char *file, int line)
{
	if (expected) {
		expected = false;
		ztest_test_pass();
	} else {
		printk("assertion failed: %s:%d\n", file, line);
		ztest_test_fail();
	}
	CODE_UNREACHABLE;
}
