/* SPDX-License-Identifier: Apache-2.0 */
#include "core/image.h"

#include "core/assert.h"

#include <string.h>

/* MCUboot: struct image_header, struct image_tlv_info, struct image_tlv; little endian. */
#define MAGIC                0x96F3B83Du
#define MAGIC_AREA           0x6907u
#define MAGIC_AREA_PROTECTED 0x6908u
#define ENTRY_SHA256         0x10u
#define AREA_HEAD_SIZE       4u
#define ENTRY_HEAD_SIZE      4u

#define AT_HEADER_SIZE    8
#define AT_PROTECTED_SIZE 10
#define AT_CODE_SIZE      12
#define AT_VERSION        20

static uint16_t get_u16(const uint8_t *bytes)
{
	return (uint16_t)(bytes[0] | bytes[1] << 8);
}

static uint32_t get_u32(const uint8_t *bytes)
{
	return get_u16(bytes) | (uint32_t)get_u16(bytes + 2) << 16;
}

static void begin(struct image *self, enum image_part part, uint32_t size)
{
	self->part = part;
	self->end = self->offset + size;
	self->field_size = 0;
}

void image_init(struct image *self, uint32_t max_size)
{
	memset(self, 0, sizeof(*self));
	self->max_size = max_size;
	begin(self, IMAGE_PART_HEADER, IMAGE_HEADER_SIZE);
}

static enum image_result take_header(struct image *self)
{
	const uint8_t *const field = self->field;
	const uint32_t header_size = get_u16(field + AT_HEADER_SIZE);
	const uint32_t code_size = get_u32(field + AT_CODE_SIZE);

	if (get_u32(field) != MAGIC || header_size < IMAGE_HEADER_SIZE || code_size == 0) {
		return IMAGE_NOT_AN_IMAGE;
	}
	self->protected_size = get_u16(field + AT_PROTECTED_SIZE);
	if (code_size > self->max_size ||
	    header_size + self->protected_size + AREA_HEAD_SIZE > self->max_size - code_size) {
		return IMAGE_TOO_LARGE;
	}
	self->version = (struct image_version){
		.major = field[AT_VERSION],
		.minor = field[AT_VERSION + 1],
		.revision = get_u16(field + AT_VERSION + 2),
		.build = get_u32(field + AT_VERSION + 4),
	};
	self->hashed_size = header_size + code_size + self->protected_size;
	begin(self, IMAGE_PART_CODE, header_size + code_size - IMAGE_HEADER_SIZE);
	return IMAGE_OK;
}

/* The protected area comes first, where the header says there is one. */
static enum image_result take_area(struct image *self)
{
	const bool is_protected = self->offset - AREA_HEAD_SIZE < self->hashed_size;
	const uint32_t size = get_u16(self->field + 2);

	if (get_u16(self->field) != (is_protected ? MAGIC_AREA_PROTECTED : MAGIC_AREA) ||
	    size < AREA_HEAD_SIZE || (is_protected && size != self->protected_size)) {
		return IMAGE_BAD_TRAILER;
	}
	self->area_end = self->offset - AREA_HEAD_SIZE + size;
	return self->area_end > self->max_size ? IMAGE_TOO_LARGE : IMAGE_OK;
}

/* An entry's value has come whole, or there was none: what is next? */
static enum image_result next_entry(struct image *self)
{
	if (self->offset < self->area_end) {
		begin(self, IMAGE_PART_ENTRY, ENTRY_HEAD_SIZE);
		return self->end > self->area_end ? IMAGE_BAD_TRAILER : IMAGE_OK;
	}
	if (self->area_end == self->hashed_size) {
		begin(self, IMAGE_PART_AREA, AREA_HEAD_SIZE);
	} else {
		begin(self, IMAGE_PART_END, 0);
	}
	return IMAGE_OK;
}

static enum image_result take_entry(struct image *self)
{
	const uint32_t size = get_u16(self->field + 2);

	self->entry_type = get_u16(self->field);
	if (size > self->area_end - self->offset ||
	    (self->entry_type == ENTRY_SHA256 && size != IMAGE_HASH_SIZE)) {
		return IMAGE_BAD_TRAILER;
	}
	begin(self, IMAGE_PART_VALUE, size);
	return IMAGE_OK;
}

static void take_value(struct image *self)
{
	if (self->entry_type == ENTRY_SHA256) {
		memcpy(self->hash, self->field, IMAGE_HASH_SIZE);
		self->has_hash = true;
	}
}

/* The present part is complete. */
static enum image_result advance(struct image *self)
{
	enum image_result result = IMAGE_OK;

	switch (self->part) {
	case IMAGE_PART_HEADER:
		return take_header(self);
	case IMAGE_PART_CODE:
		begin(self, IMAGE_PART_AREA, AREA_HEAD_SIZE);
		return IMAGE_OK;
	case IMAGE_PART_AREA:
		result = take_area(self);
		return result == IMAGE_OK ? next_entry(self) : result;
	case IMAGE_PART_ENTRY:
		return take_entry(self);
	case IMAGE_PART_VALUE:
		take_value(self);
		return next_entry(self);
	case IMAGE_PART_END:
		break;
	}
	PHAROS_ASSERT(false);
	return IMAGE_NOT_AN_IMAGE;
}

/* Keeps what a part says; of the code and of long values nothing is kept. */
static void keep(struct image *self, const uint8_t *data, size_t size)
{
	const size_t room = sizeof(self->field) - self->field_size;
	const size_t count = size < room ? size : room;

	memcpy(self->field + self->field_size, data, count);
	self->field_size = (uint8_t)(self->field_size + count);
}

/* A part may be empty: then the next one begins at once. */
static void advance_parts(struct image *self)
{
	while (self->result == IMAGE_OK && self->part != IMAGE_PART_END &&
	       self->offset == self->end) {
		self->result = advance(self);
	}
}

enum image_result image_write(struct image *self, const uint8_t *data, size_t size)
{
	while (size > 0 && self->result == IMAGE_OK) {
		if (self->part == IMAGE_PART_END) {
			self->result = IMAGE_TRAILING_DATA;
			break;
		}

		const size_t missing = self->end - self->offset;
		const size_t count = size < missing ? size : missing;

		keep(self, data, count);
		self->offset += (uint32_t)count;
		data += count;
		size -= count;
		advance_parts(self);
	}
	return self->result;
}

enum image_result image_finish(struct image *self)
{
	if (self->result == IMAGE_OK && self->part != IMAGE_PART_END) {
		self->result = IMAGE_INCOMPLETE;
	}
	if (self->result == IMAGE_OK && !self->has_hash) {
		self->result = IMAGE_WITHOUT_HASH;
	}
	return self->result;
}

const char *image_result_text(enum image_result result)
{
	switch (result) {
	case IMAGE_OK:
		return "ok";
	case IMAGE_NOT_AN_IMAGE:
		return "not an image of MCUboot's";
	case IMAGE_TOO_LARGE:
		return "too large for the slot";
	case IMAGE_BAD_TRAILER:
		return "malformed after the code";
	case IMAGE_TRAILING_DATA:
		return "data after the end of the image";
	case IMAGE_INCOMPLETE:
		return "ends too early";
	case IMAGE_WITHOUT_HASH:
		return "has no SHA-256";
	}
	PHAROS_ASSERT(false);
	return "";
}
