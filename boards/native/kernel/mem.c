/* SPDX-License-Identifier: Apache-2.0 */
#include "sched.h"

static void slab_link_blocks(struct k_mem_slab *slab)
{
	slab->free_list = NULL;
	for (uint32_t i = slab->num_blocks; i > 0; i--) {
		char *const block = slab->buffer + (i - 1) * slab->block_size;

		*(char **)block = slab->free_list;
		slab->free_list = block;
	}
}

int k_mem_slab_init(struct k_mem_slab *slab, void *buffer, size_t block_size, uint32_t num_blocks)
{
	if ((((uintptr_t)buffer | block_size) & (sizeof(void *) - 1)) != 0) {
		return -EINVAL;
	}
	*slab = (struct k_mem_slab){
		.num_blocks = num_blocks,
		.block_size = block_size,
		.buffer = buffer,
	};
	wait_q_init(&slab->wait_q);
	slab_link_blocks(slab);
	return 0;
}

int k_mem_slab_alloc(struct k_mem_slab *slab, void **mem, k_timeout_t timeout)
{
	int result = 0;

	if (slab->free_list != NULL) {
		*mem = slab->free_list;
		slab->free_list = *(char **)slab->free_list;
		slab->num_used++;
		slab->max_used = MAX(slab->max_used, slab->num_used);
		return 0;
	}
	*mem = NULL;
	if (K_TIMEOUT_EQ(timeout, K_NO_WAIT)) {
		return -ENOMEM;
	}
	result = sched_pend(&slab->wait_q, timeout);
	if (result == 0) {
		*mem = sched_current->base.swap_data;
	}
	return result;
}

void k_mem_slab_free(struct k_mem_slab *slab, void *mem)
{
	__ASSERT((char *)mem >= slab->buffer &&
	                 (char *)mem < slab->buffer + slab->num_blocks * slab->block_size &&
	                 (size_t)((char *)mem - slab->buffer) % slab->block_size == 0,
	         "not a block of this slab");
	if (!sched_wake_first(&slab->wait_q, 0, mem)) {
		*(char **)mem = slab->free_list;
		slab->free_list = mem;
		slab->num_used--;
	}
	sched_reschedule();
}

void mem_init(void)
{
	STRUCT_SECTION_FOREACH(k_mem_slab, slab) {
		slab_link_blocks(slab);
	}
}
