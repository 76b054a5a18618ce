/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

struct k_work_q k_sys_work_q;

/* Calls that wait for a running item to end. */
static sys_slist_t cancellers = SYS_SLIST_STATIC_INIT(&cancellers);

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
	if ((queue->flags & K_WORK_QUEUE_STARTED) == 0) {
		return -ENODEV;
	}

	const bool chained = sched_current == &queue->thread && native_cpu.isr_depth == 0;

	if ((queue->flags & K_WORK_QUEUE_DRAIN) != 0) {
		return chained ? 0 : -EBUSY;
	}
	return (queue->flags & K_WORK_QUEUE_PLUGGED) != 0 ? -EBUSY : 0;
}

/* A running item goes to the queue that runs it, so that it never runs twice at once. */
static int submit(struct k_work_q *queue, struct k_work *work)
{
	if ((work->flags & K_WORK_CANCELING) != 0) {
		return -EBUSY;
	}
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

static void flushed(struct k_work *work)
{
	k_sem_give(&CONTAINER_OF(work, struct z_work_flusher, work)->sem);
}

/* A marker right behind the item, or at the head while the item runs, tells when it is done. */
static bool flush(struct k_work *work, struct z_work_flusher *flusher)
{
	if ((work->flags & (K_WORK_QUEUED | K_WORK_RUNNING)) == 0) {
		return false;
	}

	struct k_work_q *const queue = work->queue;
	const bool queued = (work->flags & K_WORK_QUEUED) != 0;

	k_work_init(&flusher->work, flushed);
	(void)k_sem_init(&flusher->sem, 0, 1);
	sys_slist_insert(&queue->pending, queued ? &work->node : NULL, &flusher->work.node);
	(void)sched_wake_first(&queue->notifyq, 0, NULL);
	(void)k_sem_take(&flusher->sem, K_FOREVER);
	return true;
}

bool k_work_flush(struct k_work *work, struct k_work_sync *sync)
{
	__ASSERT(native_cpu.isr_depth == 0, "flushing in an interrupt");
	return flush(work, &sync->flusher);
}

int k_work_cancel(struct k_work *work)
{
	if ((work->flags & (K_WORK_CANCELING | K_WORK_QUEUED)) == K_WORK_QUEUED) {
		(void)sys_slist_find_and_remove(&work->queue->pending, &work->node);
		work->flags &= ~(uint32_t)K_WORK_QUEUED;
	}
	if (k_work_busy_get(work) != 0) {
		work->flags |= K_WORK_CANCELING;
	}
	return k_work_busy_get(work);
}

static bool cancel_sync(struct k_work *work, struct z_work_canceller *canceller, bool was_busy)
{
	__ASSERT(native_cpu.isr_depth == 0, "waiting in an interrupt");
	if (was_busy && k_work_cancel(work) != 0) {
		(void)k_sem_init(&canceller->sem, 0, 1);
		canceller->work = work;
		sys_slist_append(&cancellers, &canceller->node);
		(void)k_sem_take(&canceller->sem, K_FOREVER);
	}
	return was_busy;
}

bool k_work_cancel_sync(struct k_work *work, struct k_work_sync *sync)
{
	return cancel_sync(work, &sync->canceller, k_work_busy_get(work) != 0);
}

/* Interrupts are locked so that those who are woken run only after the work thread's own state is
 * right. */
static void finish(struct k_work_q *queue, struct k_work *work)
{
	const unsigned int key = irq_lock();
	struct z_work_canceller *canceller, *next;
	sys_snode_t *prev = NULL;

	work->flags &= ~(uint32_t)K_WORK_RUNNING;
	if ((work->flags & K_WORK_CANCELING) != 0) {
		work->flags &= ~(uint32_t)K_WORK_CANCELING;
		SYS_SLIST_FOR_EACH_CONTAINER_SAFE(&cancellers, canceller, next, node) {
			if (canceller->work == work) {
				sys_slist_remove(&cancellers, prev, &canceller->node);
				k_sem_give(&canceller->sem);
			} else {
				prev = &canceller->node;
			}
		}
	}
	queue->flags &= ~(uint32_t)K_WORK_QUEUE_BUSY;
	irq_unlock(key);
}

static void work_queue_main(void *p1, void *p2, void *p3)
{
	struct k_work_q *const queue = p1;

	ARG_UNUSED(p2);
	ARG_UNUSED(p3);
	while (true) {
		sys_snode_t *const node = sys_slist_get(&queue->pending);

		if (node == NULL) {
			if ((queue->flags & K_WORK_QUEUE_DRAIN) != 0) {
				queue->flags &= ~(uint32_t)K_WORK_QUEUE_DRAIN;
				(void)sched_wake_all(&queue->drainq, 1);
			}
			(void)sched_pend(&queue->notifyq, K_FOREVER);
			continue;
		}

		struct k_work *const work = CONTAINER_OF(node, struct k_work, node);

		queue->flags |= K_WORK_QUEUE_BUSY;
		work->flags = (work->flags | K_WORK_RUNNING) & ~(uint32_t)K_WORK_QUEUED;
		work->handler(work);
		finish(queue, work);
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
	wait_q_init(&queue->drainq);
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

int k_work_queue_drain(struct k_work_q *queue, bool plug)
{
	const bool busy = (queue->flags & (K_WORK_QUEUE_BUSY | K_WORK_QUEUE_DRAIN)) != 0 ||
	                  !sys_slist_is_empty(&queue->pending);

	__ASSERT(native_cpu.isr_depth == 0, "draining in an interrupt");
	if (!busy && !plug) {
		return 0;
	}
	queue->flags |= K_WORK_QUEUE_DRAIN | (plug ? K_WORK_QUEUE_PLUGGED : 0U);
	(void)sched_wake_first(&queue->notifyq, 0, NULL);
	return sched_pend(&queue->drainq, K_FOREVER);
}

int k_work_queue_unplug(struct k_work_q *queue)
{
	if ((queue->flags & K_WORK_QUEUE_PLUGGED) == 0) {
		return -EALREADY;
	}
	queue->flags &= ~(uint32_t)K_WORK_QUEUE_PLUGGED;
	return 0;
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

static bool unschedule(struct k_work_delayable *dwork)
{
	dwork->work.flags &= ~(uint32_t)K_WORK_DELAYED;
	return timeout_abort(&dwork->timeout);
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
	(void)unschedule(dwork);
	return schedule(queue, dwork, delay);
}

int k_work_reschedule(struct k_work_delayable *dwork, k_timeout_t delay)
{
	return k_work_reschedule_for_queue(&k_sys_work_q, dwork, delay);
}

bool k_work_flush_delayable(struct k_work_delayable *dwork, struct k_work_sync *sync)
{
	__ASSERT(native_cpu.isr_depth == 0, "flushing in an interrupt");
	if (k_work_delayable_busy_get(dwork) == 0) {
		return false;
	}
	if (unschedule(dwork)) {
		(void)submit(dwork->queue, &dwork->work);
	}
	return flush(&dwork->work, &sync->flusher);
}

int k_work_cancel_delayable(struct k_work_delayable *dwork)
{
	(void)unschedule(dwork);
	return k_work_cancel(&dwork->work);
}

bool k_work_cancel_delayable_sync(struct k_work_delayable *dwork, struct k_work_sync *sync)
{
	const bool was_busy = k_work_delayable_busy_get(dwork) != 0;

	(void)unschedule(dwork);
	return cancel_sync(&dwork->work, &sync->canceller, was_busy);
}

k_ticks_t k_work_delayable_expires_get(const struct k_work_delayable *dwork)
{
	return timeout_expires(&dwork->timeout);
}

k_ticks_t k_work_delayable_remaining_get(const struct k_work_delayable *dwork)
{
	return timeout_remaining(&dwork->timeout);
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
