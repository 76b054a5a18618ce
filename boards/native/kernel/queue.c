/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

/*
 * An item is linked through its own first word, or, for the alloc functions, through a link that is
 * freed when the item is taken. The lowest bit of a node's word tells that the node is such a link.
 */
#define LINK_FLAG ((uintptr_t)1)

struct queue_link {
	sys_snode_t node;
	void *data;
};

static sys_snode_t *next_of(const sys_snode_t *node)
{
	return (sys_snode_t *)((uintptr_t)node->next & ~LINK_FLAG);
}

static void set_next(sys_snode_t *node, const sys_snode_t *next)
{
	node->next = (sys_snode_t *)((uintptr_t)next | ((uintptr_t)node->next & LINK_FLAG));
}

/* After prev; prev == NULL: at the head. The node's flag is kept. */
static void list_insert(sys_slist_t *list, sys_snode_t *prev, sys_snode_t *node)
{
	set_next(node, prev == NULL ? list->head : next_of(prev));
	if (prev == NULL) {
		list->head = node;
	} else {
		set_next(prev, node);
	}
	if (list->tail == prev) {
		list->tail = node;
	}
}

static void list_remove(sys_slist_t *list, sys_snode_t *prev, sys_snode_t *node)
{
	if (prev == NULL) {
		list->head = next_of(node);
	} else {
		set_next(prev, next_of(node));
	}
	if (list->tail == node) {
		list->tail = prev;
	}
}

static bool is_link(const sys_snode_t *node)
{
	return ((uintptr_t)node->next & LINK_FLAG) != 0;
}

static void *data_of(sys_snode_t *node)
{
	if (node == NULL || !is_link(node)) {
		return node;
	}
	return CONTAINER_OF(node, struct queue_link, node)->data;
}

void k_queue_init(struct k_queue *queue)
{
	sys_slist_init(&queue->data_q);
	wait_q_init(&queue->wait_q);
	sys_dlist_init(&queue->poll_events);
}

void k_queue_cancel_wait(struct k_queue *queue)
{
	(void)sched_wake_first(&queue->wait_q, 0, NULL);
	poll_notify(&queue->poll_events, K_POLL_STATE_CANCELLED);
	sched_reschedule();
}

static void insert_node(struct k_queue *queue, sys_snode_t *prev, sys_snode_t *node)
{
	list_insert(&queue->data_q, prev, node);
	poll_notify(&queue->poll_events, K_POLL_STATE_DATA_AVAILABLE);
	sched_reschedule();
}

static void insert_item(struct k_queue *queue, sys_snode_t *prev, void *data)
{
	if (sched_wake_first(&queue->wait_q, 0, data)) {
		sched_reschedule();
		return;
	}
	((sys_snode_t *)data)->next = NULL;
	insert_node(queue, prev, data);
}

static int32_t insert_link(struct k_queue *queue, sys_snode_t *prev, void *data)
{
	if (sched_wake_first(&queue->wait_q, 0, data)) {
		sched_reschedule();
		return 0;
	}

	struct queue_link *link = z_thread_malloc(sizeof(*link));

	if (link == NULL) {
		return -ENOMEM;
	}
	link->data = data;
	link->node.next = (sys_snode_t *)LINK_FLAG;
	insert_node(queue, prev, &link->node);
	return 0;
}

void k_queue_append(struct k_queue *queue, void *data)
{
	insert_item(queue, queue->data_q.tail, data);
}

void k_queue_prepend(struct k_queue *queue, void *data)
{
	insert_item(queue, NULL, data);
}

void k_queue_insert(struct k_queue *queue, void *prev, void *data)
{
	insert_item(queue, prev, data);
}

int32_t k_queue_alloc_append(struct k_queue *queue, void *data)
{
	return insert_link(queue, queue->data_q.tail, data);
}

int32_t k_queue_alloc_prepend(struct k_queue *queue, void *data)
{
	return insert_link(queue, NULL, data);
}

int k_queue_append_list(struct k_queue *queue, void *head, void *tail)
{
	sys_snode_t *first = head;

	if (head == NULL || tail == NULL) {
		return -EINVAL;
	}
	while (first != NULL) {
		sys_snode_t *const next = first->next;

		if (!sched_wake_first(&queue->wait_q, 0, first)) {
			break;
		}
		first = next;
	}
	if (first != NULL) {
		sys_snode_t *const old_tail = queue->data_q.tail;

		if (old_tail == NULL) {
			queue->data_q.head = first;
		} else {
			set_next(old_tail, first);
		}
		queue->data_q.tail = tail;
	}
	poll_notify(&queue->poll_events, K_POLL_STATE_DATA_AVAILABLE);
	sched_reschedule();
	return 0;
}

int k_queue_merge_slist(struct k_queue *queue, sys_slist_t *list)
{
	if (sys_slist_is_empty(list)) {
		return -EINVAL;
	}

	const int result = k_queue_append_list(queue, list->head, list->tail);

	sys_slist_init(list);
	return result;
}

void *k_queue_get(struct k_queue *queue, k_timeout_t timeout)
{
	sys_snode_t *const node = queue->data_q.head;

	if (node != NULL) {
		void *const data = data_of(node);

		list_remove(&queue->data_q, NULL, node);
		if (is_link(node)) {
			k_free(CONTAINER_OF(node, struct queue_link, node));
		}
		return data;
	}
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return NULL;
	}
	return sched_pend(&queue->wait_q, timeout) == 0 ? sched_current->base.swap_data : NULL;
}

bool k_queue_remove(struct k_queue *queue, void *data)
{
	sys_snode_t *prev = NULL;

	for (sys_snode_t *at = queue->data_q.head; at != NULL; prev = at, at = next_of(at)) {
		if (at == data) {
			list_remove(&queue->data_q, prev, at);
			return true;
		}
	}
	return false;
}

bool k_queue_unique_append(struct k_queue *queue, void *data)
{
	for (sys_snode_t *at = queue->data_q.head; at != NULL; at = next_of(at)) {
		if (at == data) {
			return false;
		}
	}
	k_queue_append(queue, data);
	return true;
}

int k_queue_is_empty(struct k_queue *queue)
{
	return sys_slist_is_empty(&queue->data_q);
}

void *k_queue_peek_head(struct k_queue *queue)
{
	return data_of(queue->data_q.head);
}

void *k_queue_peek_tail(struct k_queue *queue)
{
	return data_of(queue->data_q.tail);
}

void k_stack_init(struct k_stack *stack, stack_data_t *buffer, uint32_t num_entries)
{
	wait_q_init(&stack->wait_q);
	stack->base = buffer;
	stack->next = buffer;
	stack->top = buffer + num_entries;
}

int k_stack_push(struct k_stack *stack, stack_data_t data)
{
	if (stack->next == stack->top) {
		return -ENOMEM;
	}
	if (!sched_wake_first(&stack->wait_q, 0, (void *)data)) {
		*stack->next++ = data;
	}
	sched_reschedule();
	return 0;
}

int k_stack_pop(struct k_stack *stack, stack_data_t *data, k_timeout_t timeout)
{
	if (stack->next > stack->base) {
		*data = *--stack->next;
		return 0;
	}
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return -EBUSY;
	}

	const int result = sched_pend(&stack->wait_q, timeout);

	if (result == 0) {
		*data = (stack_data_t)sched_current->base.swap_data;
	}
	return result;
}
