/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/firmware.h"

#include <string.h>

#include <zephyr/dfu/mcuboot.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/storage/flash_map.h>
#include <zephyr/sys/util.h>

#include "core/assert.h"
#include "core/sha256.h"
#include "threads/devices.h"
#include "threads/inbox.h"
#include "threads/storage.h"

LOG_MODULE_REGISTER(firmware);

/* The largest block that a flash is programmed by; a last one is filled up to it. */
#define FLASH_BLOCK_MAX 32
#define READ_BACK_SIZE  128

enum job_kind {
	JOB_NONE,
	JOB_ERASE,
	JOB_WRITE,
	JOB_WRITE_LAST,
	JOB_CLEAN, /* of an update that failed: nobody waits for it */
};

/* From the command thread to the storage thread, one at a time: the other waits for it. */
struct job {
	atomic_t kind;
	const uint8_t *data;
	size_t size;
	const char *failure; /* the answer */
};

static struct job job;
static struct image image;
static struct firmware_status status;
static void (*job_done)(const char *failure);
static atomic_t to_confirm;

static void store(struct k_work *work);
static K_WORK_DEFINE(store_work, store);
static void give_up(struct k_work *work);
static K_WORK_DELAYABLE_DEFINE(give_up_work, give_up);

const char *firmware_phase_name(enum firmware_phase phase)
{
	switch (phase) {
	case FIRMWARE_IDLE:
		return "idle";
	case FIRMWARE_ERASING:
		return "erasing";
	case FIRMWARE_WRITING:
		return "writing";
	case FIRMWARE_CHECKING:
		return "checking";
	case FIRMWARE_INSTALLED:
		return "installed, starts at the next reset";
	case FIRMWARE_FAILED:
		return "failed";
	}
	return "";
}

/* --- command thread --------------------------------------------------------------------------- */

static void post(enum job_kind kind)
{
	atomic_set(&job.kind, kind);
	storage_submit(&store_work);
	(void)k_work_reschedule(&give_up_work, K_MSEC(STORAGE_WAIT_MS));
}

static void enter(enum firmware_phase phase, const char *failure)
{
	const unsigned int key = irq_lock();

	status.phase = phase;
	status.failure = failure;
	status.version = image.version;
	irq_unlock(key);
	if (failure != NULL) {
		LOG_ERR("update: %s", failure);
	} else {
		LOG_INF("update: %s", firmware_phase_name(phase));
	}
}

/* Nothing of an update that failed stays in flash. */
static void fail(const char *failure)
{
	const bool has_written = status.phase != FIRMWARE_ERASING;

	enter(FIRMWARE_FAILED, failure);
	if (has_written) {
		post(JOB_CLEAN);
	}
}

/* Storage has done its job: on, in the command thread. */
static int take_done(struct pharos_device *device, void *argument)
{
	const char *const failure = argument;

	if (status.phase == FIRMWARE_FAILED) { /* given up meanwhile */
		post(JOB_CLEAN);
		return 0;
	}
	if (failure != NULL) {
		fail(failure);
	} else if (status.phase == FIRMWARE_ERASING) {
		enter(FIRMWARE_WRITING, NULL);
	} else if (status.phase == FIRMWARE_CHECKING) {
		enter(FIRMWARE_INSTALLED, NULL);
	}
	job_done(failure);
	return 0;
}

/* A flash that never answers keeps storage's thread; whoever sends the image is told. */
static int take_silence(struct pharos_device *device, void *argument)
{
	static const char failure[] = "the flash does not answer";
	const enum job_kind kind = (enum job_kind)atomic_get(&job.kind);

	if (kind != JOB_NONE && kind != JOB_CLEAN && status.phase != FIRMWARE_FAILED) {
		enter(FIRMWARE_FAILED, failure);
		job_done(failure);
	}
	return 0;
}

static void give_up(struct k_work *work)
{
	inbox_call(take_silence, NULL);
}

void firmware_begin(void (*done)(const char *failure))
{
	PHAROS_ASSERT(atomic_get(&job.kind) == JOB_NONE);
	job_done = done;
	image_init(&image, devices_update_slot_size() - CONFIG_PHAROS_FIRMWARE_TRAILER_SIZE);
	status.bytes = 0;
	enter(FIRMWARE_ERASING, NULL);
	post(JOB_ERASE);
}

void firmware_write(const uint8_t *data, size_t size, bool is_last)
{
	enum image_result result = image_write(&image, data, size);

	PHAROS_ASSERT(atomic_get(&job.kind) == JOB_NONE && status.phase == FIRMWARE_WRITING);
	if (result == IMAGE_OK && is_last) {
		result = image_finish(&image);
		enter(FIRMWARE_CHECKING, NULL);
	}
	job.data = data;
	job.size = size;
	job.failure = result == IMAGE_OK ? NULL : image_result_text(result);
	post(is_last ? JOB_WRITE_LAST : JOB_WRITE);
}

