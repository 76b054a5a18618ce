/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

void k_event_init(struct k_event *event)
{
	event->events = 0;
	wait_q_init(&event->wait_q);
}

static uint32_t matching(const struct k_thread *thread, uint32_t events)
{
	const uint32_t match = events & thread->event_wanted;

	return thread->event_all && match != thread->event_wanted ? 0 : match;
}

/* Every waiter that is satisfied sees the same events. */
static uint32_t update(struct k_event *event, uint32_t events, uint32_t mask)
{
	const uint32_t previous = event->events & mask;
	struct k_thread *thread, *next;

	event->events = (event->events & ~mask) | (events & mask);
	SYS_DLIST_FOR_EACH_CONTAINER_SAFE(&event->wait_q.waitq, thread, next, base.qnode) {
		const uint32_t match = matching(thread, event->events);

		if (match != 0) {
			thread->event_got = match;
			sched_wake(thread, 0, NULL);
		}
	}
	sched_reschedule();
	return previous;
}

uint32_t k_event_post(struct k_event *event, uint32_t events)
{
	return update(event, events, events);
}

uint32_t k_event_set(struct k_event *event, uint32_t events)
{
	return update(event, events, UINT32_MAX);
}

uint32_t k_event_set_masked(struct k_event *event, uint32_t events, uint32_t events_mask)
{
	return update(event, events, events_mask);
}

uint32_t k_event_clear(struct k_event *event, uint32_t events)
{
	return update(event, 0, events);
}

static uint32_t wait_for(struct k_event *event, uint32_t events, bool all, bool reset,
                         k_timeout_t timeout)
{
	struct k_thread *const self = sched_current;

	__ASSERT(native_cpu.isr_depth == 0 || K_TIMEOUT_EQ(timeout, K_NO_WAIT),
	         "waiting in an interrupt");
	if (events == 0) {
		return 0;
	}
	if (reset) {
		event->events = 0;
	}
	self->event_wanted = events;
	self->event_all = all;

	const uint32_t match = matching(self, event->events);

	if (match != 0 || K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return match;
	}
	return sched_pend(&event->wait_q, timeout) == 0 ? self->event_got : 0;
}

uint32_t k_event_wait(struct k_event *event, uint32_t events, bool reset, k_timeout_t timeout)
{
	return wait_for(event, events, false, reset, timeout);
}

uint32_t k_event_wait_all(struct k_event *event, uint32_t events, bool reset, k_timeout_t timeout)
{
	return wait_for(event, events, true, reset, timeout);
}
