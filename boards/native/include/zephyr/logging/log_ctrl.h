/* SPDX-License-Identifier: Apache-2.0 */
/* Control of the log. */
#ifndef ZEPHYR_LOGGING_LOG_CTRL_H
#define ZEPHYR_LOGGING_LOG_CTRL_H

#include <stdbool.h>
#include <stdint.h>

#ifdef CONFIG_LOG

/* Writes one waiting message; true: more are waiting. Threads only. */
bool log_process(void);

/* Messages that wait. Any context. */
uint32_t log_buffered_cnt(void);

/* Messages dropped since boot because the ring was full. Any context. */
uint32_t log_dropped_cnt(void);

/* Writes what is waiting, and from now on every message at once, in the caller's context, past the
 * shell and the UART driver. For a fatal error: there is no way back. Any context.
 */
void log_panic(void);

#define LOG_PANIC() log_panic()
#else
#define LOG_PANIC() (void)0
#endif

#endif
