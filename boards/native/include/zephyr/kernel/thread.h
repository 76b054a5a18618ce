/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Threads and scheduling. Priorities: below 0 cooperative, 0 and above preemptive, smaller is more
 * urgent; -CONFIG_NUM_COOP_PRIORITIES … CONFIG_NUM_PREEMPT_PRIORITIES - 1. Threads of one priority
 * run in the order in which they became ready, without time slices.
 */
#ifndef ZEPHYR_KERNEL_THREAD_H_
#define ZEPHYR_KERNEL_THREAD_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <native/context.h>
#include <native/cpu.h>
#include <zephyr/kernel/thread_stack.h>
#include <zephyr/sys/dlist.h>
#include <zephyr/sys/iterable_sections.h>
#include <zephyr/sys_clock.h>

#define K_PRIO_COOP(x)                    (-(CONFIG_NUM_COOP_PRIORITIES - (x)))
#define K_PRIO_PREEMPT(x)                 (x)
#define K_HIGHEST_THREAD_PRIO             (-CONFIG_NUM_COOP_PRIORITIES)
#define K_LOWEST_THREAD_PRIO              CONFIG_NUM_PREEMPT_PRIORITIES
#define K_IDLE_PRIO                       K_LOWEST_THREAD_PRIO
#define K_HIGHEST_APPLICATION_THREAD_PRIO K_HIGHEST_THREAD_PRIO
#define K_LOWEST_APPLICATION_THREAD_PRIO  (K_LOWEST_THREAD_PRIO - 1)

/* Thread options. */
#define K_ESSENTIAL     BIT(0) /* its end is a fatal error */
#define K_FP_REGS       BIT(1) /* no effect: every thread may use floating point */
#define K_USER          BIT(2) /* no effect: there is no user mode */
#define K_INHERIT_PERMS BIT(3) /* no effect, as above */

typedef struct {
	sys_dlist_t waitq; /* most urgent first */
} _wait_q_t;

#define Z_WAIT_Q_INIT(wait_q)                                                                      \
	{                                                                                          \
		.waitq = SYS_DLIST_STATIC_INIT(&(wait_q)->waitq)                                   \
	}

#define K_THREAD_STATE_MAX_LENGTH 32

struct _thread_base {
	sys_dnode_t qnode; /* in the ready queue or in a wait queue */
	_wait_q_t *pended_on;
	struct _timeout timeout;
	void *swap_data; /* what a waker hands over */
	int swap_retval;
	int8_t prio;
	uint8_t user_options;
	uint8_t thread_state;
	uint8_t sched_locked;
};

struct _thread_stack_info {
	uintptr_t start;
	size_t size; /* with headroom */
};

typedef void (*k_thread_entry_t)(void *p1, void *p2, void *p3);

struct k_thread {
	struct _thread_base base;
	struct port_context context;
	struct k_thread *older, *newer; /* of all threads that exist */
	_wait_q_t join_queue;
	k_thread_entry_t entry;
	void *params[3];
	struct _thread_stack_info stack_info;
	char name[CONFIG_THREAD_MAX_NAME_LEN];
};

typedef struct k_thread *k_tid_t;

struct _static_thread_data {
	struct k_thread *thread;
	k_thread_stack_t *stack;
	size_t stack_size;
	k_thread_entry_t entry;
	void *params[3];
	int prio;
	uint32_t options;
	int32_t delay_ms; /* SYS_FOREVER_MS: k_thread_start() starts it */
	const char *name;
};

#define NATIVE_THREAD_DEFINE(id, ...)                                                              \
	struct k_thread _k_thread_obj_##id;                                                        \
	const STRUCT_SECTION_ITERABLE(_static_thread_data, _k_thread_data_##id) = {__VA_ARGS__};   \
	const k_tid_t id = &_k_thread_obj_##id

/* A thread that starts delay_ms after boot; its name is its identifier. */
#define K_THREAD_DEFINE(id, stack_bytes, entry_fn, p1, p2, p3, priority, opts, start_ms)           \
	K_THREAD_STACK_DEFINE(_k_thread_stack_##id, stack_bytes);                                  \
	NATIVE_THREAD_DEFINE(id, .thread = &_k_thread_obj_##id, .stack = _k_thread_stack_##id,     \
	                     .stack_size = (stack_bytes), .entry = (k_thread_entry_t)(entry_fn),   \
	                     .params = {(void *)(p1), (void *)(p2), (void *)(p3)},                 \
	                     .prio = (priority), .options = (opts), .delay_ms = (start_ms),        \
	                     .name = #id)
#define K_KERNEL_THREAD_DEFINE K_THREAD_DEFINE

/*
 * Creates a thread that becomes ready after delay (K_NO_WAIT: now, K_FOREVER: on k_thread_start()).
 * stack_size as in K_THREAD_STACK_SIZEOF(stack). Returns new_thread. Threads and boot only.
 */
k_tid_t k_thread_create(struct k_thread *new_thread, k_thread_stack_t *stack, size_t stack_size,
                        k_thread_entry_t entry, void *p1, void *p2, void *p3, int prio,
                        uint32_t options, k_timeout_t delay);
void k_thread_start(k_tid_t thread);
/* Any context. The end of a thread inside k_thread_abort() of itself, or in its entry's return. */
void k_thread_abort(k_tid_t thread);
/* 0: it ended. -EBUSY: K_NO_WAIT and it runs. -EAGAIN: timeout. -EDEADLK: itself or a thread that
 * joins us. */
int k_thread_join(struct k_thread *thread, k_timeout_t timeout);
void k_thread_suspend(k_tid_t thread);
void k_thread_resume(k_tid_t thread);
int k_thread_priority_get(k_tid_t thread);
void k_thread_priority_set(k_tid_t thread, int prio);
/* 0, or -EINVAL / -ENOSPC as upstream; longer names are cut. thread == NULL: the current one. */
int k_thread_name_set(k_tid_t thread, const char *value);
const char *k_thread_name_get(k_tid_t thread);
/* "queued" (ready), "pending", "pending+suspended", … written to buf, which is returned. */
const char *k_thread_state_str(k_tid_t thread, char *buf, size_t buf_size);
/* Bytes of the stack (headroom included) that were never written. */
int k_thread_stack_space_get(const struct k_thread *thread, size_t *unused_ptr);

typedef void (*k_thread_user_cb_t)(const struct k_thread *thread, void *user_data);
/* Newest first. The callback must neither create nor abort threads. */
void k_thread_foreach(k_thread_user_cb_t user_cb, void *user_data);

/* Milliseconds, or for k_usleep() microseconds, that were left when k_wakeup() ended the sleep; 0
 * otherwise. */
int32_t k_sleep(k_timeout_t timeout);
int32_t k_usleep(int32_t us);
static inline int32_t k_msleep(int32_t ms)
{
	return k_sleep(K_MSEC(ms));
}
void k_wakeup(k_tid_t thread);
void k_yield(void);
/* Lets time pass while the caller keeps the CPU; timers run as interrupts meanwhile. */
void k_busy_wait(uint32_t usec_to_wait);
void k_cpu_idle(void);

k_tid_t k_current_get(void);
void k_sched_lock(void);
void k_sched_unlock(void);

static inline bool k_is_in_isr(void)
{
	return native_cpu.isr_depth > 0;
}

#define k_panic() k_fatal(K_ERR_KERNEL_PANIC)
#define k_oops()  k_fatal(K_ERR_KERNEL_OOPS)
/* Does not return; see <zephyr/fatal.h>. */
FUNC_NORETURN void k_fatal(unsigned int reason);

#endif
