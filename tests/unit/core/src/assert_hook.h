/* SPDX-License-Identifier: Apache-2.0 */
/* The core's assertions in tests: a failure, unless it is what the test expects next. */
#ifndef TESTS_UNIT_CORE_ASSERT_HOOK_H
#define TESTS_UNIT_CORE_ASSERT_HOOK_H

/* The next failed assertion ends the test as passed; a test that goes on after the call fails. */
void expect_assert(void);

#endif
