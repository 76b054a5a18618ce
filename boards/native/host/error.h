/* SPDX-License-Identifier: Apache-2.0 */
/* One line for the user: what is wrong and what would be right. */
#ifndef NATIVE_HOST_ERROR_H_
#define NATIVE_HOST_ERROR_H_

#include <stdarg.h>
#include <stdio.h>

struct host_error {
	char text[256];
};

/* Formats the line (cut to fit) and returns -1, so that a parser can `return host_error_set(…)`. */
__attribute__((format(printf, 2, 3))) static inline int host_error_set(struct host_error *error,
                                                                       const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	(void)vsnprintf(error->text, sizeof(error->text), format, arguments);
	va_end(arguments);
	return -1;
}

#endif
