/* SPDX-License-Identifier: Apache-2.0 */
/* Threads and the scheduler. */
#include "helper.h"

static K_THREAD_STACK_DEFINE(stack_a, HELPER_STACK_SIZE);
static K_THREAD_STACK_DEFINE(stack_b, HELPER_STACK_SIZE);
static struct k_thread thread_a, thread_b;

static void note_once(void *p1, void *p2, void *p3)
{
	helper_note((char)(uintptr_t)p1);
}

static void note_yield_note(void *p1, void *p2, void *p3)
{
	helper_note((char)(uintptr_t)p1);
	k_yield();
	helper_note((char)(uintptr_t)p1);
}

static void note_sleep_note(void *p1, void *p2, void *p3)
{
	helper_note((char)(uintptr_t)p1);
	k_sleep(K_TICKS(10));
	helper_note((char)(uintptr_t)p1);
}

static k_tid_t start_a(k_thread_entry_t entry, char letter, int prio, k_timeout_t delay)
{
	return k_thread_create(&thread_a, stack_a, K_THREAD_STACK_SIZEOF(stack_a), entry,
	                       (void *)(uintptr_t)letter, NULL, NULL, prio, 0, delay);
}

static k_tid_t start_b(k_thread_entry_t entry, char letter, int prio, k_timeout_t delay)
{
	return k_thread_create(&thread_b, stack_b, K_THREAD_STACK_SIZEOF(stack_b), entry,
	                       (void *)(uintptr_t)letter, NULL, NULL, prio, 0, delay);
}

static void end_threads(void *fixture)
{
	helper_abort(&thread_a);
	helper_abort(&thread_b);
}

ZTEST(kernel_thread, test_urgent_thread_runs_inside_create)
{
	helper_begin();
	start_a(note_once, 'a', PRIO_HIGH, K_NO_WAIT);
	helper_note('t');
	helper_expect("at");
	start_b(note_once, 'b', PRIO_LOW, K_NO_WAIT);
	helper_note('t');
	helper_expect("att");
	zassert_ok(k_thread_join(&thread_b, K_FOREVER));
	helper_expect("attb");
}

ZTEST(kernel_thread, test_equal_priority_is_first_come_first_served)
{
	helper_begin();
	start_a(note_yield_note, 'a', PRIO_TEST, K_NO_WAIT);
	start_b(note_yield_note, 'b', PRIO_TEST, K_NO_WAIT);
	helper_note('t');
	k_yield();
	helper_note('t');
	k_yield();
	helper_expect("tabtab");
}

ZTEST(kernel_thread, test_cooperative_thread_is_not_preempted)
{
	helper_begin();
	k_thread_priority_set(k_current_get(), K_PRIO_COOP(10));
	start_a(note_once, 'a', K_PRIO_COOP(5), K_NO_WAIT);
	helper_note('t');
	k_yield();
	helper_expect("ta");
}

ZTEST(kernel_thread, test_sched_lock_defers_preemption)
{
	helper_begin();
	k_sched_lock();
	start_a(note_once, 'a', PRIO_HIGH, K_NO_WAIT);
	helper_note('t');
	k_sched_unlock();
	helper_note('u');
	helper_expect("tau");
}

ZTEST(kernel_thread, test_delayed_start)
{
	helper_begin();

	const int64_t begin = k_uptime_ticks();

	start_a(note_once, 'a', PRIO_HIGH, K_TICKS(20));
	helper_expect("");
	zassert_ok(k_thread_join(&thread_a, K_FOREVER));
	zassert_between_inclusive(k_uptime_ticks() - begin, 20, 21);
	helper_expect("a");
}

ZTEST(kernel_thread, test_start_of_a_thread_without_a_date)
{
	helper_begin();
	start_a(note_once, 'a', PRIO_HIGH, K_FOREVER);
	k_sleep(K_TICKS(5));
	helper_expect("");
	k_thread_start(&thread_a);
	helper_expect("a");
}

ZTEST(kernel_thread, test_suspend_and_resume)
{
	helper_begin();
	start_a(note_yield_note, 'a', PRIO_LOW, K_NO_WAIT);
	k_thread_suspend(&thread_a);
	k_sleep(K_TICKS(5));
	helper_expect("");
	k_thread_resume(&thread_a);
	k_sleep(K_TICKS(5));
	helper_expect("aa");
}

