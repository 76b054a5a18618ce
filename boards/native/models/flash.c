/* SPDX-License-Identifier: Apache-2.0 */
#include "models/flash.h"

#include <errno.h>
#include <string.h>

static bool is_inside(const struct flash *self, uint32_t offset, uint32_t size)
{
	return offset <= self->size && size <= self->size - offset;
}

/* How many of these bytes get through before power fails. */
static uint32_t allowed(struct flash *self, uint32_t size)
{
	if (self->is_dead) {
		return 0;
	}
	if (self->is_armed && size > self->bytes_left) {
		self->is_dead = true;
		size = (uint32_t)self->bytes_left;
	}
	if (self->is_armed) {
		self->bytes_left -= size;
	}
	return size;
}

/* Is the block that cannot be read among these bytes? */
static bool has_torn(const struct flash *self, uint32_t offset, uint32_t size)
{
	const uint32_t at = (self->torn - 1) * FLASH_BLOCK_SIZE;

	return self->torn != 0 && size > 0 && at < offset + size && offset < at + FLASH_BLOCK_SIZE;
}

int flash_read(const struct flash *self, uint32_t offset, void *data, uint32_t size)
{
	uint8_t *const bytes = data;

	if (!is_inside(self, offset, size)) {
		return -EINVAL;
	}
	if (self->is_dead || has_torn(self, offset, size)) {
		return -EIO;
	}
	for (uint32_t i = 0; i < size; i++) {
		bytes[i] = (uint8_t)~self->inverted[offset + i];
	}
	return 0;
}

static bool is_erased(const struct flash *self, uint32_t offset, uint32_t size)
{
	for (uint32_t i = 0; i < size; i++) {
		if (self->inverted[offset + i] != 0) {
			return false;
		}
	}
	return true;
}

int flash_write(struct flash *self, uint32_t offset, const void *data, uint32_t size)
{
	const uint8_t *const bytes = data;

	if (!is_inside(self, offset, size) || offset % FLASH_BLOCK_SIZE != 0 ||
	    size % FLASH_BLOCK_SIZE != 0) {
		return -EINVAL;
	}
	if (!is_erased(self, offset, size) || has_torn(self, offset, size)) {
		return -EIO;
	}
	const uint32_t through = allowed(self, size);

	for (uint32_t i = 0; i < through; i++) {
		self->inverted[offset + i] = (uint8_t)~bytes[i];
	}
	if (through % FLASH_BLOCK_SIZE != 0) {
		self->torn = (offset + through) / FLASH_BLOCK_SIZE + 1;
	}
	return through == size ? 0 : -EIO;
}

int flash_erase(struct flash *self, uint32_t offset, uint32_t size)
{
	if (!is_inside(self, offset, size) || offset % FLASH_PAGE_SIZE != 0 ||
	    size % FLASH_PAGE_SIZE != 0) {
		return -EINVAL;
	}
	for (uint32_t page = offset; page < offset + size; page += FLASH_PAGE_SIZE) {
		const uint32_t through = allowed(self, FLASH_PAGE_SIZE);

		if (through == FLASH_PAGE_SIZE && has_torn(self, page, FLASH_PAGE_SIZE)) {
			self->torn = 0;
		}

		/* A page loses its charge evenly; for its reader it is a page of which part is
		 * gone. */
		memset(&self->inverted[page], 0, through);
		if (through < FLASH_PAGE_SIZE) {
			return -EIO;
		}
	}
	return 0;
}

void flash_tear(struct flash *self, uint64_t bytes)
{
	self->bytes_left = bytes;
	self->is_armed = true;
	self->is_dead = false;
}

void flash_power_up(struct flash *self)
{
	self->is_armed = false;
	self->is_dead = false;
}
