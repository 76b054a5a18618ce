/* SPDX-License-Identifier: Apache-2.0 */
/* Memory: slabs of equal blocks, heaps over a given buffer, and the system heap behind k_malloc().
 */
#ifndef ZEPHYR_KERNEL_MEM_H_
#define ZEPHYR_KERNEL_MEM_H_

#include <zephyr/kernel/thread.h>

struct k_mem_slab {
	_wait_q_t wait_q;
	uint32_t num_blocks;
	size_t block_size;
	char *buffer;
	char *free_list; /* each free block begins with the next one's address */
	uint32_t num_used;
	uint32_t max_used;
};

#define Z_MEM_SLAB_INITIALIZER(obj, slab_buffer, slab_block_size, slab_num_blocks)                 \
	{                                                                                          \
		.wait_q = Z_WAIT_Q_INIT(&(obj).wait_q), .num_blocks = (slab_num_blocks),           \
		.block_size = (slab_block_size), .buffer = (slab_buffer)                           \
	}
#define K_MEM_SLAB_DEFINE(name, slab_block_size, slab_num_blocks, slab_align)                      \
	static char __aligned(WB_UP(slab_align))                                                   \
		_k_mem_slab_buf_##name[(slab_num_blocks)*WB_UP(slab_block_size)];                  \
	STRUCT_SECTION_ITERABLE(k_mem_slab, name) = Z_MEM_SLAB_INITIALIZER(                        \
		name, _k_mem_slab_buf_##name, WB_UP(slab_block_size), slab_num_blocks)
#define K_MEM_SLAB_DEFINE_STATIC(name, slab_block_size, slab_num_blocks, slab_align)               \
	static char __aligned(WB_UP(slab_align))                                                   \
		_k_mem_slab_buf_##name[(slab_num_blocks)*WB_UP(slab_block_size)];                  \
	static STRUCT_SECTION_ITERABLE(k_mem_slab, name) = Z_MEM_SLAB_INITIALIZER(                 \
		name, _k_mem_slab_buf_##name, WB_UP(slab_block_size), slab_num_blocks)

/* -EINVAL: block_size or buffer is not aligned to a pointer. */
int k_mem_slab_init(struct k_mem_slab *slab, void *buffer, size_t block_size, uint32_t num_blocks);
/* 0; -ENOMEM: none and K_NO_WAIT; -EAGAIN: timeout. */
int k_mem_slab_alloc(struct k_mem_slab *slab, void **mem, k_timeout_t timeout);
/* Any context. As from Zephyr 3.5: the block itself. */
void k_mem_slab_free(struct k_mem_slab *slab, void *mem);

static inline uint32_t k_mem_slab_num_used_get(struct k_mem_slab *slab)
{
	return slab->num_used;
}

static inline uint32_t k_mem_slab_max_used_get(struct k_mem_slab *slab)
{
	return slab->max_used;
}

static inline uint32_t k_mem_slab_num_free_get(struct k_mem_slab *slab)
{
	return slab->num_blocks - slab->num_used;
}

/* First fit in address order; neighbours are joined when freed. */
struct native_heap_block;

struct k_heap {
	struct native_heap_block *first;
	void *init_mem;
	size_t init_bytes;
	_wait_q_t wait_q;
};

#define Z_HEAP_MIN_SIZE 64
#define K_HEAP_DEFINE(name, bytes)                                                                 \
	static char __aligned(16) kheap_##name[ROUND_UP(MAX(bytes, Z_HEAP_MIN_SIZE), 16)];         \
	STRUCT_SECTION_ITERABLE(k_heap, name) = {                                                  \
		.init_mem = kheap_##name,                                                          \
		.init_bytes = sizeof(kheap_##name),                                                \
		.wait_q = Z_WAIT_Q_INIT(&(name).wait_q),                                           \
	}

void k_heap_init(struct k_heap *heap, void *mem, size_t bytes);
/* NULL: no room before the timeout, or bytes is 0. align: a power of two. */
void *k_heap_alloc(struct k_heap *heap, size_t bytes, k_timeout_t timeout);
void *k_heap_aligned_alloc(struct k_heap *heap, size_t align, size_t bytes, k_timeout_t timeout);
void k_heap_free(struct k_heap *heap, void *mem);

#if CONFIG_HEAP_MEM_POOL_SIZE > 0
extern struct k_heap _system_heap;
void *k_malloc(size_t size);
void *k_calloc(size_t nmemb, size_t size);
void *k_aligned_alloc(size_t align, size_t size);
#endif
/* For blocks of k_malloc() and of allocations from the threads' heaps. NULL: no effect. */
void k_free(void *ptr);
/* From the heap assigned to the current thread; in interrupts from the system heap. */
void *z_thread_malloc(size_t size);

#endif
