/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The update's way into flash, with power failing after each block that is written and each page
 * that is erased. The two other threads are played here: storage by run_storage(), the command
 * thread by calling what inbox_call() is given.
 */
#include "threads/firmware.h"
#include "threads/inbox.h"
#include "threads/storage.h"

#include "host/flash_store.h"
#include "models/bootloader.h"
#include "vectors/images.h"

#include <string.h>

#include <zephyr/storage/flash_map.h>
#include <zephyr/ztest.h>

#define BLOCK 16u /* of the transfer: the image takes several */

static const struct bootloader_slots slots = {
	.first = 0,
	.second = FLASH_SLOT_SIZE,
	.size = FLASH_SLOT_SIZE,
};

static const char *failure;
static bool is_done;
static struct k_work *submitted;

void pharos_assert_failed(const char *file, int line)
{
	printk("assertion failed: %s:%d\n", file, line);
	k_oops();
	CODE_UNREACHABLE;
}

void storage_submit(struct k_work *work)
{
	submitted = work;
}

static void run_storage(void)
{
	submitted->handler(submitted);
}

int inbox_call(int (*function)(struct pharos_device *, void *), void *argument)
{
	return function(NULL, argument);
}

uint8_t devices_update_slot(void)
{
	return FIXED_PARTITION_ID(slot1_partition);
}

uint32_t devices_update_slot_size(void)
{
	return FIXED_PARTITION_SIZE(slot1_partition);
}

static void done(const char *why)
{
	is_done = true;
	failure = why;
}

/* A whole update; NULL, or why it failed. */
static const char *update(const uint8_t *image, size_t size)
{
	failure = NULL;
	firmware_begin(done);
	run_storage();
	for (size_t at = 0; at <= size && failure == NULL; at += BLOCK) {
		is_done = false;
		firmware_write(image + at, MIN(BLOCK, size - at), size - at < BLOCK);
		run_storage();
		zassert_true(is_done);
	}
	if (firmware_is_busy()) {
		zassert_not_null(failure, "what failed is erased");
		run_storage();
	}
	zassert_false(firmware_is_busy());
	return failure;
}

static void before(void *fixture)
{
	struct flash *const flash = flash_store();

	flash_power_up(flash);
	zassert_equal(flash_erase(flash, 0, flash->size), 0);
}

ZTEST_SUITE(firmware, NULL, NULL, before, NULL, NULL);

/* The sender is told; what comes of it later is erased; then there is room for the next. */
ZTEST(firmware, test_a_flash_that_does_not_answer_is_given_up)
{
	is_done = false;
	firmware_begin(done);
	k_sleep(K_MSEC(STORAGE_WAIT_MS - 1));
	zassert_false(is_done);
	k_sleep(K_MSEC(2));
	zassert_true(is_done);
	zassert_equal(strcmp(failure, "the flash does not answer"), 0);
	zassert_true(firmware_is_busy(), "it may still come");

	is_done = false;
	run_storage();
	zassert_false(is_done, "told once");
	run_storage();
	zassert_false(firmware_is_busy());
}

static void assert_second_slot_is_empty(void)
{
	uint8_t bytes[FLASH_PAGE_SIZE];

	for (uint32_t at = 0; at < FLASH_SLOT_SIZE; at += sizeof(bytes)) {
		zassert_equal(flash_read(flash_store(), slots.second + at, bytes, sizeof(bytes)),
		              0);
		for (size_t i = 0; i < sizeof(bytes); i++) {
			zassert_equal(bytes[i], 0xFF, "at %zu", at + i);
		}
	}
}

static bool first_slot_has(const uint8_t *image, size_t size)
{
	uint8_t bytes[sizeof(image_protected)];

	zassert_equal(flash_read(flash_store(), slots.first, bytes, (uint32_t)size), 0);
	return memcmp(bytes, image, size) == 0;
}

ZTEST(firmware, test_a_whole_image_is_swapped_in_and_confirmed)
{
	zassert_is_null(update(image_plain, sizeof(image_plain)));
	zassert_equal(firmware_status_get().phase, FIRMWARE_INSTALLED);
	zassert_equal(firmware_status_get().bytes, sizeof(image_plain));
	zassert_equal(bootloader_run(flash_store(), &slots), BOOTLOADER_SWAPPED);
	zassert_true(first_slot_has(image_plain, sizeof(image_plain)));
	zassert_false(firmware_status_get().confirmed);
	firmware_confirm();
	run_storage();
	zassert_true(firmware_status_get().confirmed);
	zassert_equal(bootloader_run(flash_store(), &slots), BOOTLOADER_NOTHING);
	zassert_true(first_slot_has(image_plain, sizeof(image_plain)));
}

