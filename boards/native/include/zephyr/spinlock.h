/* SPDX-License-Identifier: Apache-2.0 */
/* On one CPU a spin lock locks interrupts. Taking it twice, or releasing it when it is free, is a
 * fatal error. */
#ifndef ZEPHYR_SPINLOCK_H_
#define ZEPHYR_SPINLOCK_H_

#include <errno.h>
#include <stdbool.h>
#include <stddef.h>

#include <zephyr/irq.h>
#include <zephyr/sys/__assert.h>

struct k_spinlock {
	bool locked;
};

struct z_spinlock_key {
	unsigned int key;
};

typedef struct z_spinlock_key k_spinlock_key_t;

static ALWAYS_INLINE k_spinlock_key_t k_spin_lock(struct k_spinlock *lock)
{
	const k_spinlock_key_t key = {.key = irq_lock()};

	__ASSERT(!lock->locked, "spin lock %p is taken already", (void *)lock);
	lock->locked = true;
	return key;
}

static ALWAYS_INLINE int k_spin_trylock(struct k_spinlock *lock, k_spinlock_key_t *key)
{
	if (lock->locked) {
		return -EBUSY;
	}
	*key = k_spin_lock(lock);
	return 0;
}

static ALWAYS_INLINE void k_spin_unlock(struct k_spinlock *lock, k_spinlock_key_t key)
{
	__ASSERT(lock->locked, "spin lock %p is not taken", (void *)lock);
	lock->locked = false;
	irq_unlock(key.key);
}

static ALWAYS_INLINE bool k_spin_is_locked(struct k_spinlock *lock)
{
	return lock->locked;
}

#define K_SPINLOCK(lck)                                                                            \
	for (k_spinlock_key_t native_key = k_spin_lock(lck), *native_once = &native_key;           \
	     native_once != NULL; k_spin_unlock(lck, native_key), native_once = NULL)

#endif
