/* SPDX-License-Identifier: Apache-2.0 */
/* Memory: slabs of equal blocks. */
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

#endif
