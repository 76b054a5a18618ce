/* SPDX-License-Identifier: Apache-2.0 */
/* Timers, whose functions run in interrupt context, and the uptime. */
#ifndef ZEPHYR_KERNEL_TIMER_H_
#define ZEPHYR_KERNEL_TIMER_H_

#include <zephyr/kernel/thread.h>

struct k_timer;
typedef void (*k_timer_expiry_t)(struct k_timer *timer);
typedef void (*k_timer_stop_t)(struct k_timer *timer);

struct k_timer {
	struct _timeout timeout;
	k_timer_expiry_t expiry_fn;
	k_timer_stop_t stop_fn;
	k_timeout_t period;
	void *user_data;
};

#define Z_TIMER_INITIALIZER(obj, expiry, stop)                                                     \
	{                                                                                          \
		.expiry_fn = (expiry), .stop_fn = (stop)                                           \
	}
#define K_TIMER_DEFINE(name, expiry_fn, stop_fn)                                                   \
	struct k_timer name = Z_TIMER_INITIALIZER(name, expiry_fn, stop_fn)

void k_timer_init(struct k_timer *timer, k_timer_expiry_t expiry_fn, k_timer_stop_t stop_fn);
/*
 * First expiry after duration, or at it when absolute; then every period (K_NO_WAIT, K_FOREVER:
 * once), each at an exact multiple. A running timer is restarted. K_FOREVER: no
 * effect. Any context.
 */
void k_timer_start(struct k_timer *timer, k_timeout_t duration, k_timeout_t period);
/* Runs the stop function when the timer was running. Any context. */
void k_timer_stop(struct k_timer *timer);
k_ticks_t k_timer_expires_ticks(const struct k_timer *timer);
k_ticks_t k_timer_remaining_ticks(const struct k_timer *timer);

static inline uint32_t k_timer_remaining_get(struct k_timer *timer)
{
	return (uint32_t)k_ticks_to_ms_floor64((uint64_t)k_timer_remaining_ticks(timer));
}

static inline void k_timer_user_data_set(struct k_timer *timer, void *user_data)
{
	timer->user_data = user_data;
}

static inline void *k_timer_user_data_get(const struct k_timer *timer)
{
	return timer->user_data;
}

/* Inside a timer's function: the time for which it was set, not the later one at which it runs. */
static inline int64_t k_uptime_ticks(void)
{
	return sys_clock_tick_get();
}

static inline int64_t k_uptime_get(void)
{
	return (int64_t)k_ticks_to_ms_floor64((uint64_t)k_uptime_ticks());
}

static inline uint32_t k_uptime_get_32(void)
{
	return (uint32_t)k_uptime_get();
}

static inline uint32_t k_uptime_seconds(void)
{
	return (uint32_t)(k_uptime_get() / MSEC_PER_SEC);
}

static inline int64_t k_uptime_delta(int64_t *reftime)
{
	const int64_t now = k_uptime_get();
	const int64_t delta = now - *reftime;

	*reftime = now;
	return delta;
}

uint64_t k_cycle_get_64(void);

static inline uint32_t k_cycle_get_32(void)
{
	return (uint32_t)k_cycle_get_64();
}

#endif
