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
