/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

static _wait_q_t pollers = Z_WAIT_Q_INIT(&pollers);

/* The state that the event's object gives it now; 0: none. */
static uint32_t ready_state(const struct k_poll_event *event)
{
	switch (event->type) {
	case K_POLL_TYPE_IGNORE:
		return 0;
	case K_POLL_TYPE_SIGNAL:
		return event->signal->signaled != 0 ? K_POLL_STATE_SIGNALED : 0;
	case K_POLL_TYPE_SEM_AVAILABLE:
		return k_sem_count_get(event->sem) > 0 ? K_POLL_STATE_SEM_AVAILABLE : 0;
	case K_POLL_TYPE_DATA_AVAILABLE:
		return !k_queue_is_empty(event->queue) ? K_POLL_STATE_DATA_AVAILABLE : 0;
	case K_POLL_TYPE_MSGQ_DATA_AVAILABLE:
		return event->msgq->used_msgs > 0 ? K_POLL_STATE_MSGQ_DATA_AVAILABLE : 0;
	default:
		__ASSERT(false, "poll event type %u", (unsigned int)event->type);
		return 0;
	}
}

static sys_dlist_t *object_events(const struct k_poll_event *event)
{
	switch (event->type) {
	case K_POLL_TYPE_SIGNAL:
		return &event->signal->poll_events;
	case K_POLL_TYPE_SEM_AVAILABLE:
		return &event->sem->poll_events;
	case K_POLL_TYPE_DATA_AVAILABLE:
		return &event->queue->poll_events;
	case K_POLL_TYPE_MSGQ_DATA_AVAILABLE:
		return &event->msgq->poll_events;
	default:
		return NULL;
	}
}

/* Among the pollers of one object the most urgent comes first. */
static void add_event(struct k_poll_event *event)
{
	sys_dlist_t *const list = object_events(event);
	sys_dnode_t *node;

	event->poller = sched_current;
	if (list == NULL) {
		return;
	}
	node = sys_dlist_peek_head(list);
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

void k_poll_event_init(struct k_poll_event *event, uint32_t type, int mode, void *obj)
{
	__ASSERT(mode == K_POLL_MODE_NOTIFY_ONLY, "poll mode %d", mode);
	*event = (struct k_poll_event){.type = (uint8_t)type, .mode = 0, .obj = obj};
}

int k_poll(struct k_poll_event *events, int num_events, k_timeout_t timeout)
{
	bool any_ready = false;

	__ASSERT(native_cpu.isr_depth == 0, "polling in an interrupt");
	for (int i = 0; i < num_events; i++) {
		const uint32_t state = ready_state(&events[i]);

		events[i].state |= (uint8_t)state;
		any_ready = any_ready || state != 0;
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

/* The first poller of the object; when it is awake already, its event only gets the state. */
void poll_notify(sys_dlist_t *events, uint32_t state)
{
	sys_dnode_t *const node = sys_dlist_get(events);

	if (node == NULL) {
		return;
	}

	struct k_poll_event *const event = CONTAINER_OF(node, struct k_poll_event, _node);
	struct k_thread *const thread = event->poller;

	event->poller = NULL;
	event->state |= (uint8_t)state;
	if (thread->base.pended_on == &pollers) {
		sched_wake(thread, state == K_POLL_STATE_CANCELLED ? -EINTR : 0, NULL);
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
	poll_notify(&sig->poll_events, K_POLL_STATE_SIGNALED);
	sched_reschedule();
	return 0;
}
