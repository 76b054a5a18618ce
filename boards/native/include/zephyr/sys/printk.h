/* SPDX-License-Identifier: Apache-2.0 */
/* Console output from any context, and formatting, with the host libc's conversions. */
#ifndef ZEPHYR_SYS_PRINTK_H_
#define ZEPHYR_SYS_PRINTK_H_

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <zephyr/toolchain.h>

void printk(const char *fmt, ...) __printf_like(1, 2);
void vprintk(const char *fmt, va_list ap) __printf_like(1, 0);

#define snprintk  snprintf
#define vsnprintk vsnprintf

#endif
