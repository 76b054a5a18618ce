/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Timeouts and the tick clock. A relative timeout of n ticks ends at the (n + 1)th tick from now,
 * unless it starts in a timer's expiry: it never is shorter than asked.
 * CONFIG_SYS_CLOCK_TICKS_PER_SEC is the resolution.
 */
#ifndef ZEPHYR_SYS_CLOCK_H_
#define ZEPHYR_SYS_CLOCK_H_

#include <stdbool.h>
#include <stdint.h>

#include <zephyr/sys/dlist.h>
#include <zephyr/sys/time_units.h>

typedef int64_t k_ticks_t;

typedef struct {
	k_ticks_t ticks;
} k_timeout_t;

#define K_TICKS_FOREVER ((k_ticks_t)-1)

#define K_TIMEOUT_EQ(a, b) ((a).ticks == (b).ticks)

#define Z_TIMEOUT_TICKS(t) ((k_timeout_t){.ticks = (t)})
#define Z_TIMEOUT_NO_WAIT  Z_TIMEOUT_TICKS(0)
#define Z_FOREVER          Z_TIMEOUT_TICKS(K_TICKS_FOREVER)

/* Absolute ticks are kept as negative numbers below K_TICKS_FOREVER; the mapping is its own
 * inverse. */
#define Z_TICK_ABS(t) (K_TICKS_FOREVER - 1 - (t))

#define NATIVE_NOT_NEGATIVE(t) ((t) > 0 ? (uint64_t)(t) : 0U)

#define K_NO_WAIT    Z_TIMEOUT_NO_WAIT
#define K_FOREVER    Z_FOREVER
#define K_TICKS(t)   Z_TIMEOUT_TICKS(t)
#define K_NSEC(t)    K_TICKS((k_ticks_t)k_ns_to_ticks_ceil64(NATIVE_NOT_NEGATIVE(t)))
#define K_USEC(t)    K_TICKS((k_ticks_t)k_us_to_ticks_ceil64(NATIVE_NOT_NEGATIVE(t)))
#define K_MSEC(t)    K_TICKS((k_ticks_t)k_ms_to_ticks_ceil64(NATIVE_NOT_NEGATIVE(t)))
#define K_CYC(t)     K_TICKS((k_ticks_t)k_cyc_to_ticks_ceil64(NATIVE_NOT_NEGATIVE(t)))
#define K_SECONDS(s) K_MSEC((int64_t)(s)*MSEC_PER_SEC)
#define K_MINUTES(m) K_SECONDS((int64_t)(m)*60)
#define K_HOURS(h)   K_MINUTES((int64_t)(h)*60)

#define K_TIMEOUT_ABS_TICKS(t) K_TICKS(Z_TICK_ABS((k_ticks_t)NATIVE_NOT_NEGATIVE(t)))
#define K_TIMEOUT_ABS_MS(t)                                                                        \
	K_TIMEOUT_ABS_TICKS((k_ticks_t)k_ms_to_ticks_ceil64(NATIVE_NOT_NEGATIVE(t)))
#define K_TIMEOUT_ABS_US(t)                                                                        \
	K_TIMEOUT_ABS_TICKS((k_ticks_t)k_us_to_ticks_ceil64(NATIVE_NOT_NEGATIVE(t)))
#define K_TIMEOUT_ABS_NS(t)                                                                        \
	K_TIMEOUT_ABS_TICKS((k_ticks_t)k_ns_to_ticks_ceil64(NATIVE_NOT_NEGATIVE(t)))
#define K_TIMEOUT_ABS_CYC(t)                                                                       \
	K_TIMEOUT_ABS_TICKS((k_ticks_t)k_cyc_to_ticks_ceil64(NATIVE_NOT_NEGATIVE(t)))

/* One entry of the timeout queue, embedded in threads, timers and delayable work. */
struct _timeout;
typedef void (*_timeout_func_t)(struct _timeout *t);

struct _timeout {
	sys_dnode_t node;
	_timeout_func_t fn;
	uint64_t tick; /* when it ends */
};

int64_t sys_clock_tick_get(void);

#endif
