/* SPDX-License-Identifier: Apache-2.0 */
/* Semaphores and mutexes. */
#include "helper.h"

static K_THREAD_STACK_DEFINE(stack_a, HELPER_STACK_SIZE);
static K_THREAD_STACK_DEFINE(stack_b, HELPER_STACK_SIZE);
static struct k_thread thread_a, thread_b;

static struct k_sem sem;
static struct k_mutex mutex;
static volatile int result_a;

static void start(struct k_thread *thread, k_thread_stack_t *stack, k_thread_entry_t entry,
                  char letter, int prio)
{
	k_thread_create(thread, stack, HELPER_STACK_SIZE, entry, (void *)(uintptr_t)letter, NULL,
	                NULL, prio, 0, K_NO_WAIT);
}

static void begin(void *fixture)
{
	helper_begin();
	k_mutex_init(&mutex);
}

static void end_threads(void *fixture)
{
	helper_abort(&thread_a);
	helper_abort(&thread_b);
}

static void take_and_note(void *p1, void *p2, void *p3)
{
	result_a = k_sem_take(&sem, K_FOREVER);
	helper_note((char)(uintptr_t)p1);
}

ZTEST(kernel_sync, test_sem_limits)
{
	zassert_equal(k_sem_init(&sem, 0, 0), -EINVAL);
	zassert_equal(k_sem_init(&sem, 3, 2), -EINVAL);
	zassert_equal(k_sem_init(&sem, 1, 2), 0);
	k_sem_give(&sem);
	k_sem_give(&sem);
	zassert_equal(k_sem_count_get(&sem), 2);
	zassert_ok(k_sem_take(&sem, K_NO_WAIT));
	zassert_ok(k_sem_take(&sem, K_NO_WAIT));
	zassert_equal(k_sem_take(&sem, K_NO_WAIT), -EBUSY);
}

ZTEST(kernel_sync, test_sem_timeout)
{
	k_sem_init(&sem, 0, 1);

	const int64_t at = k_uptime_ticks();

	zassert_equal(k_sem_take(&sem, K_TICKS(7)), -EAGAIN);
	zassert_between_inclusive(k_uptime_ticks() - at, 7, 8);
}

ZTEST(kernel_sync, test_sem_wakes_by_priority_not_by_arrival)
{
	k_sem_init(&sem, 0, 2);
	start(&thread_a, stack_a, take_and_note, 'l', PRIO_HIGH + 1);
	start(&thread_b, stack_b, take_and_note, 'h', PRIO_HIGH);
	k_sem_give(&sem);
	helper_expect("h");
	k_sem_give(&sem);
	helper_expect("hl");
	zassert_equal(k_sem_count_get(&sem), 0);
}

ZTEST(kernel_sync, test_sem_reset_ends_waits)
{
	k_sem_init(&sem, 0, 2);
	start(&thread_a, stack_a, take_and_note, 'a', PRIO_HIGH);
	k_sem_reset(&sem);
	helper_expect("a");
	zassert_equal(result_a, -EAGAIN);
}

static void lock_and_note(void *p1, void *p2, void *p3)
{
	result_a = k_mutex_lock(&mutex, K_FOREVER);
	helper_note((char)(uintptr_t)p1);
	k_mutex_unlock(&mutex);
}

static void lock_briefly(void *p1, void *p2, void *p3)
{
	result_a = k_mutex_lock(&mutex, K_TICKS(5));
}

static void unlock_foreign(void *p1, void *p2, void *p3)
{
	result_a = k_mutex_unlock(&mutex);
	helper_note(k_mutex_lock(&mutex, K_NO_WAIT) == -EBUSY ? 'b' : '?');
}

ZTEST(kernel_sync, test_mutex_is_recursive)
{
	zassert_equal(k_mutex_unlock(&mutex), -EINVAL);
	zassert_ok(k_mutex_lock(&mutex, K_FOREVER));
	zassert_ok(k_mutex_lock(&mutex, K_NO_WAIT));
	zassert_ok(k_mutex_unlock(&mutex));
	start(&thread_a, stack_a, unlock_foreign, 0, PRIO_HIGH);
	zassert_equal(result_a, -EPERM);
	helper_expect("b");
	zassert_ok(k_mutex_unlock(&mutex));
	zassert_equal(k_mutex_unlock(&mutex), -EINVAL);
}

ZTEST(kernel_sync, test_mutex_owner_inherits_priority)
{
	zassert_ok(k_mutex_lock(&mutex, K_FOREVER));
	start(&thread_a, stack_a, lock_and_note, 'a', PRIO_HIGH);
	zassert_equal(k_thread_priority_get(k_current_get()), PRIO_HIGH);
	start(&thread_b, stack_b, lock_and_note, 'b', PRIO_HIGH - 1);
	zassert_equal(k_thread_priority_get(k_current_get()), PRIO_HIGH - 1);
	helper_expect("");
	zassert_ok(k_mutex_unlock(&mutex));
	helper_expect("ba");
	zassert_equal(k_thread_priority_get(k_current_get()), PRIO_TEST);
}

ZTEST(kernel_sync, test_mutex_inheritance_ends_with_the_waiters_timeout)
{
	zassert_ok(k_mutex_lock(&mutex, K_FOREVER));
	start(&thread_a, stack_a, lock_briefly, 'a', PRIO_HIGH);
	zassert_equal(k_thread_priority_get(k_current_get()), PRIO_HIGH);
	k_sleep(K_TICKS(10));
	zassert_equal(result_a, -EAGAIN);
	zassert_equal(k_thread_priority_get(k_current_get()), PRIO_TEST);
	zassert_ok(k_mutex_unlock(&mutex));
}

ZTEST_SUITE(kernel_sync, NULL, NULL, begin, end_threads, NULL);
