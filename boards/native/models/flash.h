/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The MCU's program flash: erased by the page to ones, programmed by the block, and only where it
 * is erased (a block has one checksum, so it cannot be programmed twice).
 *
 * Power can be made to fail after some more bytes: what was programmed until then is there, but for
 * a block that was only begun, which cannot be read until its page is erased (its checksum is
 * wrong); a page that was being erased is half erased; and nothing works until flash_power_up().
 *
 * The bytes are kept inverted, so that memory which is all zeros is erased flash.
 * No host and no Zephyr headers.
 */
#ifndef NATIVE_MODELS_FLASH_H_
#define NATIVE_MODELS_FLASH_H_

#include <stdbool.h>
#include <stdint.h>

#define FLASH_PAGE_SIZE  2048u /* as an STM32G474's in dual-bank mode */
#define FLASH_BLOCK_SIZE 8u

struct flash {
	uint8_t *inverted; /* size bytes */
	uint32_t size;     /* whole pages */
	bool is_armed;     /* power fails after bytes_left more */
	bool is_dead;
	uint64_t bytes_left;
	uint32_t torn; /* the block that cannot be read, counted from 1; 0: none */
};

/* 0, -EINVAL: not whole blocks (write) or pages (erase), or outside; -EIO: not erased, not
 * readable, no power. */
int flash_read(const struct flash *self, uint32_t offset, void *data, uint32_t size);
int flash_write(struct flash *self, uint32_t offset, const void *data, uint32_t size);
int flash_erase(struct flash *self, uint32_t offset, uint32_t size);

/* Power fails after this many more bytes; a page counts as its size. */
void flash_tear(struct flash *self, uint64_t bytes);
void flash_power_up(struct flash *self);

#endif
