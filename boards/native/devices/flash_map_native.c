/* SPDX-License-Identifier: Apache-2.0 */
#include <zephyr/storage/flash_map.h>

#include <errno.h>
#include <string.h>

#include "devices/fault.h"
#include "host/flash_store.h"

#define AREA(label)                                                                                \
	{                                                                                          \
		.fa_id = FIXED_PARTITION_ID(label), .fa_off = FIXED_PARTITION_OFFSET(label),       \
		.fa_size = FIXED_PARTITION_SIZE(label),                                            \
	}

static const struct flash_area areas[] = {AREA(slot0_partition), AREA(slot1_partition)};

_Static_assert(FIXED_PARTITION_OFFSET(slot0_partition) == 0 &&
                       FIXED_PARTITION_OFFSET(slot1_partition) == FLASH_SLOT_SIZE &&
                       FIXED_PARTITION_SIZE(slot0_partition) == FLASH_SLOT_SIZE &&
                       FIXED_PARTITION_SIZE(slot1_partition) == FLASH_SLOT_SIZE,
               "the bootloader's model has native.dts's slots");
_Static_assert(FIXED_PARTITION_ID(slot1_partition) <= UINT8_MAX, "an id is 8 bits");

int flash_area_open(uint8_t id, const struct flash_area **fa)
{
	for (size_t i = 0; i < sizeof(areas) / sizeof(areas[0]); i++) {
		if (areas[i].fa_id == id) {
			*fa = &areas[i];
			return 0;
		}
	}
	return -ENOENT;
}

void flash_area_close(const struct flash_area *fa)
{
}

static bool is_inside(const struct flash_area *fa, off_t off, size_t len)
{
	return off >= 0 && (size_t)off <= fa->fa_size && len <= fa->fa_size - (size_t)off;
}

static uint32_t at(const struct flash_area *fa, off_t off)
{
	return (uint32_t)(fa->fa_off + off);
}

/* What was changed, also where power failed meanwhile. rc: how that went. */
static int keep(const struct flash_area *fa, off_t off, size_t len, int rc)
{
	const int kept = flash_store_keep(at(fa, off), (uint32_t)len);

	return rc != 0 ? rc : kept;
}

int flash_area_read(const struct flash_area *fa, off_t off, void *dst, size_t len)
{
	return is_inside(fa, off, len) ? flash_read(flash_store(), at(fa, off), dst, (uint32_t)len)
	                               : -EINVAL;
}

int flash_area_write(const struct flash_area *fa, off_t off, const void *src, size_t len)
{
	const int fault = fault_pass(BOARD_CHIP_FLASH);

	if (fault != 0) {
		return fault;
	}
	return is_inside(fa, off, len)
	               ? keep(fa, off, len,
	                      flash_write(flash_store(), at(fa, off), src, (uint32_t)len))
	               : -EINVAL;
}

int flash_area_erase(const struct flash_area *fa, off_t off, size_t len)
{
	const int fault = fault_pass(BOARD_CHIP_FLASH);

	if (fault != 0) {
		return fault;
	}
	return is_inside(fa, off, len)
	               ? keep(fa, off, len, flash_erase(flash_store(), at(fa, off), (uint32_t)len))
	               : -EINVAL;
}

uint32_t flash_area_align(const struct flash_area *fa)
{
	return FLASH_BLOCK_SIZE;
}

uint8_t flash_area_erased_val(const struct flash_area *fa)
{
	return UINT8_MAX;
}
