/* SPDX-License-Identifier: Apache-2.0 */
/* Where the core's assertions end: a crash for the fuzzer. */
#include "core/assert.h"

#include "check.h"

void pharos_assert_failed(const char *file, int line)
{
	fprintf(stderr, "assertion failed: %s:%d\n", file, line);
	abort();
}
