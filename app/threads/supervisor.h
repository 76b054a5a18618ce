/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The supervisor feeds the watchdog as long as every watched thread reports in. A stalled one is
 * named in the log; then the watchdog bites, and the lamp is off until commanded. Where there is no
 * watchdog that works the supervisor resets the board itself, and the lamp stays dark meanwhile
 * (threads/startup.h).
 *
 * A thread is watched from supervisor_watch() on, before it first runs: one that hangs before its
 * first report is late as any other. Start-up itself is watched like a thread.
 */
#ifndef PHAROS_THREADS_SUPERVISOR_H
#define PHAROS_THREADS_SUPERVISOR_H

#include <stdbool.h>
#include <stdint.h>

/* What can be watched, see the table in main.c. */
enum supervisor_watch {
	SUPERVISOR_START, /* start-up, until it is complete */
	SUPERVISOR_THERMAL,
	SUPERVISOR_COMMAND,
	SUPERVISOR_UART_LINK0,
	SUPERVISOR_UART_LINK1,
	SUPERVISOR_UART_LINK2,
	SUPERVISOR_UART_LINK3,
	SUPERVISOR_CAN_LINK,
	SUPERVISOR_IMC_LINK,
	SUPERVISOR_WATCHES,
};

/* How long a watched thread may wait without reporting in, and how long it may be silent. */
#define SUPERVISOR_REPORT_MS   400
#define SUPERVISOR_LIMIT_MS    1000
/* The watchdog's own period, in which the supervisor must have fed it. */
#define SUPERVISOR_WATCHDOG_MS 1000
#define SUPERVISOR_PERIOD_MS   250

/*
 * The time-out of a watchdog that runs before the firmware and cannot be set anew; a bootloader's
 * own, where it starts one, must be at least as long as the boot takes.
 */
#ifdef CONFIG_IWDG_STM32_INITIAL_TIMEOUT
#define SUPERVISOR_RUNNING_MS CONFIG_IWDG_STM32_INITIAL_TIMEOUT
#else
#define SUPERVISOR_RUNNING_MS CONFIG_PHAROS_WATCHDOG_RUNNING_MS
#endif

_Static_assert(2 * SUPERVISOR_REPORT_MS <= SUPERVISOR_LIMIT_MS, "one late report is no stall");
_Static_assert(2 * SUPERVISOR_PERIOD_MS <= SUPERVISOR_WATCHDOG_MS, "one late feed is no bite");

/* The watchdog's time-out in ms; 0: there is none that works. Any context. */
uint32_t supervisor_watchdog_ms(void);

/* Watch this thread from now on, or no longer. Any thread, lock-free. */
void supervisor_watch(enum supervisor_watch watch);
void supervisor_unwatch(enum supervisor_watch watch);

/* It is well. Any thread, lock-free; nothing while it is not watched. */
void supervisor_report(enum supervisor_watch watch);

/* Milliseconds since the last report, or since it is watched; -1: not watched. Any context. */
int32_t supervisor_age_ms(enum supervisor_watch watch);

/* Every watched thread has reported at least once, and none is late. Any context. */
bool supervisor_all_report(void);

/* Thread entry: arms the watchdog, or takes over one that runs already. */
void supervisor_run(void *p1, void *p2, void *p3);

#endif
