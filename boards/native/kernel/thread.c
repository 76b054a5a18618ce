/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "port.h"
#include "sched.h"

#define CANARY 0x5ca1ab1e0ddba11dULL

static struct k_thread *newest;

static void thread_main(void *arg)
{
	struct k_thread *thread = arg;

	thread->entry(thread->params[0], thread->params[1], thread->params[2]);
	k_thread_abort(thread);
}

/*
 * Unused stack is zero: static memory is so at first, and reading it costs no resident page. An
 * earlier thread's traces are wiped from the lowest one on.
 */
static void stack_init(struct k_thread *thread, k_thread_stack_t *stack, size_t stack_size)
{
	const size_t size = K_THREAD_STACK_LEN(stack_size);
	uint64_t *const canary = (uint64_t *)stack;
	uint64_t *const end = (uint64_t *)((char *)stack + size);
	uint64_t *word = canary;

	port_stack_claim(stack, size);
	*canary = 0;
	while (word < end && *word == 0) {
		word++;
	}
	memset(word, 0, (size_t)((char *)end - (char *)word));
	*canary = CANARY;
	port_context_init(&thread->context, stack, size, thread_main, thread);
	thread->stack_info.start = (uintptr_t)stack;
	thread->stack_info.size = size;
}

void threads_check_stack(const struct k_thread *thread)
{
	if ((thread->base.thread_state & THREAD_DEAD) == 0 &&
	    *(const uint64_t *)thread->stack_info.start != CANARY) {
		z_fatal_error(K_ERR_STACK_CHK_FAIL, NULL);
	}
}

k_tid_t k_thread_create(struct k_thread *new_thread, k_thread_stack_t *stack, size_t stack_size,
                        k_thread_entry_t entry, void *p1, void *p2, void *p3, int prio,
                        uint32_t options, k_timeout_t delay)
{
	__ASSERT(native_cpu.isr_depth == 0, "threads are not created in interrupts");
	__ASSERT(prio >= K_HIGHEST_THREAD_PRIO && prio <= K_LOWEST_THREAD_PRIO, "priority %d",
	         prio);
	*new_thread = (struct k_thread){
		.base = {.prio = (int8_t)prio,
	                 .user_options = (uint8_t)options,
	                 .thread_state = THREAD_PRESTART},
		.entry = entry,
		.params = {p1, p2, p3},
		.older = newest,
	};
	wait_q_init(&new_thread->join_queue);
	if (newest != NULL) {
		newest->newer = new_thread;
	}
	newest = new_thread;
	stack_init(new_thread, stack, stack_size);
	if (K_TIMEOUT_EQ(delay, K_NO_WAIT)) {
		k_thread_start(new_thread);
	} else {
		timeout_add(&new_thread->base.timeout, sched_thread_timeout, delay);
	}
	return new_thread;
}

void k_thread_start(k_tid_t thread)
{
	if ((thread->base.thread_state & THREAD_PRESTART) == 0) {
		return;
	}
	(void)timeout_abort(&thread->base.timeout);
	thread->base.thread_state &= (uint8_t)~THREAD_PRESTART;
	sched_ready(thread);
	if (port_thread_stalled(thread->name)) {
		k_thread_suspend(thread);
	}
	sched_reschedule();
}

void threads_start_static(void)
{
	k_sched_lock();
	TYPE_SECTION_FOREACH(const struct _static_thread_data, _static_thread_data, data)
	{
		const k_timeout_t delay =
			data->delay_ms == SYS_FOREVER_MS ? K_FOREVER : K_MSEC(data->delay_ms);

		(void)k_thread_create(data->thread, data->stack, data->stack_size, data->entry,
		                      data->params[0], data->params[1], data->params[2], data->prio,
		                      data->options, K_FOREVER);
		(void)k_thread_name_set(data->thread, data->name);
		if (K_TIMEOUT_EQ(delay, K_NO_WAIT)) {
			k_thread_start(data->thread);
		} else {
			timeout_add(&data->thread->base.timeout, sched_thread_timeout, delay);
		}
	}
	k_sched_unlock();
}

static void forget(struct k_thread *thread)
{
	if (thread->newer != NULL) {
		thread->newer->older = thread->older;
	} else {
		newest = thread->older;
	}
	if (thread->older != NULL) {
		thread->older->newer = thread->newer;
	}
}

/* A thread that was never created is as good as dead. */
void k_thread_abort(k_tid_t thread)
{
	if ((thread->base.thread_state & THREAD_DEAD) != 0 || thread->entry == NULL) {
		return;
	}
	if ((thread->base.user_options & K_ESSENTIAL) != 0) {
		printk("thread \"%s\" is essential and ended\n", thread->name);
		k_panic();
	}
	(void)timeout_abort(&thread->base.timeout);
	sched_unready(thread);
	if ((thread->base.thread_state & THREAD_PENDING) != 0) {
		sched_unpend(thread);
	}
	thread->base.thread_state = THREAD_DEAD;
	forget(thread);
	(void)sched_wake_all(&thread->join_queue, 0);
	if (thread == sched_current && native_cpu.isr_depth == 0) {
		sched_swap();
	}
	sched_reschedule();
}

