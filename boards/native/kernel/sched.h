/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Inside the native kernel: scheduler, wait queues, timeouts.
 *
 * Kernel code itself is never interrupted: interrupts arrive only in native_irq_raise(),
 * irq_unlock(), k_busy_wait() and the idle thread. So nothing here locks; a service changes its
 * state first and then calls sched_reschedule(), which may switch threads.
 */
#ifndef NATIVE_KERNEL_SCHED_H_
#define NATIVE_KERNEL_SCHED_H_

#include <zephyr/kernel.h>

enum {
	THREAD_PENDING = 1 << 0, /* in a wait queue */
	THREAD_SLEEPING = 1 << 1,
	THREAD_PRESTART = 1 << 2,
	THREAD_SUSPENDED = 1 << 3,
	THREAD_DEAD = 1 << 4,
	THREAD_QUEUED = 1 << 5, /* in the ready queue */
	THREAD_BLOCKED =
		THREAD_PENDING | THREAD_SLEEPING | THREAD_PRESTART | THREAD_SUSPENDED | THREAD_DEAD,
};

extern struct k_thread *sched_current;

/* thread.c */
void threads_start_static(void);
void threads_check_stack(const struct k_thread *thread); /* an overflow is a fatal error */

/* sched.c */
void sched_init(void);
_Noreturn void sched_start(struct k_thread *first);
void sched_idle(void *p1, void *p2, void *p3);
void sched_thread_timeout(struct _timeout *timeout);
void sched_ready(struct k_thread *thread); /* if nothing blocks it */
void sched_unready(struct k_thread *thread);
void sched_set_prio(struct k_thread *thread, int prio); /* moves it within its queue */
void sched_reschedule(void);                            /* preempts the caller if it must */
void sched_swap(void); /* runs the best thread, whatever the caller is */

void wait_q_init(_wait_q_t *wait_q);
struct k_thread *wait_q_head(_wait_q_t *wait_q);
/* Blocks the current thread. Returns what the waker set, or -EAGAIN after the timeout. */
int sched_pend(_wait_q_t *wait_q, k_timeout_t timeout);
/* Takes a pending thread out of its wait queue; it is not ready yet. */
void sched_unpend(struct k_thread *thread);
/* Unpends and readies it. */
void sched_wake(struct k_thread *thread, int retval, void *data);
bool sched_wake_first(_wait_q_t *wait_q, int retval, void *data);
int sched_wake_all(_wait_q_t *wait_q, int retval);

/* timeout.c */
void timeout_add(struct _timeout *timeout, _timeout_func_t fn, k_timeout_t when);
bool timeout_abort(struct _timeout *timeout); /* true: it was running */
uint64_t timeout_next_us(void);               /* UINT64_MAX: none */
void timeout_announce(void);                  /* interrupt context */

static inline bool timeout_active(const struct _timeout *timeout)
{
	return sys_dnode_is_linked(&timeout->node);
}

k_ticks_t timeout_remaining(const struct _timeout *timeout);
k_ticks_t timeout_expires(const struct _timeout *timeout);

/* irq.c */
void irq_enter(void);
void irq_exit(void); /* runs what waits, then reschedules */

/* mem.c */
void mem_init(void);

#endif
