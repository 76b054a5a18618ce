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

/* Blocks tile the heap in address order; sizes and addresses are multiples of BLOCK_ALIGN. */
#define BLOCK_ALIGN 16

struct native_heap_block {
	size_t size; /* with this header; lowest bit: in use */
	struct k_heap *heap;
};

#define HEADER_SIZE sizeof(struct native_heap_block)
#define IN_USE      ((size_t)1)

BUILD_ASSERT(HEADER_SIZE == BLOCK_ALIGN, "payloads are aligned as blocks are");

static size_t block_size(const struct native_heap_block *block)
{
	return block->size & ~IN_USE;
}

static struct native_heap_block *after(struct native_heap_block *block, size_t bytes)
{
	return (struct native_heap_block *)((char *)block + bytes);
}

/* The last header has size 0 and stays in use. */
void k_heap_init(struct k_heap *heap, void *mem, size_t bytes)
{
	const uintptr_t start = ROUND_UP(mem, BLOCK_ALIGN);
	const size_t size = ROUND_DOWN((uintptr_t)mem + bytes, BLOCK_ALIGN) - start - HEADER_SIZE;

	__ASSERT(bytes > 3 * BLOCK_ALIGN, "heap of %zu bytes", bytes);
	wait_q_init(&heap->wait_q);
	heap->first = (struct native_heap_block *)start;
	*heap->first = (struct native_heap_block){.size = size, .heap = heap};
	*after(heap->first, size) = (struct native_heap_block){.size = IN_USE, .heap = heap};
}

static void split(struct native_heap_block *block, size_t bytes)
{
	const size_t rest = block_size(block) - bytes;

	if (rest >= HEADER_SIZE) {
		*after(block, bytes) =
			(struct native_heap_block){.size = rest, .heap = block->heap};
		block->size = bytes | (block->size & IN_USE);
	}
}

static void *try_alloc(struct k_heap *heap, size_t align, size_t bytes)
{
	const size_t needed = ROUND_UP(bytes, BLOCK_ALIGN) + HEADER_SIZE;
	struct native_heap_block *block = heap->first;

	for (; block_size(block) != 0; block = after(block, block_size(block))) {
		const uintptr_t payload = (uintptr_t)block + HEADER_SIZE;
		const size_t gap = ROUND_UP(payload, align) - payload;

		if ((block->size & IN_USE) != 0 || block->size < gap ||
		    block->size - gap < needed) {
			continue;
		}
		if (gap > 0) {
			split(block, gap);
			block = after(block, gap);
		}
		split(block, needed);
		block->size |= IN_USE;
		return (char *)block + HEADER_SIZE;
	}
	return NULL;
}

static void join_free_blocks(struct k_heap *heap)
{
	struct native_heap_block *block = heap->first;

	while (block_size(block) != 0) {
		struct native_heap_block *const next = after(block, block_size(block));

		if (((block->size | next->size) & IN_USE) == 0) {
			block->size += next->size;
		} else {
			block = next;
		}
	}
}

void *k_heap_aligned_alloc(struct k_heap *heap, size_t align, size_t bytes, k_timeout_t timeout)
{
	const k_timepoint_t end = sys_timepoint_calc(timeout);
	const size_t alignment = MAX(align, BLOCK_ALIGN);

	__ASSERT(IS_POWER_OF_TWO(alignment), "alignment %zu", align);
	if (bytes == 0 || bytes > SIZE_MAX / 2) {
		return NULL;
	}
	while (true) {
		void *const mem = try_alloc(heap, alignment, bytes);
		const k_timeout_t left = sys_timepoint_timeout(end);

		if (mem != NULL || K_TIMEOUT_EQ(left, K_NO_WAIT)) {
			return mem;
		}
		(void)sched_pend(&heap->wait_q, left);
	}
}

void *k_heap_alloc(struct k_heap *heap, size_t bytes, k_timeout_t timeout)
{
	return k_heap_aligned_alloc(heap, BLOCK_ALIGN, bytes, timeout);
}

void k_heap_free(struct k_heap *heap, void *mem)
{
	if (mem == NULL) {
		return;
	}

	struct native_heap_block *const block =
		(struct native_heap_block *)((char *)mem - HEADER_SIZE);

	__ASSERT(block->heap == heap && (block->size & IN_USE) != 0,
	         "freed twice, or not from here");
	block->size &= ~IN_USE;
	join_free_blocks(heap);
	if (sched_wake_all(&heap->wait_q, 0) > 0) {
		sched_reschedule();
	}
}

void k_free(void *ptr)
{
	if (ptr != NULL) {
		k_heap_free(((struct native_heap_block *)((char *)ptr - HEADER_SIZE))->heap, ptr);
	}
}

#if CONFIG_HEAP_MEM_POOL_SIZE > 0
K_HEAP_DEFINE(_system_heap, CONFIG_HEAP_MEM_POOL_SIZE);

void *k_aligned_alloc(size_t align, size_t size)
{
	return k_heap_aligned_alloc(&_system_heap, align, size, K_NO_WAIT);
}

void *k_malloc(size_t size)
{
	return k_aligned_alloc(BLOCK_ALIGN, size);
}

void *k_calloc(size_t nmemb, size_t size)
{
	size_t bytes;

	if (__builtin_mul_overflow(nmemb, size, &bytes)) {
		return NULL;
	}

	void *const mem = k_malloc(bytes);

	if (mem != NULL) {
		memset(mem, 0, bytes);
	}
	return mem;
}
#define SYSTEM_HEAP (&_system_heap)
#else
#define SYSTEM_HEAP NULL
#endif

void *z_thread_malloc(size_t size)
{
	struct k_heap *const heap =
		native_cpu.isr_depth > 0 ? SYSTEM_HEAP : sched_current->resource_pool;

	return heap != NULL ? k_heap_alloc(heap, size, K_NO_WAIT) : NULL;
}

void mem_init(void)
{
	STRUCT_SECTION_FOREACH(k_mem_slab, slab) {
		slab_link_blocks(slab);
	}
	STRUCT_SECTION_FOREACH(k_heap, heap) {
		k_heap_init(heap, heap->init_mem, heap->init_bytes);
	}
}
