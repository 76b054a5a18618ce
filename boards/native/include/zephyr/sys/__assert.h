/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Assertions, always on. A failed one prints its place and calls assert_post_action(), which is
 * weak and by default ends in a fatal error (k_panic()).
 */
#ifndef ZEPHYR_SYS___ASSERT_H_
#define ZEPHYR_SYS___ASSERT_H_

#include <zephyr/toolchain.h>

#define __ASSERT_ON 1

void assert_post_action(const char *file, unsigned int line);
void assert_print(const char *fmt, ...) __printf_like(1, 2);

#define __ASSERT(test, fmt, ...)                                                                   \
	do {                                                                                       \
		if (unlikely(!(test))) {                                                           \
			assert_print("ASSERTION FAIL [%s] @ %s:%d\n", #test, __FILE__, __LINE__);  \
			assert_print("\t" fmt "\n", ##__VA_ARGS__);                                \
			assert_post_action(__FILE__, __LINE__);                                    \
		}                                                                                  \
	} while (0)

#define __ASSERT_NO_MSG(test)                                                                      \
	do {                                                                                       \
		if (unlikely(!(test))) {                                                           \
			assert_print("ASSERTION FAIL [%s] @ %s:%d\n", #test, __FILE__, __LINE__);  \
			assert_post_action(__FILE__, __LINE__);                                    \
		}                                                                                  \
	} while (0)

#define __ASSERT_EVAL(expr1, expr2, test, fmt, ...)                                                \
	do {                                                                                       \
		expr2;                                                                             \
		__ASSERT(test, fmt, ##__VA_ARGS__);                                                \
	} while (0)

#endif
