/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What MCUboot does before the firmware starts: swaps the slots when the second one is marked and
 * its image is whole, and swaps back when the firmware that then ran never confirmed itself.
 *
 * A slot's last bytes are its trailer: …, copy done, image ok, magic; each flag in a block of its
 * own. Spec: MCUboot design, "Image trailer", "Image swapping". No host and no Zephyr headers.
 */
#ifndef NATIVE_MODELS_BOOTLOADER_H_
#define NATIVE_MODELS_BOOTLOADER_H_

#include <stdbool.h>
#include <stdint.h>

#include "models/flash.h"

#define BOOTLOADER_MAGIC_SIZE   16u
#define BOOTLOADER_FLAG_SET     1u
#define BOOTLOADER_TRAILER_SIZE (BOOTLOADER_MAGIC_SIZE + 2u * FLASH_BLOCK_SIZE)

/* From the end of a slot. */
#define BOOTLOADER_AT_MAGIC     BOOTLOADER_MAGIC_SIZE
#define BOOTLOADER_AT_IMAGE_OK  (BOOTLOADER_AT_MAGIC + FLASH_BLOCK_SIZE)
#define BOOTLOADER_AT_COPY_DONE (BOOTLOADER_AT_IMAGE_OK + FLASH_BLOCK_SIZE)

extern const uint8_t bootloader_magic[BOOTLOADER_MAGIC_SIZE];

enum bootloader_outcome {
	BOOTLOADER_NOTHING,
	BOOTLOADER_SWAPPED,
	BOOTLOADER_REVERTED,
	BOOTLOADER_REFUSED, /* marked, but the image is not whole; the mark is gone */
};

/* The two slots have one size, whole pages. */
struct bootloader_slots {
	uint32_t first;
	uint32_t second;
	uint32_t size;
};

enum bootloader_outcome bootloader_run(struct flash *flash, const struct bootloader_slots *slots);

#endif
