/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The supervisor feeds the watchdog as long as every watched thread reports in. A stalled one is
 * named in the log; then the watchdog bites, and the lamp is off until commanded.
 */
#ifndef PHAROS_THREADS_SUPERVISOR_H
#define PHAROS_THREADS_SUPERVISOR_H

#include <stdint.h>

/* Watched threads, see the table in main.c. */
enum supervisor_watch {
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

/* Firmware whose threads have all reported in for so long works. */
#define SUPERVISOR_CONFIRM_MS 10000

_Static_assert(2 * SUPERVISOR_REPORT_MS <= SUPERVISOR_LIMIT_MS, "one late report is no stall");
_Static_assert(2 * SUPERVISOR_PERIOD_MS <= SUPERVISOR_WATCHDOG_MS, "one late feed is no bite");

/* Arms the watchdog. Before the threads start; 0 or -errno of the watchdog's driver. */
int supervisor_init(void);

/* Watch this thread from now on (its first report). Any thread, lock-free. */
void supervisor_report(enum supervisor_watch watch);

/* Milliseconds since the last report; -1: not watched. Any context. */
int32_t supervisor_age_ms(enum supervisor_watch watch);

const char *supervisor_name(enum supervisor_watch watch);

/* Thread entry. */
void supervisor_run(void *, void *, void *);

#endif
