/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Standard error and standard output, when they may make their writer wait: an unread pipe, a
 * terminal that was stopped with Ctrl-S. port_console_write() goes to standard error through a
 * sink; lines that do not fit are dropped, counted, and told of when there is room again.
 */
#ifndef NATIVE_HOST_CONSOLE_H_
#define NATIVE_HOST_CONSOLE_H_

#include <stdint.h>

#include "host/sink.h"

enum {
	CONSOLE_RING = 1 << 16,
	CONSOLE_FINISH_MS = 500, /* the last words before an end or a reset */
};

/* The sink of standard output: that of standard error if both are the same file, so that what is
 * written stays in order. drained: in the loop: it is empty; error: errno of the write that made it
 * so, or 0. */
struct sink *console_output(void (*drained)(void *arg, int error), void *arg);

/* Lines of standard error that were dropped since power-on. */
uint64_t console_dropped(void);

#endif
