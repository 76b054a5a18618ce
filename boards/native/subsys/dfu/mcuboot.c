/* SPDX-License-Identifier: Apache-2.0 */
#include <zephyr/dfu/mcuboot.h>

#include <errno.h>
#include <stdint.h>
#include <string.h>

#include <zephyr/storage/flash_map.h>

#include "models/bootloader.h"

/* A place in a slot's trailer, from the slot's end. */
static int read_at(uint8_t area_id, uint32_t from_end, void *data, size_t size)
{
	const struct flash_area *area;
	const int error = flash_area_open(area_id, &area);

	return error != 0 ? error
	                  : flash_area_read(area, (off_t)(area->fa_size - from_end), data, size);
}

static int write_at(uint8_t area_id, uint32_t from_end, const void *data, size_t size)
{
	const struct flash_area *area;
	const int error = flash_area_open(area_id, &area);

	return error != 0 ? error
	                  : flash_area_write(area, (off_t)(area->fa_size - from_end), data, size);
}

static int set_flag(uint8_t area_id, uint32_t from_end)
{
	uint8_t block[FLASH_BLOCK_SIZE];

	memset(block, UINT8_MAX, sizeof(block));
	block[0] = BOOTLOADER_FLAG_SET;
	return write_at(area_id, from_end, block, sizeof(block));
}

static bool has_magic(uint8_t area_id)
{
	uint8_t magic[BOOTLOADER_MAGIC_SIZE];

	return read_at(area_id, BOOTLOADER_AT_MAGIC, magic, sizeof(magic)) == 0 &&
	       memcmp(magic, bootloader_magic, sizeof(magic)) == 0;
}

int boot_request_upgrade(int permanent)
{
	const uint8_t slot = FIXED_PARTITION_ID(slot1_partition);

	if (has_magic(slot)) {
		return 0;
	}
	/* The flag comes first: without the magic nothing is in force. */
	const int error = permanent ? set_flag(slot, BOOTLOADER_AT_IMAGE_OK) : 0;

	return error != 0 ? error
	                  : write_at(slot, BOOTLOADER_AT_MAGIC, bootloader_magic,
	                             sizeof(bootloader_magic));
}

bool boot_is_img_confirmed(void)
{
	const uint8_t slot = FIXED_PARTITION_ID(slot0_partition);
	uint8_t flag = 0;

	return !has_magic(slot) || (read_at(slot, BOOTLOADER_AT_IMAGE_OK, &flag, 1) == 0 &&
	                            flag == BOOTLOADER_FLAG_SET);
}

int boot_write_img_confirmed(void)
{
	return boot_is_img_confirmed()
	               ? 0
	               : set_flag(FIXED_PARTITION_ID(slot0_partition), BOOTLOADER_AT_IMAGE_OK);
}
