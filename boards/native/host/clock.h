/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Board time: microseconds since power-on; it goes on over resets. (Kernel uptime,
 * port_clock_now_us(), starts at each reset.) Virtual: moves only when it is told to.
 *
 * Real: follows the host's monotonic clock, in steps that the device can bear. When the host comes
 * more than CLOCK_LATE_MS late, it has stood still: the process was stopped, or got no processor,
 * or waited for a disk; it neither ran nor had asked to wait. That time is left out, so that no
 * timer of the device sees it: it is no missing sample, no lost link, no stalled thread. Afterwards
 * board time runs 1/CLOCK_MAKE_UP faster than the host's clock until all of it is made up for. So
 * uptime is right in the long run, and an interval is never off by more than that. Time in which
 * the firmware itself kept the processor is never left out: a thread that hogs it is seen to.
 *
 *   host's clock  ----|-------|- - - - - - - -|-------|-------|------->
 *   board time    ----|-------|               |-------|------|------>
 *                              stood still      1/64 faster until it is right again
 */
#ifndef NATIVE_HOST_CLOCK_H_
#define NATIVE_HOST_CLOCK_H_

#include <stdbool.h>
#include <stdint.h>

enum {
	CLOCK_LATE_MS = 100,
	CLOCK_MAKE_UP = 64,
	CLOCK_TELL_MS = 500, /* standing still for longer is told, once */
};

bool clock_is_virtual(void);

/* Virtual time that stands still until an `advance` of the control socket (host/lockstep.h). */
bool clock_is_lockstep(void);

/* Options only: there will be a control socket, so virtual time is lock-step. */
void clock_control(void);

uint64_t clock_board_us(void);

/* Board time at the start of this boot: the difference to the kernel's uptime. */
uint64_t clock_boot_us(void);

/* Real time: the kernel's next reading of its clock is a new one. */
void clock_stale(void);

/* Virtual only: board time becomes us; never backwards. */
void clock_jump(uint64_t us);

/* Board time at which the process is to end (--until); UINT64_MAX: none. */
uint64_t clock_until_us(void);

/* Board time of a reading of the host's monotonic clock that is not long ago, real time only.
 * Before power-on: 0. */
uint64_t clock_board_of_host_us(uint64_t host_ns);

/* Real time: how long the host has to wait for this board time, at most; 0: it is here. */
uint64_t clock_host_until_ns(uint64_t board_us);

/* The host waits, and has asked to, until this reading of its clock (UINT64_MAX: without end); it
 * has waited. */
void clock_wait_begin(uint64_t until_ns);
void clock_wait_end(void);

/* Real time: how often, and for how long in all, the host has stood still since power-on, and how
 * much of that is still to be made up for. */
struct clock_stops {
	uint32_t count;
	uint64_t total_us;
	uint64_t behind_us;
};

struct clock_stops clock_stops_get(void);

/* How long it has stood still since the last call, if that is worth a line; else 0. */
uint64_t clock_take_stop_ms(void);

/* The host's monotonic clock. */
uint64_t clock_host_ns(void);

#endif
