/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the shell says of the CAN bus.
 */
#ifndef PHAROS_THREADS_SHELL_CAN_H
#define PHAROS_THREADS_SHELL_CAN_H

#include <zephyr/shell/shell.h>

/* The controller's counters and state; nothing on a board without CAN. */
#ifdef CONFIG_CAN
void shell_can_print(const struct shell *sh);
#else
static inline void shell_can_print(const struct shell *sh)
{
}
#endif

#endif
