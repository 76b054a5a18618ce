/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

struct k_work_q k_sys_work_q;

void k_work_init(struct k_work *work, k_work_handler_t handler)
{
	__ASSERT(handler != NULL, "a work item without a handler");
	*work = (struct k_work){.handler = handler};
}

int k_work_busy_get(const struct k_work *work)
{
	return (int)(work->flags & K_WORK_MASK);
}

static int queue_accepts(const struct k_work_q *queue)
{
	if (queue == NULL) {
		return -EINVAL;
	}
	return (queue->flags & K_WORK_QUEUE_STARTED) != 0 ? 0 : -ENODEV;
}

/* A running item goes to the queue that runs it, so that it never runs twice at once. */
static int submit(struct k_work_q *queue, struct k_work *work)
{
	if ((work->flags & K_WORK_QUEUED) != 0) {
		return 0;
	}

	const bool running = (work->flags & K_WORK_RUNNING) != 0;
	struct k_work_q *const target = running || queue == NULL ? work->queue : queue;
	const int refused = queue_accepts(target);

	if (refused != 0) {
		return refused;
	}
	work->flags |= K_WORK_QUEUED;
	work->queue = target;
	sys_slist_append(&target->pending, &work->node);
	(void)sched_wake_first(&target->notifyq, 0, NULL);
	return running ? 2 : 1;
}

int k_work_submit_to_queue(struct k_work_q *queue, struct k_work *work)
{
	const int result = submit(queue, work);

	if (result > 0) {
		sched_reschedule();
	}
	return result;
}

int k_work_submit(struct k_work *work)
{
	return k_work_submit_to_queue(&k_sys_work_q, work);
}

static void work_queue_main(void *p1, void *p2, void *p3)
{
	struct k_work_q *const queue = p1;

	ARG_UNUSED(p2);
	ARG_UNUSED(p3);
	while (true) {
		sys_snode_t *const node = sys_slist_get(&queue->pending);

		if (node == NULL) {
			(void)sched_pend(&queue->notifyq, K_FOREVER);
			continue;
		}

		struct k_work *const work = CONTAINER_OF(node, struct k_work, node);

		work->flags = (work->flags | K_WORK_RUNNING) & ~(uint32_t)K_WORK_QUEUED;
		work->handler(work);
		work->flags &= ~(uint32_t)K_WORK_RUNNING;
		if ((queue->flags & K_WORK_QUEUE_NO_YIELD) == 0) {
			k_yield();
		} else {
			sched_reschedule();
		}
	}
}

void k_work_queue_init(struct k_work_q *queue)
{
	*queue = (struct k_work_q){.flags = 0};
}

void k_work_queue_start(struct k_work_q *queue, k_thread_stack_t *stack, size_t stack_size,
                        int prio, const struct k_work_queue_config *cfg)
{
	__ASSERT((queue->flags & K_WORK_QUEUE_STARTED) == 0, "the queue runs already");
	sys_slist_init(&queue->pending);
	wait_q_init(&queue->notifyq);
	queue->flags = K_WORK_QUEUE_STARTED;
	if (cfg != NULL && cfg->no_yield) {
		queue->flags |= K_WORK_QUEUE_NO_YIELD;
	}
	(void)k_thread_create(&queue->thread, stack, stack_size, work_queue_main, queue, NULL, NULL,
	                      prio, 0, K_FOREVER);
	if (cfg != NULL && cfg->name != NULL) {
		(void)k_thread_name_set(&queue->thread, cfg->name);
	}
	k_thread_start(&queue->thread);
}

void k_work_init_delayable(struct k_work_delayable *dwork, k_work_handler_t handler)
{
	__ASSERT(handler != NULL, "a work item without a handler");
	*dwork = (struct k_work_delayable)Z_WORK_DELAYABLE_INITIALIZER(handler);
}

int k_work_delayable_busy_get(const struct k_work_delayable *dwork)
{
	return k_work_busy_get(&dwork->work);
}

static void delay_over(struct _timeout *timeout)
{
	struct k_work_delayable *dwork = CONTAINER_OF(timeout, struct k_work_delayable, timeout);

	dwork->work.flags &= ~(uint32_t)K_WORK_DELAYED;
	(void)submit(dwork->queue, &dwork->work);
}

static int schedule(struct k_work_q *queue, struct k_work_delayable *dwork, k_timeout_t delay)
{
	if (K_TIMEOUT_EQ(delay, K_NO_WAIT)) {
		return k_work_submit_to_queue(queue, &dwork->work);
	}
	dwork->work.flags |= K_WORK_DELAYED;
	dwork->queue = queue;
	timeout_add(&dwork->timeout, delay_over, delay);
	return 1;
}

int k_work_schedule_for_queue(struct k_work_q *queue, struct k_work_delayable *dwork,
                              k_timeout_t delay)
{
	if ((k_work_delayable_busy_get(dwork) & ~K_WORK_RUNNING) != 0) {
		return 0;
	}
	return schedule(queue, dwork, delay);
}

int k_work_schedule(struct k_work_delayable *dwork, k_timeout_t delay)
{
	return k_work_schedule_for_queue(&k_sys_work_q, dwork, delay);
}

int k_work_reschedule_for_queue(struct k_work_q *queue, struct k_work_delayable *dwork,
                                k_timeout_t delay)
{
	dwork->work.flags &= ~(uint32_t)K_WORK_DELAYED;
	(void)timeout_abort(&dwork->timeout);
	return schedule(queue, dwork, delay);
}

int k_work_reschedule(struct k_work_delayable *dwork, k_timeout_t delay)
{
	return k_work_reschedule_for_queue(&k_sys_work_q, dwork, delay);
}

static int start_system_queue(void)
{
	static K_THREAD_STACK_DEFINE(stack, CONFIG_SYSTEM_WORKQUEUE_STACK_SIZE);
	const struct k_work_queue_config config = {
		.name = "sysworkq",
		.no_yield = IS_ENABLED(CONFIG_SYSTEM_WORKQUEUE_NO_YIELD),
	};

	k_work_queue_start(&k_sys_work_q, stack, K_THREAD_STACK_SIZEOF(stack),
	                   CONFIG_SYSTEM_WORKQUEUE_PRIORITY, &config);
	return 0;
}

SYS_INIT(start_system_queue, POST_KERNEL, CONFIG_KERNEL_INIT_PRIORITY_DEFAULT);