void firmware_abort(const char *failure)
{
	PHAROS_ASSERT(atomic_get(&job.kind) == JOB_NONE);
	fail(failure);
}

bool firmware_is_busy(void)
{
	switch (status.phase) {
	case FIRMWARE_ERASING:
	case FIRMWARE_WRITING:
	case FIRMWARE_CHECKING:
		return true;
	case FIRMWARE_IDLE:
	case FIRMWARE_INSTALLED:
	case FIRMWARE_FAILED:
		break;
	}
	return atomic_get(&job.kind) != JOB_NONE;
}

struct firmware_status firmware_status_get(void)
{
	const unsigned int key = irq_lock();
	struct firmware_status copy = status;

	irq_unlock(key);
	copy.confirmed = boot_is_img_confirmed();
	return copy;
}

void firmware_confirm(void)
{
	atomic_set(&to_confirm, 1);
	storage_submit(&store_work);
}

/* --- storage thread --------------------------------------------------------------------------- */

static const char *erase(const struct flash_area *slot)
{
	return flash_area_erase(slot, 0, slot->fa_size) == 0 ? NULL : "the slot cannot be erased";
}

/* Whole blocks as they are, the rest filled up. */
static int write_padded(const struct flash_area *slot, const uint8_t *data, size_t size)
{
	const uint32_t align = flash_area_align(slot);
	const size_t whole = size - size % align;
	uint8_t rest[FLASH_BLOCK_MAX];
	int error = 0;

	__ASSERT_NO_MSG(align <= sizeof(rest));
	if (whole > 0) {
		error = flash_area_write(slot, status.bytes, data, whole);
	}
	if (error == 0 && whole < size) {
		memset(rest, flash_area_erased_val(slot), sizeof(rest));
		memcpy(rest, data + whole, size - whole);
		error = flash_area_write(slot, status.bytes + whole, rest, align);
	}
	return error;
}

static const char *write_block(const struct flash_area *slot)
{
	/* The image itself is wrong: nothing of this block is worth writing. */
	if (job.failure != NULL) {
		return job.failure;
	}
	if (write_padded(slot, job.data, job.size) != 0) {
		return "the slot cannot be written";
	}
	const unsigned int key = irq_lock();

	status.bytes += (uint32_t)job.size;
	irq_unlock(key);
	return NULL;
}

/* What lies in flash is what the image says. Only then may the bootloader know of it. */
static const char *check_and_mark(const struct flash_area *slot)
{
	uint8_t buffer[READ_BACK_SIZE];
	struct sha256 sum;

	sha256_begin(&sum);
	for (uint32_t at = 0; at < image.hashed_size; at += sizeof(buffer)) {
		const size_t size = MIN(sizeof(buffer), image.hashed_size - at);

		if (flash_area_read(slot, at, buffer, size) != 0) {
			return "the slot cannot be read";
		}
		sha256_add(&sum, buffer, size);
	}
	if (memcmp(sha256_end(&sum), image.hash, sizeof(image.hash)) != 0) {
		return "the image does not have its SHA-256";
	}
	return boot_request_upgrade(BOOT_UPGRADE_TEST) == 0 ? NULL : "the image cannot be marked";
}

static const char *run_job(enum job_kind kind)
{
	const struct flash_area *slot;
	const char *failure = NULL;

	if (flash_area_open(devices_update_slot(), &slot) != 0) {
		return "there is no second image slot";
	}
	switch (kind) {
	case JOB_NONE:
		break;
	case JOB_ERASE:
	case JOB_CLEAN:
		failure = erase(slot);
		break;
	case JOB_WRITE:
		failure = write_block(slot);
		break;
	case JOB_WRITE_LAST:
		failure = write_block(slot);
		failure = failure == NULL ? check_and_mark(slot) : failure;
		break;
	}
	flash_area_close(slot);
	return failure;
}

static void store(struct k_work *work)
{
	if (atomic_set(&to_confirm, 0) != 0 && !boot_is_img_confirmed()) {
		const int error = boot_write_img_confirmed();

		if (error != 0) {
			LOG_ERR("cannot confirm the running image: error %d", error);
		} else {
			LOG_INF("the running image is confirmed");
		}
	}
	const enum job_kind kind = (enum job_kind)atomic_get(&job.kind);

	if (kind != JOB_NONE) {
		const char *const failure = run_job(kind);

		atomic_set(&job.kind, JOB_NONE);
		if (kind != JOB_CLEAN) {
			inbox_call(take_done, (void *)(uintptr_t)failure);
		}
	}
}
