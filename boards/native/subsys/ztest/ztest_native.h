/* SPDX-License-Identifier: Apache-2.0 */
/* Between ztest and the command line. */
#ifndef NATIVE_ZTEST_NATIVE_H_
#define NATIVE_ZTEST_NATIVE_H_

#include <stdbool.h>

/* Was this test asked for? Nothing asked: every one. */
bool ztest_native_selected(const char *suite, const char *test);

/* Further options that a run needs to be the same again; a static string, maybe "". */
const char *ztest_native_replay(void);

#endif
