/* SPDX-License-Identifier: Apache-2.0 */
#include "host/say.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include "host/clock.h"
#include "kernel/port.h"

enum {
	TEXT_MAX = 256
};

static void (*taker)(const char *text);

void host_say_through(void (*take)(const char *text))
{
	taker = clock_is_virtual() ? NULL : take;
}

void host_say(const char *format, ...)
{
	char text[TEXT_MAX];
	va_list arguments;

	va_start(arguments, format);
	(void)vsnprintf(text, sizeof(text), format, arguments);
	va_end(arguments);
	if (taker != NULL) {
		taker(text);
	} else {
		char line[TEXT_MAX + 16];

		port_console_write(line,
		                   (size_t)snprintf(line, sizeof(line), "pharos: %s\n", text));
	}
}
