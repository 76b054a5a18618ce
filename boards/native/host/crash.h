/* SPDX-License-Identifier: Apache-2.0 */
/* What must be undone even when the process dies: the terminal's raw mode. */
#ifndef NATIVE_HOST_CRASH_H_
#define NATIVE_HOST_CRASH_H_

#include <termios.h>

/* From now on, an end of any kind (but SIGKILL) gives fd these settings again. */
void crash_restore_terminal(int fd, const struct termios *settings);

/* Restores now. Safe in a signal. */
void crash_restore(void);

#endif
