/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"
#include "port.h"

/* The last level is the idle thread's. */
#define LEVELS (CONFIG_NUM_COOP_PRIORITIES + CONFIG_NUM_PREEMPT_PRIORITIES + 1)

/* So many switches without an idle moment, and the host is asked for events all the same. */
#define SWITCHES_PER_HOST_POLL 1024

BUILD_ASSERT(LEVELS <= 64, "one bit for each priority");

struct k_thread *sched_current;

static sys_dlist_t ready[LEVELS];
static uint64_t ready_levels; /* bit n: ready[n] is not empty */
static bool started;
static unsigned int switches_since_idle;

static unsigned int level_of(const struct k_thread *thread)
{
	return (unsigned int)(thread->base.prio + CONFIG_NUM_COOP_PRIORITIES);
}

static struct k_thread *best_ready(void)
{
	sys_dnode_t *node = ready[__builtin_ctzll(ready_levels)].next;

	return CONTAINER_OF(node, struct k_thread, base.qnode);
}

static void enqueue(struct k_thread *thread)
{
	const unsigned int level = level_of(thread);

	thread->base.thread_state |= THREAD_QUEUED;
	sys_dlist_append(&ready[level], &thread->base.qnode);
	ready_levels |= 1ULL << level;
}

static void dequeue(struct k_thread *thread)
{
	const unsigned int level = level_of(thread);

	thread->base.thread_state &= (uint8_t)~THREAD_QUEUED;
	sys_dlist_remove(&thread->base.qnode);
	if (sys_dlist_is_empty(&ready[level])) {
		ready_levels &= ~(1ULL << level);
	}
}

void sched_init(void)
{
	for (unsigned int level = 0; level < LEVELS; level++) {
		sys_dlist_init(&ready[level]);
	}
}

void sched_ready(struct k_thread *thread)
{
	if ((thread->base.thread_state & (THREAD_BLOCKED | THREAD_QUEUED)) == 0) {
		enqueue(thread);
	}
}

void sched_unready(struct k_thread *thread)
{
	if ((thread->base.thread_state & THREAD_QUEUED) != 0) {
		dequeue(thread);
	}
}

/* Devices and the clock must not starve under threads that keep the CPU among themselves. */
static void poll_host(void)
{
	if (++switches_since_idle < SWITCHES_PER_HOST_POLL || native_cpu.irq_locked) {
		return;
	}
	switches_since_idle = 0;
	irq_enter();
	port_idle(0);
	timeout_announce();
	irq_exit();
}

/*
 * A blocked caller's interrupt lock is lifted until it runs again; interrupts that waited for this
 * run first. They may end the wait, or switch threads by themselves.
 */
void sched_swap(void)
{
	struct k_thread *const prev = sched_current;
	const bool irq_was_locked = native_cpu.irq_locked;

	native_cpu.irq_locked = false;
	if (native_cpu.irq_waiting) {
		native_irq_dispatch();
	}
	poll_host();

	struct k_thread *const next = best_ready();

	if (next != prev) {
		threads_check_stack(prev);
		sched_current = next;
		port_trace("switch", next->name, next->base.prio);
		port_context_switch((prev->base.thread_state & THREAD_DEAD) != 0 ? NULL
		                                                                 : &prev->context,
		                    &next->context);
	}
	native_cpu.irq_locked = irq_was_locked;
}

void sched_reschedule(void)
{
	if (native_cpu.isr_depth > 0 || native_cpu.irq_locked || !started) {
		return;
	}

	const struct _thread_base *current = &sched_current->base;
	const bool preemptible = current->prio >= 0 && current->sched_locked == 0;

	if ((current->thread_state & THREAD_QUEUED) == 0 ||
	    (preemptible && best_ready() != sched_current)) {
		sched_swap();
	}
}

void sched_start(struct k_thread *first)
{
	static struct port_context boot;

	started = true;
	native_cpu.irq_locked = false;
	sched_current = first;
	port_context_switch(&boot, &first->context);
	CODE_UNREACHABLE;
}

/* The idle thread. */
void sched_idle(void *p1, void *p2, void *p3)
{
	ARG_UNUSED(p1);
	ARG_UNUSED(p2);
	ARG_UNUSED(p3);

	while (true) {
		switches_since_idle = 0;
		irq_enter();
		port_idle(timeout_next_us());
		timeout_announce();
		irq_exit();
	}
}

