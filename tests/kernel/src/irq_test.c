/* SPDX-License-Identifier: Apache-2.0 */
/* What only the native kernel has: interrupts raised by simulated devices, and stacks that are
 * measured. */
#include <native/irq.h>

#include "helper.h"

static K_THREAD_STACK_DEFINE(stack_a, HELPER_STACK_SIZE);
static struct k_thread thread_a;
static struct k_sem sem;

static void give(void *arg)
{
	zassert_true(k_is_in_isr());
	helper_note('i');
	k_sem_give(&sem);
}

static struct native_irq irq = {.isr = give};

static void raise_twice(void *arg)
{
	native_irq_raise(&irq);
	native_irq_raise(&irq);
	helper_note('o');
}

static struct native_irq outer = {.isr = raise_twice};

static void take_and_note(void *p1, void *p2, void *p3)
{
	zassert_ok(k_sem_take(&sem, K_FOREVER));
	helper_note('a');
}

static void begin(void *fixture)
{
	helper_begin();
	k_sem_init(&sem, 0, 1);
	k_thread_create(&thread_a, stack_a, K_THREAD_STACK_SIZEOF(stack_a), take_and_note, NULL,
	                NULL, NULL, PRIO_HIGH, 0, K_NO_WAIT);
}

static void end_threads(void *fixture)
{
	helper_abort(&thread_a);
}

ZTEST(kernel_irq, test_raise_runs_at_once_and_preempts)
{
	native_irq_raise(&irq);
	helper_note('t');
	helper_expect("iat");
}

ZTEST(kernel_irq, test_locked_interrupt_waits_and_runs_once)
{
	const unsigned int key = irq_lock();

	native_irq_raise(&irq);
	native_irq_raise(&irq);
	helper_expect("");
	irq_unlock(key);
	helper_expect("ia");
}

ZTEST(kernel_irq, test_interrupts_do_not_nest)
{
	native_irq_raise(&outer);
	helper_expect("oia");
}

ZTEST(kernel_irq, test_cancelled_interrupt_does_not_run)
{
	const unsigned int key = irq_lock();

	native_irq_raise(&irq);
	native_irq_cancel(&irq);
	irq_unlock(key);
	helper_expect("");
	native_irq_raise(&irq);
	helper_expect("ia");
}

ZTEST(kernel_irq, test_waiting_thread_lets_interrupts_run)
{
	const unsigned int key = irq_lock();

	native_irq_raise(&irq);
	k_sleep(K_TICKS(1));
	helper_expect("ia");
	irq_unlock(key);
}

static void use_stack(void *p1, void *p2, void *p3)
{
	volatile char used[1000];

	for (size_t i = 0; i < sizeof(used); i++) {
		used[i] = 1;
	}
	helper_note(used[999] == 1 ? 'u' : '?');
}

ZTEST(kernel_irq, test_stack_use_is_measured)
{
	size_t before, after;

	k_thread_abort(&thread_a);
	k_thread_create(&thread_a, stack_a, K_THREAD_STACK_SIZEOF(stack_a), use_stack, NULL, NULL,
	                NULL, PRIO_HIGH, 0, K_FOREVER);
	zassert_ok(k_thread_stack_space_get(&thread_a, &before));
	k_thread_start(&thread_a);
	zassert_ok(k_thread_stack_space_get(&thread_a, &after));
	helper_expect("u");
	zassert_true(before - after >= 1000, "%zu bytes", before - after);
}

ZTEST_SUITE(kernel_irq, NULL, NULL, begin, end_threads, NULL);
