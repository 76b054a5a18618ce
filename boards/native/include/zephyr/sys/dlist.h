/* SPDX-License-Identifier: Apache-2.0 */
/* Doubly-linked list, circular through its head. A node outside any list has next == NULL. */
#ifndef ZEPHYR_SYS_DLIST_H_
#define ZEPHYR_SYS_DLIST_H_

#include <stdbool.h>
#include <stddef.h>

#include <zephyr/sys/util.h>

struct _dnode {
	struct _dnode *next;
	struct _dnode *prev;
};

typedef struct _dnode sys_dlist_t;
typedef struct _dnode sys_dnode_t;

#define SYS_DLIST_STATIC_INIT(ptr_to_list)                                                         \
	{                                                                                          \
		(ptr_to_list), (ptr_to_list)                                                       \
	}

static inline void sys_dlist_init(sys_dlist_t *list)
{
	list->next = list;
	list->prev = list;
}

static inline void sys_dnode_init(sys_dnode_t *node)
{
	node->next = NULL;
	node->prev = NULL;
}

static inline bool sys_dnode_is_linked(const sys_dnode_t *node)
{
	return node->next != NULL;
}

static inline bool sys_dlist_is_empty(const sys_dlist_t *list)
{
	return list->next == list;
}

static inline bool sys_dlist_has_multiple_nodes(const sys_dlist_t *list)
{
	return list->next != list->prev;
}

static inline bool sys_dlist_is_head(const sys_dlist_t *list, const sys_dnode_t *node)
{
	return list->next == node;
}

static inline bool sys_dlist_is_tail(const sys_dlist_t *list, const sys_dnode_t *node)
{
	return list->prev == node;
}

static inline sys_dnode_t *sys_dlist_peek_head(const sys_dlist_t *list)
{
	return sys_dlist_is_empty(list) ? NULL : list->next;
}

static inline sys_dnode_t *sys_dlist_peek_head_not_empty(const sys_dlist_t *list)
{
	return list->next;
}

static inline sys_dnode_t *sys_dlist_peek_tail(const sys_dlist_t *list)
{
	return sys_dlist_is_empty(list) ? NULL : list->prev;
}

static inline sys_dnode_t *sys_dlist_peek_next(const sys_dlist_t *list, const sys_dnode_t *node)
{
	return (node == NULL || node == list->prev) ? NULL : node->next;
}

static inline sys_dnode_t *sys_dlist_peek_prev(const sys_dlist_t *list, const sys_dnode_t *node)
{
	return (node == NULL || node == list->next) ? NULL : node->prev;
}

/* Inserts node before successor. */
static inline void sys_dlist_insert(sys_dnode_t *successor, sys_dnode_t *node)
{
	node->prev = successor->prev;
	node->next = successor;
	successor->prev->next = node;
	successor->prev = node;
}

static inline void sys_dlist_append(sys_dlist_t *list, sys_dnode_t *node)
{
	sys_dlist_insert(list, node);
}

static inline void sys_dlist_prepend(sys_dlist_t *list, sys_dnode_t *node)
{
	sys_dlist_insert(list->next, node);
}

static inline void sys_dlist_remove(sys_dnode_t *node)
{
	node->prev->next = node->next;
	node->next->prev = node->prev;
	sys_dnode_init(node);
}

static inline sys_dnode_t *sys_dlist_get(sys_dlist_t *list)
{
	sys_dnode_t *node = sys_dlist_peek_head(list);

	if (node != NULL) {
		sys_dlist_remove(node);
	}
	return node;
}

static inline size_t sys_dlist_len(const sys_dlist_t *list)
{
	size_t count = 0;

	for (const sys_dnode_t *node = list->next; node != list; node = node->next) {
		count++;
	}
	return count;
}

#define SYS_DLIST_FOR_EACH_NODE(list, node)                                                        \
	for (node = sys_dlist_peek_head(list); node != NULL; node = sys_dlist_peek_next(list, node))

/* The current node may be removed in the loop's body. */
#define SYS_DLIST_FOR_EACH_NODE_SAFE(list, node, safe)                                             \
	for (node = sys_dlist_peek_head(list), safe = sys_dlist_peek_next(list, node);             \
	     node != NULL; node = safe, safe = sys_dlist_peek_next(list, node))

#define SYS_DLIST_CONTAINER(node, container, field)                                                \
	(((node) != NULL) ? CONTAINER_OF(node, __typeof__(*(container)), field) : NULL)

#define SYS_DLIST_PEEK_HEAD_CONTAINER(list, container, field)                                      \
	SYS_DLIST_CONTAINER(sys_dlist_peek_head(list), container, field)

#define SYS_DLIST_PEEK_NEXT_CONTAINER(list, container, field)                                      \
	(((container) != NULL)                                                                     \
	         ? SYS_DLIST_CONTAINER(sys_dlist_peek_next(list, &((container)->field)),           \
	                               container, field)                                           \
	         : NULL)

#define SYS_DLIST_FOR_EACH_CONTAINER(list, container, field)                                       \
	for (container = SYS_DLIST_PEEK_HEAD_CONTAINER(list, container, field); container != NULL; \
	     container = SYS_DLIST_PEEK_NEXT_CONTAINER(list, container, field))

#define SYS_DLIST_FOR_EACH_CONTAINER_SAFE(list, container, safe, field)                            \
	for (container = SYS_DLIST_PEEK_HEAD_CONTAINER(list, container, field),                    \
	    safe = SYS_DLIST_PEEK_NEXT_CONTAINER(list, container, field);                          \
	     container != NULL;                                                                    \
	     container = safe, safe = SYS_DLIST_PEEK_NEXT_CONTAINER(list, safe, field))

#endif
