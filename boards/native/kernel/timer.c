/* SPDX-License-Identifier: Apache-2.0 */
#include "port.h"
#include "sched.h"

void k_timer_init(struct k_timer *timer, k_timer_expiry_t expiry_fn, k_timer_stop_t stop_fn)
{
	*timer = (struct k_timer){.expiry_fn = expiry_fn, .stop_fn = stop_fn};
}

/* The next expiry counts from the tick of this one, however late it runs: a period does not drift.
 */
static void timer_expired(struct _timeout *timeout)
{
	struct k_timer *timer = CONTAINER_OF(timeout, struct k_timer, timeout);

	port_trace("timer", "", (int64_t)timeout->tick);
	if (timer->period.ticks > 0) {
		const k_ticks_t next = (k_ticks_t)timeout->tick + timer->period.ticks;

		timeout_add(timeout, timer_expired, K_TIMEOUT_ABS_TICKS(next));
	}
	if (timer->expiry_fn != NULL) {
		timer->expiry_fn(timer);
	}
}

/* A relative duration is one tick shorter than a timeout is elsewhere: upstream's timers count so.
 */
void k_timer_start(struct k_timer *timer, k_timeout_t duration, k_timeout_t period)
{
	if (K_TIMEOUT_EQ(duration, K_FOREVER)) {
		return;
	}
	if (duration.ticks > 0) {
		duration.ticks--;
	}
	(void)timeout_abort(&timer->timeout);
	timer->period = period;
	timeout_add(&timer->timeout, timer_expired, duration);
}

void k_timer_stop(struct k_timer *timer)
{
	if (!timeout_abort(&timer->timeout)) {
		return;
	}
	if (timer->stop_fn != NULL) {
		timer->stop_fn(timer);
	}
}

k_ticks_t k_timer_expires_ticks(const struct k_timer *timer)
{
	return timeout_expires(&timer->timeout);
}

k_ticks_t k_timer_remaining_ticks(const struct k_timer *timer)
{
	return timeout_remaining(&timer->timeout);
}