static void wait_q_insert(_wait_q_t *wait_q, struct k_thread *thread)
{
	sys_dnode_t *node = sys_dlist_peek_head(&wait_q->waitq);

	while (node != NULL &&
	       CONTAINER_OF(node, struct k_thread, base.qnode)->base.prio <= thread->base.prio) {
		node = sys_dlist_peek_next(&wait_q->waitq, node);
	}
	sys_dlist_insert(node != NULL ? node : &wait_q->waitq, &thread->base.qnode);
}

void sched_set_prio(struct k_thread *thread, int prio)
{
	const uint8_t state = thread->base.thread_state;

	if ((state & THREAD_QUEUED) != 0) {
		dequeue(thread);
		thread->base.prio = (int8_t)prio;
		enqueue(thread);
	} else if ((state & THREAD_PENDING) != 0) {
		sys_dlist_remove(&thread->base.qnode);
		thread->base.prio = (int8_t)prio;
		wait_q_insert(thread->base.pended_on, thread);
	} else {
		thread->base.prio = (int8_t)prio;
	}
}

void wait_q_init(_wait_q_t *wait_q)
{
	sys_dlist_init(&wait_q->waitq);
}

struct k_thread *wait_q_head(_wait_q_t *wait_q)
{
	sys_dnode_t *node = sys_dlist_peek_head(&wait_q->waitq);

	return SYS_DLIST_CONTAINER(node, (struct k_thread *)NULL, base.qnode);
}

void sched_thread_timeout(struct _timeout *timeout)
{
	struct k_thread *thread = CONTAINER_OF(timeout, struct k_thread, base.timeout);

	port_trace("timeout", thread->name, (int64_t)timeout->tick);
	if ((thread->base.thread_state & THREAD_PENDING) != 0) {
		sched_unpend(thread);
	}
	thread->base.thread_state &= (uint8_t) ~(THREAD_SLEEPING | THREAD_PRESTART);
	sched_ready(thread);
}

int sched_pend(_wait_q_t *wait_q, k_timeout_t timeout)
{
	struct k_thread *thread = sched_current;

	__ASSERT(native_cpu.isr_depth == 0, "waiting in an interrupt");
	__ASSERT(started, "waiting before there are threads");
	dequeue(thread);
	thread->base.thread_state |= THREAD_PENDING;
	thread->base.pended_on = wait_q;
	thread->base.swap_retval = -EAGAIN;
	wait_q_insert(wait_q, thread);
	timeout_add(&thread->base.timeout, sched_thread_timeout, timeout);
	sched_swap();
	return thread->base.swap_retval;
}

void sched_unpend(struct k_thread *thread)
{
	sys_dlist_remove(&thread->base.qnode);
	thread->base.thread_state &= (uint8_t)~THREAD_PENDING;
	thread->base.pended_on = NULL;
	(void)timeout_abort(&thread->base.timeout);
}

void sched_wake(struct k_thread *thread, int retval, void *data)
{
	sched_unpend(thread);
	thread->base.swap_retval = retval;
	thread->base.swap_data = data;
	sched_ready(thread);
}

bool sched_wake_first(_wait_q_t *wait_q, int retval, void *data)
{
	struct k_thread *thread = wait_q_head(wait_q);

	if (thread == NULL) {
		return false;
	}
	sched_wake(thread, retval, data);
	return true;
}

int sched_wake_all(_wait_q_t *wait_q, int retval)
{
	int count = 0;

	while (sched_wake_first(wait_q, retval, NULL)) {
		count++;
	}
	return count;
}

void k_yield(void)
{
	__ASSERT(native_cpu.isr_depth == 0, "k_yield() in an interrupt");
	sched_set_prio(sched_current, sched_current->base.prio);
	sched_swap();
}

void k_sched_lock(void)
{
	__ASSERT(native_cpu.isr_depth == 0, "k_sched_lock() in an interrupt");
	__ASSERT(sched_current->base.sched_locked < UINT8_MAX, "nested too deeply");
	sched_current->base.sched_locked++;
}

void k_sched_unlock(void)
{
	__ASSERT(native_cpu.isr_depth == 0, "k_sched_unlock() in an interrupt");
	__ASSERT(sched_current->base.sched_locked > 0, "not locked");
	sched_current->base.sched_locked--;
	sched_reschedule();
}

k_tid_t k_current_get(void)
{
	return sched_current;
}
