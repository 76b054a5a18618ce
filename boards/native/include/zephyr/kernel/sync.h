/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Semaphores and mutexes.
 *
 * Waiting functions: threads only, unless the timeout is K_NO_WAIT; waiters are served by priority,
 * then first come.
 */
#ifndef ZEPHYR_KERNEL_SYNC_H_
#define ZEPHYR_KERNEL_SYNC_H_

#include <zephyr/kernel/thread.h>

struct k_sem {
	_wait_q_t wait_q;
	unsigned int count;
	unsigned int limit;
};

#define K_SEM_MAX_LIMIT UINT_MAX
#define Z_SEM_INITIALIZER(obj, initial_count, count_limit)                                         \
	{                                                                                          \
		.wait_q = Z_WAIT_Q_INIT(&(obj).wait_q), .count = (initial_count),                  \
		.limit = (count_limit)                                                             \
	}
#define K_SEM_DEFINE(name, initial_count, count_limit)                                             \
	struct k_sem name = Z_SEM_INITIALIZER(name, initial_count, count_limit);                   \
	BUILD_ASSERT((count_limit) != 0 && (initial_count) <= (count_limit), "semaphore's limits")

/* -EINVAL: limit is 0 or below initial_count. */
int k_sem_init(struct k_sem *sem, unsigned int initial_count, unsigned int limit);
/* 0; -EBUSY: none left and K_NO_WAIT; -EAGAIN: timeout or k_sem_reset(). */
int k_sem_take(struct k_sem *sem, k_timeout_t timeout);
/* Any context. No effect at the limit. */
void k_sem_give(struct k_sem *sem);
void k_sem_reset(struct k_sem *sem);

static inline unsigned int k_sem_count_get(struct k_sem *sem)
{
	return sem->count;
}

struct k_mutex {
	_wait_q_t wait_q;
	struct k_thread *owner;
	uint32_t lock_count;
	int owner_orig_prio;
};

#define Z_MUTEX_INITIALIZER(obj)                                                                   \
	{                                                                                          \
		.wait_q = Z_WAIT_Q_INIT(&(obj).wait_q), .owner = NULL, .lock_count = 0,            \
		.owner_orig_prio = K_LOWEST_APPLICATION_THREAD_PRIO                                \
	}
#define K_MUTEX_DEFINE(name) struct k_mutex name = Z_MUTEX_INITIALIZER(name)

/* Recursive, with priority inheritance. Threads only. */
int k_mutex_init(struct k_mutex *mutex);
/* 0; -EBUSY: K_NO_WAIT and owned by another; -EAGAIN: timeout. */
int k_mutex_lock(struct k_mutex *mutex, k_timeout_t timeout);
/* 0; -EPERM: owned by another; -EINVAL: not locked. */
int k_mutex_unlock(struct k_mutex *mutex);

#endif
