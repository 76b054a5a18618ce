/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a shell command asks the command thread.
 */
#ifndef PHAROS_THREADS_SHELL_CALL_H
#define PHAROS_THREADS_SHELL_CALL_H

#include <errno.h>
#include <stdbool.h>

#include <zephyr/shell/shell.h>

#include "threads/inbox.h"

/* function(device, argument) has run, and *result (or NULL) is what it returned; false: there is
 * no command thread yet, nothing has run, and the user knows.
 */
static inline bool shell_call(const struct shell *sh,
                              int (*function)(struct pharos_device *, void *), void *argument,
                              int *result)
{
	const int returned = inbox_call(function, argument);

	if (returned == -EAGAIN) {
		shell_error(sh, "the light has not started (see: startup)");
		return false;
	}
	if (result != NULL) {
		*result = returned;
	}
	return true;
}

#endif
