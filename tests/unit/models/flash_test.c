/* SPDX-License-Identifier: Apache-2.0 */
#include "models/flash.h"

#include <errno.h>
#include <string.h>

#include <zephyr/ztest.h>

static uint8_t memory[2 * FLASH_PAGE_SIZE];
static struct flash flash;
static uint8_t bytes[FLASH_PAGE_SIZE];

static void before(void *fixture)
{
	memset(memory, 0, sizeof(memory));
	flash = (struct flash){.inverted = memory, .size = sizeof(memory)};
	memset(bytes, 0x5A, sizeof(bytes));
}

ZTEST_SUITE(model_flash, NULL, NULL, before, NULL, NULL);

static uint8_t at(uint32_t offset)
{
	uint8_t byte = 0;

	zassert_equal(flash_read(&flash, offset, &byte, 1), 0);
	return byte;
}

ZTEST(model_flash, test_erased_is_ones_and_what_is_written_is_read)
{
	zassert_equal(at(0), 0xFF);
	zassert_equal(flash_write(&flash, 8, bytes, 16), 0);
	zassert_equal(at(7), 0xFF);
	zassert_equal(at(8), 0x5A);
	zassert_equal(at(23), 0x5A);
	zassert_equal(at(24), 0xFF);
	zassert_equal(flash_erase(&flash, 0, FLASH_PAGE_SIZE), 0);
	zassert_equal(at(8), 0xFF);
}

ZTEST(model_flash, test_a_block_is_programmed_once)
{
	zassert_equal(flash_write(&flash, 0, bytes, 8), 0);
	zassert_equal(flash_write(&flash, 0, bytes, 8), -EIO);
	zassert_equal(flash_write(&flash, 8, bytes, 8), 0);
}

ZTEST(model_flash, test_only_whole_blocks_and_pages_inside)
{
	zassert_equal(flash_write(&flash, 4, bytes, 8), -EINVAL);
	zassert_equal(flash_write(&flash, 0, bytes, 4), -EINVAL);
	zassert_equal(flash_write(&flash, sizeof(memory), bytes, 8), -EINVAL);
	zassert_equal(flash_write(&flash, sizeof(memory) - 8, bytes, 16), -EINVAL);
	zassert_equal(flash_erase(&flash, 8, FLASH_PAGE_SIZE), -EINVAL);
	zassert_equal(flash_erase(&flash, 0, 8), -EINVAL);
	zassert_equal(flash_read(&flash, UINT32_MAX, bytes, 2), -EINVAL);
}

ZTEST(model_flash, test_power_fails_at_the_byte)
{
	flash_tear(&flash, 11);
	zassert_equal(flash_write(&flash, 0, bytes, 8), 0);
	zassert_equal(flash_write(&flash, 8, bytes, 8), -EIO);
	zassert_equal(flash_read(&flash, 0, bytes, 1), -EIO);
	flash_power_up(&flash);
	/* The block of bytes 8 to 15 was only begun. */
	zassert_equal(at(7), 0x5A);
	zassert_equal(flash_read(&flash, 0, bytes, 8), 0);
	zassert_equal(flash_read(&flash, 0, bytes, 9), -EIO);
	zassert_equal(flash_read(&flash, 15, bytes, 1), -EIO);
	zassert_equal(at(16), 0xFF);
	zassert_equal(flash_write(&flash, 8, bytes, 8), -EIO);
	zassert_equal(flash_erase(&flash, 0, FLASH_PAGE_SIZE), 0);
	zassert_equal(at(8), 0xFF);
	zassert_equal(flash_write(&flash, 8, bytes, 8), 0);
}

ZTEST(model_flash, test_power_that_fails_between_two_blocks_leaves_them_readable)
{
	flash_tear(&flash, 8);
	zassert_equal(flash_write(&flash, 0, bytes, 16), -EIO);
	flash_power_up(&flash);
	zassert_equal(at(7), 0x5A);
	zassert_equal(at(8), 0xFF);
}

ZTEST(model_flash, test_power_fails_within_an_erase)
{
	zassert_equal(flash_write(&flash, 0, bytes, sizeof(bytes)), 0);
	zassert_equal(flash_write(&flash, FLASH_PAGE_SIZE, bytes, sizeof(bytes)), 0);
	flash_tear(&flash, FLASH_PAGE_SIZE + 100);
	zassert_equal(flash_erase(&flash, 0, sizeof(memory)), -EIO);
	flash_power_up(&flash);
	zassert_equal(at(FLASH_PAGE_SIZE - 1), 0xFF);
	zassert_equal(at(FLASH_PAGE_SIZE + 99), 0xFF);
	zassert_equal(at(FLASH_PAGE_SIZE + 100), 0x5A);
}
