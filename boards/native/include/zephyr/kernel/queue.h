/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Passing data: message queues (copies), k_queue with its faces k_fifo and k_lifo (linked items
 * whose first word is the kernel's), stacks of words.
 *
 * Getting and putting without waiting: any context. Waiters are served by priority, then first
 * come.
 */
#ifndef ZEPHYR_KERNEL_QUEUE_H_
#define ZEPHYR_KERNEL_QUEUE_H_

#include <zephyr/kernel/thread.h>
#include <zephyr/sys/slist.h>

#define K_MSGQ_FLAG_ALLOC BIT(0)

struct k_msgq {
	_wait_q_t wait_q; /* readers when empty, writers when full */
	size_t msg_size;
	uint32_t max_msgs;
	char *buffer_start;
	char *buffer_end;
	char *read_ptr;
	char *write_ptr;
	uint32_t used_msgs;
	uint8_t flags;
	sys_dlist_t poll_events;
};

struct k_msgq_attrs {
	size_t msg_size;
	uint32_t max_msgs;
	uint32_t used_msgs;
};

#define Z_MSGQ_INITIALIZER(obj, q_buffer, q_msg_size, q_max_msgs)                                  \
	{                                                                                          \
		.wait_q = Z_WAIT_Q_INIT(&(obj).wait_q), .msg_size = (q_msg_size),                  \
		.max_msgs = (q_max_msgs), .buffer_start = (q_buffer),                              \
		.buffer_end = (q_buffer) + (q_max_msgs) * (q_msg_size), .read_ptr = (q_buffer),    \
		.write_ptr = (q_buffer), .poll_events = SYS_DLIST_STATIC_INIT(&(obj).poll_events)  \
	}
#define K_MSGQ_DEFINE(q_name, q_msg_size, q_max_msgs, q_align)                                     \
	static char __aligned(q_align) _k_fifo_buf_##q_name[(q_max_msgs) * (q_msg_size)];          \
	struct k_msgq q_name =                                                                     \
		Z_MSGQ_INITIALIZER(q_name, _k_fifo_buf_##q_name, q_msg_size, q_max_msgs)

void k_msgq_init(struct k_msgq *msgq, char *buffer, size_t msg_size, uint32_t max_msgs);
/* The buffer comes from the thread's heap. -ENOMEM, -EINVAL (too large). k_msgq_cleanup(): -EBUSY:
 * waiters. */
int k_msgq_alloc_init(struct k_msgq *msgq, size_t msg_size, uint32_t max_msgs);
int k_msgq_cleanup(struct k_msgq *msgq);
/* 0; -ENOMSG: full (or empty) and K_NO_WAIT, or purged while waiting to put; -EAGAIN: timeout. */
int k_msgq_put(struct k_msgq *msgq, const void *data, k_timeout_t timeout);
int k_msgq_get(struct k_msgq *msgq, void *data, k_timeout_t timeout);
/* -ENOMSG: there is none (at idx). */
int k_msgq_peek(struct k_msgq *msgq, void *data);
int k_msgq_peek_at(struct k_msgq *msgq, void *data, uint32_t idx);
void k_msgq_purge(struct k_msgq *msgq);
void k_msgq_get_attrs(struct k_msgq *msgq, struct k_msgq_attrs *attrs);

static inline uint32_t k_msgq_num_free_get(struct k_msgq *msgq)
{
	return msgq->max_msgs - msgq->used_msgs;
}

static inline uint32_t k_msgq_num_used_get(struct k_msgq *msgq)
{
	return msgq->used_msgs;
}

struct k_queue {
	sys_slist_t data_q;
	_wait_q_t wait_q;
	sys_dlist_t poll_events;
};

#define Z_QUEUE_INITIALIZER(obj)                                                                   \
	{                                                                                          \
		.data_q = SYS_SLIST_STATIC_INIT(&(obj).data_q),                                    \
		.wait_q = Z_WAIT_Q_INIT(&(obj).wait_q),                                            \
		.poll_events = SYS_DLIST_STATIC_INIT(&(obj).poll_events)                           \
	}
#define K_QUEUE_DEFINE(name) struct k_queue name = Z_QUEUE_INITIALIZER(name)

void k_queue_init(struct k_queue *queue);
/* Wakes the first waiter, which gets NULL. */
void k_queue_cancel_wait(struct k_queue *queue);
void k_queue_append(struct k_queue *queue, void *data);
void k_queue_prepend(struct k_queue *queue, void *data);
void k_queue_insert(struct k_queue *queue, void *prev, void *data);
/* The link comes from the thread's heap, so data needs no reserved word. -ENOMEM. */
int32_t k_queue_alloc_append(struct k_queue *queue, void *data);
int32_t k_queue_alloc_prepend(struct k_queue *queue, void *data);
/* Items linked through their first words. -EINVAL: head or tail is NULL, or the list is empty. */
int k_queue_append_list(struct k_queue *queue, void *head, void *tail);
int k_queue_merge_slist(struct k_queue *queue, sys_slist_t *list);
/* NULL after the timeout. */
void *k_queue_get(struct k_queue *queue, k_timeout_t timeout);
bool k_queue_remove(struct k_queue *queue, void *data);
/* false: it is in the queue already. */
bool k_queue_unique_append(struct k_queue *queue, void *data);
int k_queue_is_empty(struct k_queue *queue);
void *k_queue_peek_head(struct k_queue *queue);
void *k_queue_peek_tail(struct k_queue *queue);

struct k_fifo {
	struct k_queue _queue;
};

#define Z_FIFO_INITIALIZER(obj)                                                                    \
	{                                                                                          \
		._queue = Z_QUEUE_INITIALIZER((obj)._queue)                                        \
	}
#define K_FIFO_DEFINE(name)               struct k_fifo name = Z_FIFO_INITIALIZER(name)
#define k_fifo_init(fifo)                 k_queue_init(&(fifo)->_queue)
#define k_fifo_cancel_wait(fifo)          k_queue_cancel_wait(&(fifo)->_queue)
#define k_fifo_put(fifo, data)            k_queue_append(&(fifo)->_queue, data)
#define k_fifo_alloc_put(fifo, data)      k_queue_alloc_append(&(fifo)->_queue, data)
#define k_fifo_put_list(fifo, head, tail) k_queue_append_list(&(fifo)->_queue, head, tail)
#define k_fifo_put_slist(fifo, list)      k_queue_merge_slist(&(fifo)->_queue, list)
#define k_fifo_get(fifo, timeout)         k_queue_get(&(fifo)->_queue, timeout)
#define k_fifo_is_empty(fifo)             k_queue_is_empty(&(fifo)->_queue)
#define k_fifo_peek_head(fifo)            k_queue_peek_head(&(fifo)->_queue)
#define k_fifo_peek_tail(fifo)            k_queue_peek_tail(&(fifo)->_queue)

struct k_lifo {
	struct k_queue _queue;
};

#define Z_LIFO_INITIALIZER(obj)                                                                    \
	{                                                                                          \
		._queue = Z_QUEUE_INITIALIZER((obj)._queue)                                        \
	}
#define K_LIFO_DEFINE(name)          struct k_lifo name = Z_LIFO_INITIALIZER(name)
#define k_lifo_init(lifo)            k_queue_init(&(lifo)->_queue)
#define k_lifo_put(lifo, data)       k_queue_prepend(&(lifo)->_queue, data)
#define k_lifo_alloc_put(lifo, data) k_queue_alloc_prepend(&(lifo)->_queue, data)
#define k_lifo_get(lifo, timeout)    k_queue_get(&(lifo)->_queue, timeout)

typedef uintptr_t stack_data_t;

struct k_stack {
	_wait_q_t wait_q;
	stack_data_t *base, *next, *top;
};

#define Z_STACK_INITIALIZER(obj, stack_buffer, stack_num_entries)                                  \
	{                                                                                          \
		.wait_q = Z_WAIT_Q_INIT(&(obj).wait_q), .base = (stack_buffer),                    \
		.next = (stack_buffer), .top = (stack_buffer) + (stack_num_entries)                \
	}
#define K_STACK_DEFINE(name, stack_num_entries)                                                    \
	static stack_data_t _k_stack_buf_##name[stack_num_entries];                                \
	struct k_stack name = Z_STACK_INITIALIZER(name, _k_stack_buf_##name, stack_num_entries)

void k_stack_init(struct k_stack *stack, stack_data_t *buffer, uint32_t num_entries);
/* -ENOMEM: full. */
int k_stack_push(struct k_stack *stack, stack_data_t data);
/* 0; -EBUSY: empty and K_NO_WAIT; -EAGAIN: timeout. */
int k_stack_pop(struct k_stack *stack, stack_data_t *data, k_timeout_t timeout);

#endif
