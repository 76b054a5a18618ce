/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Waiting for the first of several objects. k_poll() takes nothing: after it, the caller tries each
 * object whose event's state is set, and sets the states back to K_POLL_STATE_NOT_READY.
 */
#ifndef ZEPHYR_KERNEL_POLL_H_
#define ZEPHYR_KERNEL_POLL_H_

#include <zephyr/kernel/queue.h>
#include <zephyr/kernel/sync.h>

#define K_POLL_TYPE_IGNORE              0
#define K_POLL_TYPE_SIGNAL              BIT(0)
#define K_POLL_TYPE_SEM_AVAILABLE       BIT(1)
#define K_POLL_TYPE_DATA_AVAILABLE      BIT(2)
#define K_POLL_TYPE_FIFO_DATA_AVAILABLE K_POLL_TYPE_DATA_AVAILABLE
#define K_POLL_TYPE_MSGQ_DATA_AVAILABLE BIT(3)

enum k_poll_modes {
	K_POLL_MODE_NOTIFY_ONLY,
	K_POLL_NUM_MODES
};

#define K_POLL_STATE_NOT_READY           0
#define K_POLL_STATE_SIGNALED            BIT(0)
#define K_POLL_STATE_SEM_AVAILABLE       BIT(1)
#define K_POLL_STATE_DATA_AVAILABLE      BIT(2)
#define K_POLL_STATE_FIFO_DATA_AVAILABLE K_POLL_STATE_DATA_AVAILABLE
#define K_POLL_STATE_CANCELLED           BIT(3)
#define K_POLL_STATE_MSGQ_DATA_AVAILABLE BIT(4)

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
	sys_dnode_t _node; /* in the object's list while a thread polls */
	struct k_thread *poller;
	uint32_t tag : 8;
	uint32_t type : 8;
	uint32_t state : 8;
	uint32_t mode : 1;
	union {
		void *obj;
		struct k_poll_signal *signal;
		struct k_sem *sem;
		struct k_fifo *fifo;
		struct k_queue *queue;
		struct k_msgq *msgq;
	};
};

#define K_POLL_EVENT_INITIALIZER(event_type, event_mode, event_obj)                                \
	{                                                                                          \
		.type = (event_type), .state = K_POLL_STATE_NOT_READY, .mode = (event_mode),       \
		.obj = (event_obj)                                                                 \
	}
#define K_POLL_EVENT_STATIC_INITIALIZER(event_type, event_mode, event_obj, event_tag)              \
	{                                                                                          \
		.tag = (event_tag), .type = (event_type), .state = K_POLL_STATE_NOT_READY,         \
		.mode = (event_mode), .obj = (event_obj)                                           \
	}

void k_poll_event_init(struct k_poll_event *event, uint32_t type, int mode, void *obj);
/* 0: one or more are ready. -EAGAIN: timeout. -EINTR: a queue's wait was cancelled. Threads only.
 */
int k_poll(struct k_poll_event *events, int num_events, k_timeout_t timeout);

void k_poll_signal_init(struct k_poll_signal *sig);
void k_poll_signal_reset(struct k_poll_signal *sig);
void k_poll_signal_check(struct k_poll_signal *sig, unsigned int *signaled, int *result);
/* 0. Any context. */
int k_poll_signal_raise(struct k_poll_signal *sig, int result);

#endif