int k_thread_join(struct k_thread *thread, k_timeout_t timeout)
{
	if ((thread->base.thread_state & THREAD_DEAD) != 0) {
		return 0;
	}
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return -EBUSY;
	}
	if (thread == sched_current || thread->base.pended_on == &sched_current->join_queue) {
		return -EDEADLK;
	}
	return sched_pend(&thread->join_queue, timeout);
}

void k_thread_suspend(k_tid_t thread)
{
	if ((thread->base.thread_state & (THREAD_SUSPENDED | THREAD_DEAD)) != 0) {
		return;
	}
	sched_unready(thread);
	thread->base.thread_state |= THREAD_SUSPENDED;
	if (thread == sched_current && native_cpu.isr_depth == 0) {
		sched_swap();
	}
	sched_reschedule();
}

void k_thread_resume(k_tid_t thread)
{
	if ((thread->base.thread_state & THREAD_SUSPENDED) == 0) {
		return;
	}
	thread->base.thread_state &= (uint8_t)~THREAD_SUSPENDED;
	sched_ready(thread);
	sched_reschedule();
}

int k_thread_priority_get(k_tid_t thread)
{
	return thread->base.prio;
}

void k_thread_priority_set(k_tid_t thread, int prio)
{
	__ASSERT(prio >= K_HIGHEST_THREAD_PRIO && prio < K_LOWEST_THREAD_PRIO, "priority %d", prio);
	sched_set_prio(thread, prio);
	if (thread == sched_current && native_cpu.isr_depth == 0 && !native_cpu.irq_locked &&
	    thread->base.sched_locked == 0) {
		sched_swap();
	}
	sched_reschedule();
}

int k_thread_name_set(k_tid_t thread, const char *value)
{
	struct k_thread *const named = thread != NULL ? thread : sched_current;

	(void)snprintf(named->name, sizeof(named->name), "%s", value);
	return 0;
}

const char *k_thread_name_get(k_tid_t thread)
{
	return thread->name;
}

const char *k_thread_state_str(k_tid_t thread, char *buf, size_t buf_size)
{
	static const struct {
		uint8_t bit;
		const char *name;
	} names[] = {
		{THREAD_PENDING, "pending"},     {THREAD_SLEEPING, "sleeping"},
		{THREAD_PRESTART, "prestart"},   {THREAD_DEAD, "dead"},
		{THREAD_SUSPENDED, "suspended"}, {THREAD_QUEUED, "queued"},
	};
	size_t used = 0;

	if (buf == NULL || buf_size == 0) {
		return "";
	}
	buf[0] = '\0';
	for (size_t i = 0; i < ARRAY_SIZE(names); i++) {
		if ((thread->base.thread_state & names[i].bit) != 0 && used < buf_size) {
			used += (size_t)snprintf(buf + used, buf_size - used, "%s%s",
			                         used > 0 ? "+" : "", names[i].name);
		}
	}
	return buf;
}

/* Frames of a suspended thread may be marked as out of bounds for anyone else. */
__attribute__((no_sanitize("address"))) int k_thread_stack_space_get(const struct k_thread *thread,
                                                                     size_t *unused_ptr)
{
	const volatile char *const stack = (const volatile char *)thread->stack_info.start;
	size_t unused = sizeof(uint64_t); /* the canary */

	if (stack == NULL) {
		return -EINVAL;
	}
	while (unused < thread->stack_info.size && stack[unused] == 0) {
		unused++;
	}
	*unused_ptr = unused;
	return 0;
}

void k_thread_foreach(k_thread_user_cb_t user_cb, void *user_data)
{
	for (const struct k_thread *thread = newest; thread != NULL; thread = thread->older) {
		user_cb(thread, user_data);
	}
}

/* Returns the ticks that were left. */
static k_ticks_t sleep_ticks(k_timeout_t timeout)
{
	struct k_thread *thread = sched_current;

	__ASSERT(native_cpu.isr_depth == 0, "sleeping in an interrupt");
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		k_yield();
		return 0;
	}

	const k_ticks_t expected = timeout.ticks < K_TICKS_FOREVER
	                                   ? Z_TICK_ABS(timeout.ticks)
	                                   : timeout.ticks + k_uptime_ticks();

	sched_unready(thread);
	thread->base.thread_state |= THREAD_SLEEPING;
	timeout_add(&thread->base.timeout, sched_thread_timeout, timeout);
	sched_swap();
	if (K_TIMEOUT_EQ(timeout, K_FOREVER)) {
		return K_TICKS_FOREVER;
	}
	return MAX(expected - k_uptime_ticks(), 0);
}

int32_t k_sleep(k_timeout_t timeout)
{
	const k_ticks_t left = sleep_ticks(timeout);

	return left == K_TICKS_FOREVER ? (int32_t)K_TICKS_FOREVER
	                               : (int32_t)k_ticks_to_ms_floor64((uint64_t)left);
}

int32_t k_usleep(int32_t us)
{
	return (int32_t)k_ticks_to_us_floor64((uint64_t)sleep_ticks(K_USEC(us)));
}

void k_wakeup(k_tid_t thread)
{
	if ((thread->base.thread_state & THREAD_SLEEPING) == 0) {
		return;
	}
	(void)timeout_abort(&thread->base.timeout);
	thread->base.thread_state &= (uint8_t)~THREAD_SLEEPING;
	sched_ready(thread);
	sched_reschedule();
}
