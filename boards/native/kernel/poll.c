/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

static _wait_q_t pollers = Z_WAIT_Q_INIT(&pollers);

/* Among the pollers of one signal the most urgent comes first. */
static void add_event(struct k_poll_event *event)
{
	sys_dlist_t *const list = &event->signal->poll_events;
	sys_dnode_t *node = sys_dlist_peek_head(list);

	event->poller = sched_current;
	while (node != NULL && CONTAINER_OF(node, struct k_poll_event, _node)->poller->base.prio <=
	                               sched_current->base.prio) {
		node = sys_dlist_peek_next(list, node);
	}
	sys_dlist_insert(node != NULL ? node : list, &event->_node);
}

static void remove_events(struct k_poll_event *events, int count)
{
	for (int i = 0; i < count; i++) {
		events[i].poller = NULL;
		if (sys_dnode_is_linked(&events[i]._node)) {
			sys_dlist_remove(&events[i]._node);
		}
	}
}

int k_poll(struct k_poll_event *events, int num_events, k_timeout_t timeout)
{
	bool any_ready = false;

	__ASSERT(native_cpu.isr_depth == 0, "polling in an interrupt");
	for (int i = 0; i < num_events; i++) {
		__ASSERT(events[i].type == K_POLL_TYPE_SIGNAL, "poll event type %u",
		         (unsigned int)events[i].type);
		if (events[i].signal->signaled != 0) {
			events[i].state |= K_POLL_STATE_SIGNALED;
			any_ready = true;
		}
	}
	if (any_ready) {
		return 0;
	}
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return -EAGAIN;
	}
	for (int i = 0; i < num_events; i++) {
		add_event(&events[i]);
	}

	const int result = sched_pend(&pollers, timeout);

	remove_events(events, num_events);
	return result;
}

/* The first poller; when it is awake already, its event only gets the state. */
static void notify(struct k_poll_signal *sig)
{
	sys_dnode_t *const node = sys_dlist_get(&sig->poll_events);

	if (node == NULL) {
		return;
	}

	struct k_poll_event *const event = CONTAINER_OF(node, struct k_poll_event, _node);
	struct k_thread *const thread = event->poller;

	event->poller = NULL;
	event->state |= K_POLL_STATE_SIGNALED;
	if (thread->base.pended_on == &pollers) {
		sched_wake(thread, 0, NULL);
	}
}

void k_poll_signal_init(struct k_poll_signal *sig)
{
	sys_dlist_init(&sig->poll_events);
	sig->signaled = 0;
}

void k_poll_signal_reset(struct k_poll_signal *sig)
{
	sig->signaled = 0;
}

void k_poll_signal_check(struct k_poll_signal *sig, unsigned int *signaled, int *result)
{
	*signaled = sig->signaled;
	*result = sig->result;
}

int k_poll_signal_raise(struct k_poll_signal *sig, int result)
{
	sig->result = result;
	sig->signaled = 1;
	notify(sig);
	sched_reschedule();
	return 0;
}
