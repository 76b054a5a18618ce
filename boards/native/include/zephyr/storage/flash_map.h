/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The flash's partitions, by Zephyr's names: the two image slots of the native board.
 *
 * Offsets are from the begin of the area. Calls return 0 or -errno: -EINVAL outside of the area or
 * not aligned, -EIO not erased or no power, -ENOENT no such area. Threads.
 */
#ifndef ZEPHYR_STORAGE_FLASH_MAP_H_
#define ZEPHYR_STORAGE_FLASH_MAP_H_

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include <zephyr/devicetree.h>

struct flash_area {
	uint8_t fa_id;
	off_t fa_off;
	size_t fa_size;
};

#define FIXED_PARTITION_EXISTS(label) DT_NODE_EXISTS(DT_NODELABEL(label))
#define FIXED_PARTITION_ID(label)     DT_DEP_ORD(DT_NODELABEL(label))
#define FIXED_PARTITION_OFFSET(label) DT_REG_ADDR(DT_NODELABEL(label))
#define FIXED_PARTITION_SIZE(label)   DT_REG_SIZE(DT_NODELABEL(label))

int flash_area_open(uint8_t id, const struct flash_area **fa);
void flash_area_close(const struct flash_area *fa);
int flash_area_read(const struct flash_area *fa, off_t off, void *dst, size_t len);

/* off, len: whole blocks of flash_area_align(). */
int flash_area_write(const struct flash_area *fa, off_t off, const void *src, size_t len);

/* off, len: whole pages. */
int flash_area_erase(const struct flash_area *fa, off_t off, size_t len);
uint32_t flash_area_align(const struct flash_area *fa);
uint8_t flash_area_erased_val(const struct flash_area *fa);

#endif