ZTEST(kernel_thread, test_join_results)
{
	helper_begin();
	start_a(note_sleep_note, 'a', PRIO_HIGH, K_NO_WAIT);
	zassert_equal(k_thread_join(&thread_a, K_NO_WAIT), -EBUSY);
	zassert_equal(k_thread_join(&thread_a, K_TICKS(2)), -EAGAIN);
	zassert_equal(k_thread_join(k_current_get(), K_FOREVER), -EDEADLK);
	zassert_equal(k_thread_join(&thread_a, K_FOREVER), 0);
	zassert_equal(k_thread_join(&thread_a, K_NO_WAIT), 0);
	helper_expect("aa");
}

ZTEST(kernel_thread, test_abort_wakes_the_joiner)
{
	helper_begin();
	start_a(note_sleep_note, 'a', PRIO_HIGH, K_NO_WAIT);
	start_b(note_sleep_note, 'b', PRIO_HIGH, K_NO_WAIT);
	k_thread_abort(&thread_a);
	zassert_ok(k_thread_join(&thread_a, K_NO_WAIT));
	zassert_ok(k_thread_join(&thread_b, K_FOREVER));
	helper_expect("abb");
}

ZTEST(kernel_thread, test_raised_priority_preempts)
{
	helper_begin();
	start_a(note_once, 'a', PRIO_LOW, K_NO_WAIT);
	helper_note('t');
	k_thread_priority_set(&thread_a, PRIO_HIGH);
	helper_note('t');
	helper_expect("tat");
}

ZTEST(kernel_thread, test_own_priority_lowered_below_another)
{
	helper_begin();
	start_a(note_once, 'a', PRIO_LOW, K_NO_WAIT);
	k_thread_priority_set(k_current_get(), PRIO_LOW + 1);
	helper_note('t');
	helper_expect("at");
	zassert_equal(k_thread_priority_get(k_current_get()), PRIO_LOW + 1);
}

ZTEST(kernel_thread, test_sleep_lasts_at_least_as_long_as_asked)
{
	helper_begin();

	const int64_t begin = k_uptime_ticks();

	zassert_equal(k_sleep(K_TICKS(10)), 0);
	zassert_between_inclusive(k_uptime_ticks() - begin, 10, 11);
}

static void wake_after_sleep(void *p1, void *p2, void *p3)
{
	k_msleep(20);
	k_wakeup(p1);
}

ZTEST(kernel_thread, test_wakeup_returns_the_rest)
{
	helper_begin();
	k_thread_create(&thread_a, stack_a, K_THREAD_STACK_SIZEOF(stack_a), wake_after_sleep,
	                k_current_get(), NULL, NULL, PRIO_HIGH, 0, K_NO_WAIT);
	zassert_within(k_msleep(100), 80, 1);
}

ZTEST(kernel_thread, test_name)
{
	helper_begin();
	zassert_ok(k_thread_name_set(k_current_get(), "probe"));
	zassert_equal(strcmp(k_thread_name_get(k_current_get()), "probe"), 0);
}

static struct k_sem sem;

static void isr_give(const void *arg)
{
	zassert_true(k_is_in_isr());
	k_sem_give(&sem);
	helper_note('i');
}

static void take_and_note(void *p1, void *p2, void *p3)
{
	zassert_ok(k_sem_take(&sem, K_FOREVER));
	helper_note('a');
}

ZTEST(kernel_thread, test_isr_preempts_at_its_end)
{
	helper_begin();
	k_sem_init(&sem, 0, 1);
	start_a(take_and_note, 'a', PRIO_HIGH, K_NO_WAIT);
	zassert_false(k_is_in_isr());
	irq_offload(isr_give, NULL);
	helper_note('t');
	helper_expect("iat");
}

ZTEST(kernel_thread, test_irq_lock_belongs_to_the_thread)
{
	helper_begin();
	k_sem_init(&sem, 0, 1);
	start_a(take_and_note, 'a', PRIO_HIGH, K_NO_WAIT);

	const unsigned int key = irq_lock();

	k_sem_give(&sem);
	helper_note('t');
	helper_expect("t");
	k_sleep(K_TICKS(2));
	helper_expect("ta");
	irq_unlock(key);
}

ZTEST_SUITE(kernel_thread, NULL, NULL, NULL, end_threads, NULL);
