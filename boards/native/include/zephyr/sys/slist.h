/* SPDX-License-Identifier: Apache-2.0 */
/* Singly-linked list with head and tail. */
#ifndef ZEPHYR_SYS_SLIST_H_
#define ZEPHYR_SYS_SLIST_H_

#include <stdbool.h>
#include <stddef.h>

#include <zephyr/sys/util.h>

struct _snode {
	struct _snode *next;
};

typedef struct _snode sys_snode_t;

struct _slist {
	sys_snode_t *head;
	sys_snode_t *tail;
};

typedef struct _slist sys_slist_t;

#define SYS_SLIST_STATIC_INIT(ptr_to_list)                                                         \
	{                                                                                          \
		NULL, NULL                                                                         \
	}

static inline void sys_slist_init(sys_slist_t *list)
{
	list->head = NULL;
	list->tail = NULL;
}

static inline bool sys_slist_is_empty(const sys_slist_t *list)
{
	return list->head == NULL;
}

static inline sys_snode_t *sys_slist_peek_head(const sys_slist_t *list)
{
	return list->head;
}

static inline sys_snode_t *sys_slist_peek_tail(const sys_slist_t *list)
{
	return list->tail;
}

static inline sys_snode_t *sys_slist_peek_next_no_check(const sys_snode_t *node)
{
	return node->next;
}

static inline sys_snode_t *sys_slist_peek_next(const sys_snode_t *node)
{
	return (node != NULL) ? node->next : NULL;
}

static inline void sys_slist_prepend(sys_slist_t *list, sys_snode_t *node)
{
	node->next = list->head;
	list->head = node;
	if (list->tail == NULL) {
		list->tail = node;
	}
}

static inline void sys_slist_append(sys_slist_t *list, sys_snode_t *node)
{
	node->next = NULL;
	if (list->tail == NULL) {
		list->head = node;
	} else {
		list->tail->next = node;
	}
	list->tail = node;
}

/* Appends the chain head…tail, which is linked already. */
static inline void sys_slist_append_list(sys_slist_t *list, void *head, void *tail)
{
	if (head == NULL || tail == NULL) {
		return;
	}
	if (list->tail == NULL) {
		list->head = (sys_snode_t *)head;
	} else {
		list->tail->next = (sys_snode_t *)head;
	}
	list->tail = (sys_snode_t *)tail;
}

static inline void sys_slist_merge_slist(sys_slist_t *list, sys_slist_t *list_to_append)
{
	sys_slist_append_list(list, list_to_append->head, list_to_append->tail);
	sys_slist_init(list_to_append);
}

/* Inserts node after prev; prev == NULL: at the head. */
static inline void sys_slist_insert(sys_slist_t *list, sys_snode_t *prev, sys_snode_t *node)
{
	if (prev == NULL) {
		sys_slist_prepend(list, node);
	} else if (prev->next == NULL) {
		sys_slist_append(list, node);
	} else {
		node->next = prev->next;
		prev->next = node;
	}
}

static inline sys_snode_t *sys_slist_get_not_empty(sys_slist_t *list)
{
	sys_snode_t *node = list->head;

	list->head = node->next;
	if (list->tail == node) {
		list->tail = list->head;
	}
	return node;
}

static inline sys_snode_t *sys_slist_get(sys_slist_t *list)
{
	return sys_slist_is_empty(list) ? NULL : sys_slist_get_not_empty(list);
}

/* prev_node is the one before node, or NULL when node is the head. */
static inline void sys_slist_remove(sys_slist_t *list, sys_snode_t *prev_node, sys_snode_t *node)
{
	if (prev_node == NULL) {
		list->head = node->next;
	} else {
		prev_node->next = node->next;
	}
	if (list->tail == node) {
		list->tail = prev_node;
	}
	node->next = NULL;
}

static inline bool sys_slist_find_and_remove(sys_slist_t *list, sys_snode_t *node)
{
	sys_snode_t *prev = NULL;

	for (sys_snode_t *at = list->head; at != NULL; prev = at, at = at->next) {
		if (at == node) {
			sys_slist_remove(list, prev, node);
			return true;
		}
	}
	return false;
}

static inline size_t sys_slist_len(const sys_slist_t *list)
{
	size_t count = 0;

	for (const sys_snode_t *node = list->head; node != NULL; node = node->next) {
		count++;
	}
	return count;
}

#define SYS_SLIST_FOR_EACH_NODE(list, node)                                                        \
	for (node = sys_slist_peek_head(list); node != NULL; node = sys_slist_peek_next(node))

/* The current node may be removed in the loop's body. */
#define SYS_SLIST_FOR_EACH_NODE_SAFE(list, node, safe)                                             \
	for (node = sys_slist_peek_head(list), safe = sys_slist_peek_next(node); node != NULL;     \
	     node = safe, safe = sys_slist_peek_next(node))

#define SYS_SLIST_CONTAINER(node, container, field)                                                \
	(((node) != NULL) ? CONTAINER_OF(node, __typeof__(*(container)), field) : NULL)

#define SYS_SLIST_PEEK_HEAD_CONTAINER(list, container, field)                                      \
	SYS_SLIST_CONTAINER(sys_slist_peek_head(list), container, field)

#define SYS_SLIST_PEEK_TAIL_CONTAINER(list, container, field)                                      \
	SYS_SLIST_CONTAINER(sys_slist_peek_tail(list), container, field)

#define SYS_SLIST_PEEK_NEXT_CONTAINER(container, field)                                            \
	(((container) != NULL) ? SYS_SLIST_CONTAINER(sys_slist_peek_next(&((container)->field)),   \
	                                             container, field)                             \
	                       : NULL)

#define SYS_SLIST_FOR_EACH_CONTAINER(list, container, field)                                       \
	for (container = SYS_SLIST_PEEK_HEAD_CONTAINER(list, container, field); container != NULL; \
	     container = SYS_SLIST_PEEK_NEXT_CONTAINER(container, field))

#define SYS_SLIST_FOR_EACH_CONTAINER_SAFE(list, container, safe, field)                            \
	for (container = SYS_SLIST_PEEK_HEAD_CONTAINER(list, container, field),                    \
	    safe = SYS_SLIST_PEEK_NEXT_CONTAINER(container, field);                                \
	     container != NULL;                                                                    \
	     container = safe, safe = SYS_SLIST_PEEK_NEXT_CONTAINER(container, field))

#endif
