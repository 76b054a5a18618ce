/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Board time: microseconds since power-on; it goes on over resets. (Kernel uptime,
 * port_clock_now_us(), starts at each reset.) Real: follows the host's monotonic clock. Virtual:
 * moves only when it is told to.
 */
#ifndef NATIVE_HOST_CLOCK_H_
#define NATIVE_HOST_CLOCK_H_

#include <stdbool.h>
#include <stdint.h>

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

/* Board time of a reading of the host's monotonic clock, real time only. Before power-on: 0. */
uint64_t clock_board_of_host_us(uint64_t host_ns);

/* The host's monotonic clock. */
uint64_t clock_host_ns(void);

#endif
