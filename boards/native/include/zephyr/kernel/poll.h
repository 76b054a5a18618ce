/* SPDX-License-Identifier: Apache-2.0 */
/* Waiting for the first of several signals. */
#ifndef ZEPHYR_KERNEL_POLL_H_
#define ZEPHYR_KERNEL_POLL_H_

#include <zephyr/kernel/thread.h>

#define K_POLL_TYPE_SIGNAL BIT(0)

enum k_poll_modes {
	K_POLL_MODE_NOTIFY_ONLY,
	K_POLL_NUM_MODES
};

#define K_POLL_STATE_NOT_READY 0
#define K_POLL_STATE_SIGNALED  BIT(0)

struct k_poll_signal {
	sys_dlist_t poll_events;
	unsigned int signaled;
	int result;
};

#define K_POLL_SIGNAL_INITIALIZER(obj)                                                             \
	{                                                                                          \
		.poll_events = SYS_DLIST_STATIC_INIT(&(obj).poll_events), .signaled = 0,           \
		.result = 0                                                                        \
	}

struct k_poll_event {
	sys_dnode_t _node; /* in the signal's list while a thread polls */
	struct k_thread *poller;
	uint32_t type : 8;
	uint32_t state : 8;
	uint32_t mode : 1;
	struct k_poll_signal *signal;
};

#define K_POLL_EVENT_INITIALIZER(event_type, event_mode, event_obj)                                \
	{                                                                                          \
		.type = (event_type), .state = K_POLL_STATE_NOT_READY, .mode = (event_mode),       \
		.signal = (event_obj)                                                              \
	}

/* 0: the events of signals that are raised say so; whoever called sets them back, and the signals.
 * -EAGAIN: timeout. Threads only.
 */
int k_poll(struct k_poll_event *events, int num_events, k_timeout_t timeout);

void k_poll_signal_init(struct k_poll_signal *sig);
void k_poll_signal_reset(struct k_poll_signal *sig);
void k_poll_signal_check(struct k_poll_signal *sig, unsigned int *signaled, int *result);
/* 0. Any context. */
int k_poll_signal_raise(struct k_poll_signal *sig, int result);

#endif
