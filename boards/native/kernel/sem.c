/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

int k_sem_init(struct k_sem *sem, unsigned int initial_count, unsigned int limit)
{
	if (limit == 0 || initial_count > limit) {
		return -EINVAL;
	}
	sem->count = initial_count;
	sem->limit = limit;
	wait_q_init(&sem->wait_q);
	return 0;
}

int k_sem_take(struct k_sem *sem, k_timeout_t timeout)
{
	if (sem->count > 0) {
		sem->count--;
		return 0;
	}
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return -EBUSY;
	}
	return sched_pend(&sem->wait_q, timeout);
}

void k_sem_give(struct k_sem *sem)
{
	if (!sched_wake_first(&sem->wait_q, 0, NULL)) {
		sem->count += sem->count < sem->limit ? 1 : 0;
	}
	sched_reschedule();
}

void k_sem_reset(struct k_sem *sem)
{
	(void)sched_wake_all(&sem->wait_q, -EAGAIN);
	sem->count = 0;
	sched_reschedule();
}
