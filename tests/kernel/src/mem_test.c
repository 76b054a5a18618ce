/* SPDX-License-Identifier: Apache-2.0 */
/* Slabs. */
#include "helper.h"

#if __has_include(<version.h>)
#include <version.h>
#elif __has_include(<zephyr/version.h>)
#include <zephyr/version.h>
#endif

/* Zephyr before 3.5 took the address of the pointer. */
#if defined(KERNEL_VERSION_NUMBER) && KERNEL_VERSION_NUMBER < 0x030500
#define slab_free(slab, mem) k_mem_slab_free(slab, &(mem))
#else
#define slab_free(slab, mem) k_mem_slab_free(slab, mem)
#endif

K_MEM_SLAB_DEFINE(static_slab, 24, 3, 8);

static struct k_timer timer;
static void *timer_block;

static void free_in_interrupt(struct k_timer *which)
{
	slab_free(&static_slab, timer_block);
}

ZTEST(kernel_mem, test_slab)
{
	void *blocks[3], *extra;

	for (int i = 0; i < 3; i++) {
		zassert_ok(k_mem_slab_alloc(&static_slab, &blocks[i], K_NO_WAIT));
		memset(blocks[i], 0xa5, 24);
	}
	zassert_equal(k_mem_slab_alloc(&static_slab, &extra, K_NO_WAIT), -ENOMEM);
	zassert_equal(k_mem_slab_alloc(&static_slab, &extra, K_TICKS(3)), -EAGAIN);
	zassert_equal(k_mem_slab_num_used_get(&static_slab), 3);
	timer_block = blocks[1];
	k_timer_init(&timer, free_in_interrupt, NULL);
	k_timer_start(&timer, K_TICKS(5), K_NO_WAIT);
	zassert_ok(k_mem_slab_alloc(&static_slab, &extra, K_FOREVER));
	zassert_equal_ptr(extra, blocks[1]);
	for (int i = 0; i < 3; i++) {
		slab_free(&static_slab, blocks[i]);
	}
	zassert_equal(k_mem_slab_num_free_get(&static_slab), 3);
}

ZTEST(kernel_mem, test_slab_alignment)
{
	static char __aligned(8) buffer[64];
	struct k_mem_slab slab;

	zassert_equal(k_mem_slab_init(&slab, buffer + 1, 16, 2), -EINVAL);
	zassert_equal(k_mem_slab_init(&slab, buffer, 15, 2), -EINVAL);
	zassert_equal(k_mem_slab_init(&slab, buffer, 16, 2), 0);
}

ZTEST_SUITE(kernel_mem, NULL, NULL, NULL, NULL, NULL);
