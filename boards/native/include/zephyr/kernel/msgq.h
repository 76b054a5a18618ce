/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Message queues, which copy. Getting and putting without waiting: any context. Waiters are served
 * by priority, then first come.
 */
#ifndef ZEPHYR_KERNEL_MSGQ_H_
#define ZEPHYR_KERNEL_MSGQ_H_

#include <zephyr/kernel/thread.h>

struct k_msgq {
	_wait_q_t wait_q; /* readers when empty, writers when full */
	size_t msg_size;
	uint32_t max_msgs;
	char *buffer_start;
	char *buffer_end;
	char *read_ptr;
	char *write_ptr;
	uint32_t used_msgs;
};

#define Z_MSGQ_INITIALIZER(obj, q_buffer, q_msg_size, q_max_msgs)                                  \
	{                                                                                          \
		.wait_q = Z_WAIT_Q_INIT(&(obj).wait_q), .msg_size = (q_msg_size),                  \
		.max_msgs = (q_max_msgs), .buffer_start = (q_buffer),                              \
		.buffer_end = (q_buffer) + (q_max_msgs) * (q_msg_size), .read_ptr = (q_buffer),    \
		.write_ptr = (q_buffer)                                                            \
	}
#define K_MSGQ_DEFINE(q_name, q_msg_size, q_max_msgs, q_align)                                     \
	static char __aligned(q_align) _k_fifo_buf_##q_name[(q_max_msgs) * (q_msg_size)];          \
	struct k_msgq q_name =                                                                     \
		Z_MSGQ_INITIALIZER(q_name, _k_fifo_buf_##q_name, q_msg_size, q_max_msgs)

void k_msgq_init(struct k_msgq *msgq, char *buffer, size_t msg_size, uint32_t max_msgs);
/* 0; -ENOMSG: full (or empty) and K_NO_WAIT, or purged while waiting to put; -EAGAIN: timeout. */
int k_msgq_put(struct k_msgq *msgq, const void *data, k_timeout_t timeout);
int k_msgq_get(struct k_msgq *msgq, void *data, k_timeout_t timeout);
void k_msgq_purge(struct k_msgq *msgq);

static inline uint32_t k_msgq_num_free_get(struct k_msgq *msgq)
{
	return msgq->max_msgs - msgq->used_msgs;
}

static inline uint32_t k_msgq_num_used_get(struct k_msgq *msgq)
{
	return msgq->used_msgs;
}

#endif
