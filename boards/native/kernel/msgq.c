/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

void k_msgq_init(struct k_msgq *msgq, char *buffer, size_t msg_size, uint32_t max_msgs)
{
	*msgq = (struct k_msgq){
		.msg_size = msg_size,
		.max_msgs = max_msgs,
		.buffer_start = buffer,
		.buffer_end = buffer + max_msgs * msg_size,
		.read_ptr = buffer,
		.write_ptr = buffer,
	};
	wait_q_init(&msgq->wait_q);
	sys_dlist_init(&msgq->poll_events);
}

int k_msgq_alloc_init(struct k_msgq *msgq, size_t msg_size, uint32_t max_msgs)
{
	size_t bytes;

	if (__builtin_mul_overflow(msg_size, (size_t)max_msgs, &bytes)) {
		return -EINVAL;
	}

	char *buffer = z_thread_malloc(bytes);

	if (buffer == NULL) {
		return -ENOMEM;
	}
	k_msgq_init(msgq, buffer, msg_size, max_msgs);
	msgq->flags = K_MSGQ_FLAG_ALLOC;
	return 0;
}

int k_msgq_cleanup(struct k_msgq *msgq)
{
	if (wait_q_head(&msgq->wait_q) != NULL) {
		return -EBUSY;
	}
	if ((msgq->flags & K_MSGQ_FLAG_ALLOC) != 0) {
		k_free(msgq->buffer_start);
		msgq->flags &= (uint8_t)~K_MSGQ_FLAG_ALLOC;
	}
	return 0;
}

static char *advance(const struct k_msgq *msgq, char *at)
{
	at += msgq->msg_size;
	return at == msgq->buffer_end ? msgq->buffer_start : at;
}

static void enqueue(struct k_msgq *msgq, const void *data)
{
	memcpy(msgq->write_ptr, data, msgq->msg_size);
	msgq->write_ptr = advance(msgq, msgq->write_ptr);
	msgq->used_msgs++;
}

int k_msgq_put(struct k_msgq *msgq, const void *data, k_timeout_t timeout)
{
	if (msgq->used_msgs < msgq->max_msgs) {
		struct k_thread *reader = wait_q_head(&msgq->wait_q);

		if (reader != NULL) {
			memcpy(reader->base.swap_data, data, msgq->msg_size);
			sched_wake(reader, 0, NULL);
		} else {
			enqueue(msgq, data);
			poll_notify(&msgq->poll_events, K_POLL_STATE_MSGQ_DATA_AVAILABLE);
		}
		sched_reschedule();
		return 0;
	}
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return -ENOMSG;
	}
	sched_current->base.swap_data = (void *)(uintptr_t)data;
	return sched_pend(&msgq->wait_q, timeout);
}

int k_msgq_get(struct k_msgq *msgq, void *data, k_timeout_t timeout)
{
	if (msgq->used_msgs > 0) {
		memcpy(data, msgq->read_ptr, msgq->msg_size);
		msgq->read_ptr = advance(msgq, msgq->read_ptr);
		msgq->used_msgs--;

		struct k_thread *writer = wait_q_head(&msgq->wait_q);

		if (writer != NULL) {
			enqueue(msgq, writer->base.swap_data);
			sched_wake(writer, 0, NULL);
			sched_reschedule();
		}
		return 0;
	}
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return -ENOMSG;
	}
	sched_current->base.swap_data = data;
	return sched_pend(&msgq->wait_q, timeout);
}

int k_msgq_peek_at(struct k_msgq *msgq, void *data, uint32_t idx)
{
	if (idx >= msgq->used_msgs) {
		return -ENOMSG;
	}

	const size_t size = (size_t)(msgq->buffer_end - msgq->buffer_start);
	const size_t offset =
		(size_t)(msgq->read_ptr - msgq->buffer_start) + (size_t)idx * msgq->msg_size;

	memcpy(data, msgq->buffer_start + offset % size, msgq->msg_size);
	return 0;
}

int k_msgq_peek(struct k_msgq *msgq, void *data)
{
	return k_msgq_peek_at(msgq, data, 0);
}

/* Threads that wait are writers, unless the queue is empty: then readers, which purging does not
 * concern. */
void k_msgq_purge(struct k_msgq *msgq)
{
	if (msgq->used_msgs > 0) {
		(void)sched_wake_all(&msgq->wait_q, -ENOMSG);
	}
	msgq->used_msgs = 0;
	msgq->read_ptr = msgq->write_ptr;
	sched_reschedule();
}

void k_msgq_get_attrs(struct k_msgq *msgq, struct k_msgq_attrs *attrs)
{
	attrs->msg_size = msgq->msg_size;
	attrs->max_msgs = msgq->max_msgs;
	attrs->used_msgs = msgq->used_msgs;
}
