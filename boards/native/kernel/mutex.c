/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

int k_mutex_init(struct k_mutex *mutex)
{
	mutex->owner = NULL;
	mutex->lock_count = 0;
	wait_q_init(&mutex->wait_q);
	return 0;
}

static void set_owner_prio(struct k_mutex *mutex, int prio)
{
	if (mutex->owner->base.prio != prio) {
		sched_set_prio(mutex->owner, prio);
	}
}

/* The owner runs as urgently as the most urgent waiter, but not above the ceiling. */
static int inherited_prio(const struct k_mutex *mutex, int waiter_prio)
{
	return MIN(mutex->owner_orig_prio, MAX(waiter_prio, CONFIG_PRIORITY_CEILING));
}

static void take(struct k_mutex *mutex, struct k_thread *owner)
{
	mutex->owner = owner;
	mutex->lock_count = 1;
	mutex->owner_orig_prio = owner->base.prio;
}

int k_mutex_lock(struct k_mutex *mutex, k_timeout_t timeout)
{
	struct k_thread *const self = sched_current;

	__ASSERT(native_cpu.isr_depth == 0, "a mutex in an interrupt");
	if (mutex->lock_count == 0) {
		take(mutex, self);
		return 0;
	}
	if (mutex->owner == self) {
		mutex->lock_count++;
		return 0;
	}
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return -EBUSY;
	}
	if (self->base.prio < mutex->owner->base.prio) {
		set_owner_prio(mutex, inherited_prio(mutex, self->base.prio));
	}
	if (sched_pend(&mutex->wait_q, timeout) == 0) {
		return 0;
	}

	/* Timed out: the owner keeps only what the waiters that are left give it. */
	if (mutex->owner != NULL) {
		const struct k_thread *waiter = wait_q_head(&mutex->wait_q);

		set_owner_prio(mutex, waiter == NULL ? mutex->owner_orig_prio
		                                     : inherited_prio(mutex, waiter->base.prio));
		sched_reschedule();
	}
	return -EAGAIN;
}

int k_mutex_unlock(struct k_mutex *mutex)
{
	__ASSERT(native_cpu.isr_depth == 0, "a mutex in an interrupt");
	if (mutex->owner == NULL) {
		return -EINVAL;
	}
	if (mutex->owner != sched_current) {
		return -EPERM;
	}
	if (mutex->lock_count > 1) {
		mutex->lock_count--;
		return 0;
	}
	set_owner_prio(mutex, mutex->owner_orig_prio);

	struct k_thread *next = wait_q_head(&mutex->wait_q);

	if (next == NULL) {
		mutex->owner = NULL;
		mutex->lock_count = 0;
	} else {
		take(mutex, next);
		sched_wake(next, 0, NULL);
		next = wait_q_head(&mutex->wait_q);
		if (next != NULL) {
			set_owner_prio(mutex, inherited_prio(mutex, next->base.prio));
		}
	}
	sched_reschedule();
	return 0;
}
