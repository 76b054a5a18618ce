/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Work queues. A work item runs in its queue's thread, once for all submissions made before it
 * begins; items of one queue run in the order of submission. Submitting and scheduling: any
 * context.
 */
#ifndef ZEPHYR_KERNEL_WORK_H_
#define ZEPHYR_KERNEL_WORK_H_

#include <zephyr/kernel/sync.h>
#include <zephyr/sys/slist.h>

struct k_work;
struct k_work_q;
typedef void (*k_work_handler_t)(struct k_work *work);

enum {
	K_WORK_RUNNING_BIT = 0,
	K_WORK_QUEUED_BIT = 2,
	K_WORK_DELAYED_BIT = 3,
	K_WORK_DELAYABLE_BIT = 8,

	K_WORK_RUNNING = 1 << K_WORK_RUNNING_BIT,
	K_WORK_QUEUED = 1 << K_WORK_QUEUED_BIT,
	K_WORK_DELAYED = 1 << K_WORK_DELAYED_BIT,
	K_WORK_DELAYABLE = 1 << K_WORK_DELAYABLE_BIT,
	K_WORK_MASK = K_WORK_RUNNING | K_WORK_QUEUED | K_WORK_DELAYED,

	K_WORK_QUEUE_STARTED = 1 << 0,
	K_WORK_QUEUE_NO_YIELD = 1 << 8,
};

struct k_work {
	sys_snode_t node;
	k_work_handler_t handler;
	struct k_work_q *queue; /* the last one used */
	uint32_t flags;
};

struct k_work_delayable {
	struct k_work work;
	struct _timeout timeout;
	struct k_work_q *queue;
};

struct k_work_queue_config {
	const char *name;
	bool no_yield; /* do not yield between two items */
};

struct k_work_q {
	struct k_thread thread;
	sys_slist_t pending;
	_wait_q_t notifyq; /* its thread, when there is nothing to do */
	uint32_t flags;
};

extern struct k_work_q k_sys_work_q;

#define Z_WORK_INITIALIZER(work_handler)                                                           \
	{                                                                                          \
		.handler = (work_handler)                                                          \
	}
#define K_WORK_DEFINE(work, work_handler) struct k_work work = Z_WORK_INITIALIZER(work_handler)
#define Z_WORK_DELAYABLE_INITIALIZER(work_handler)                                                 \
	{                                                                                          \
		.work = {.handler = (work_handler), .flags = K_WORK_DELAYABLE }                    \
	}
#define K_WORK_DELAYABLE_DEFINE(work, work_handler)                                                \
	struct k_work_delayable work = Z_WORK_DELAYABLE_INITIALIZER(work_handler)

void k_work_init(struct k_work *work, k_work_handler_t handler);
/* K_WORK_RUNNING, … of this moment. */
int k_work_busy_get(const struct k_work *work);
/*
 * 0: queued already. 1: queued. 2: running, and queued again there. -EINVAL: no queue. -ENODEV: the
 * queue was not started.
 */
int k_work_submit_to_queue(struct k_work_q *queue, struct k_work *work);
int k_work_submit(struct k_work *work);

static inline bool k_work_is_pending(const struct k_work *work)
{
	return k_work_busy_get(work) != 0;
}

void k_work_queue_init(struct k_work_q *queue);
void k_work_queue_start(struct k_work_q *queue, k_thread_stack_t *stack, size_t stack_size,
                        int prio, const struct k_work_queue_config *cfg);

static inline k_tid_t k_work_queue_thread_get(struct k_work_q *queue)
{
	return &queue->thread;
}

void k_work_init_delayable(struct k_work_delayable *dwork, k_work_handler_t handler);
int k_work_delayable_busy_get(const struct k_work_delayable *dwork);
/* Submits after delay. 0: scheduled or queued already, unchanged; otherwise as
 * k_work_submit_to_queue(). */
int k_work_schedule_for_queue(struct k_work_q *queue, struct k_work_delayable *dwork,
                              k_timeout_t delay);
int k_work_schedule(struct k_work_delayable *dwork, k_timeout_t delay);
/* As above, but replaces an earlier schedule. */
int k_work_reschedule_for_queue(struct k_work_q *queue, struct k_work_delayable *dwork,
                                k_timeout_t delay);
int k_work_reschedule(struct k_work_delayable *dwork, k_timeout_t delay);

static inline bool k_work_delayable_is_pending(const struct k_work_delayable *dwork)
{
	return k_work_delayable_busy_get(dwork) != 0;
}

static inline struct k_work_delayable *k_work_delayable_from_work(struct k_work *work)
{
	return CONTAINER_OF(work, struct k_work_delayable, work);
}

#endif