ZTEST(firmware, test_an_unconfirmed_image_is_swapped_out_again)
{
	zassert_is_null(update(image_plain, sizeof(image_plain)));
	zassert_equal(bootloader_run(flash_store(), &slots), BOOTLOADER_SWAPPED);
	zassert_equal(bootloader_run(flash_store(), &slots), BOOTLOADER_REVERTED);
	zassert_false(first_slot_has(image_plain, sizeof(image_plain)));
	zassert_equal(bootloader_run(flash_store(), &slots), BOOTLOADER_NOTHING);
	zassert_true(firmware_status_get().confirmed);
}

/* An older image runs; power fails anywhere in the update to the newer one. */
static void update_torn_at(uint64_t byte)
{
	struct flash *const flash = flash_store();

	flash_tear(flash, byte);

	const bool was_whole = update(image_protected, sizeof(image_protected)) == NULL;

	flash_power_up(flash);

	const enum bootloader_outcome outcome = bootloader_run(flash, &slots);

	if (was_whole) {
		zassert_equal(outcome, BOOTLOADER_SWAPPED);
		zassert_true(first_slot_has(image_protected, sizeof(image_protected)));
	} else {
		zassert_equal(outcome, BOOTLOADER_NOTHING, "torn at %llu", byte);
		zassert_true(first_slot_has(image_plain, sizeof(image_plain)));
		/* And the update can be had again. */
		zassert_is_null(update(image_protected, sizeof(image_protected)));
		zassert_equal(bootloader_run(flash, &slots), BOOTLOADER_SWAPPED);
		zassert_true(first_slot_has(image_protected, sizeof(image_protected)));
	}
}

static void install_the_older(void)
{
	before(NULL);
	zassert_is_null(update(image_plain, sizeof(image_plain)));
	zassert_equal(bootloader_run(flash_store(), &slots), BOOTLOADER_SWAPPED);
	firmware_confirm();
	run_storage();
}

ZTEST(firmware, test_power_that_fails_at_any_page_leaves_the_older_image)
{
	for (uint32_t page = 0; page < FLASH_SLOT_SIZE / FLASH_PAGE_SIZE; page += 3) {
		install_the_older();
		update_torn_at((uint64_t)page * FLASH_PAGE_SIZE + FLASH_PAGE_SIZE / 2);
	}
}

/* The image's bytes, filled up to whole blocks, and the mark. */
ZTEST(firmware, test_power_that_fails_at_any_byte_written_leaves_the_older_image)
{
	const uint64_t written = ROUND_UP(sizeof(image_protected), FLASH_BLOCK_SIZE);

	for (uint64_t byte = 0; byte <= written + BOOTLOADER_MAGIC_SIZE; byte++) {
		install_the_older();
		update_torn_at(FLASH_SLOT_SIZE + byte);
	}
}

ZTEST(firmware, test_a_spoilt_image_is_not_marked)
{
	uint8_t spoilt[sizeof(image_plain)];

	memcpy(spoilt, image_plain, sizeof(spoilt));
	spoilt[50] ^= 1;
	zassert_equal(strcmp(update(spoilt, sizeof(spoilt)), "the image does not have its SHA-256"),
	              0);
	zassert_equal(firmware_status_get().phase, FIRMWARE_FAILED);
	zassert_equal(bootloader_run(flash_store(), &slots), BOOTLOADER_NOTHING);
	assert_second_slot_is_empty();
}

ZTEST(firmware, test_an_update_that_is_given_up_leaves_nothing)
{
	firmware_begin(done);
	zassert_true(firmware_is_busy());
	run_storage();
	firmware_write(image_plain, BLOCK, false);
	run_storage();
	is_done = false;
	firmware_abort("the upload broke off");
	zassert_equal(firmware_status_get().phase, FIRMWARE_FAILED);
	zassert_true(firmware_is_busy());
	run_storage();
	zassert_false(firmware_is_busy());
	zassert_false(is_done, "nobody waits for it");
	assert_second_slot_is_empty();
}
