/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A new firmware image: into the second slot, checked, and only then marked for the bootloader,
 * which starts it for a test. An image that then runs well confirms itself; one that does not is
 * taken back by the bootloader at the next reset.
 *
 * Writing flash is slow, so it happens in the storage thread, a block at a time. The command thread
 * hands out the blocks and is called back, in itself, when one is done.
 */
#ifndef PHAROS_THREADS_FIRMWARE_H
#define PHAROS_THREADS_FIRMWARE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/image.h"

enum firmware_phase {
	FIRMWARE_IDLE,
	FIRMWARE_ERASING,
	FIRMWARE_WRITING,
	FIRMWARE_CHECKING,
	FIRMWARE_INSTALLED, /* starts at the next reset */
	FIRMWARE_FAILED,
};

/* failure: of FIRMWARE_FAILED, constant; else NULL. bytes: written so far. */
struct firmware_status {
	enum firmware_phase phase;
	const char *failure;
	uint32_t bytes;
	struct image_version version; /* from WRITING on */
	bool confirmed;               /* the running image */
};

/* For people, constant and never NULL: "idle", "erasing", … */
const char *firmware_phase_name(enum firmware_phase phase);

#ifdef CONFIG_PHAROS_FIRMWARE_UPDATE

/* Why this build has no update; NULL: it has. */
static inline const char *firmware_unavailable(void)
{
	return NULL;
}

/*
 * Command thread. Each returns at once, and done() follows in the command thread when the flash has
 * done it: NULL, or why the update has failed. Begin: the flash is at rest, asserted; an update
 * that was under way is given up. Write: data holds until done(), size 0…256 and whole blocks of
 * the flash but for the last.
 */
void firmware_begin(void (*done)(const char *failure));
void firmware_write(const uint8_t *data, size_t size, bool is_last);

/*
 * The source has failed. The flash is at rest, asserted. failure: constant. Command thread. As
 * after every failure, what was written is then erased, during which it is busy.
 */
void firmware_abort(const char *failure);

/* An update is under way, or what is left of one is being erased: none may begin. Command thread.
 */
bool firmware_is_busy(void);

/* Any thread. */
struct firmware_status firmware_status_get(void);

/* The system runs well: the running image is the right one. Any thread. */
void firmware_confirm(void);

#else

static inline const char *firmware_unavailable(void)
{
	return "this build has no second image slot";
}

static inline void firmware_begin(void (*done)(const char *failure))
{
}

static inline void firmware_write(const uint8_t *data, size_t size, bool is_last)
{
}

static inline void firmware_abort(const char *failure)
{
}

static inline bool firmware_is_busy(void)
{
	return false;
}

#endif

#endif
