/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The firmware image that MCUboot starts, checked while it arrives; sans-IO.
 *
 * The bytes come in order. The header must be one of MCUboot's and the image must fit its slot, so
 * a wrong file is refused with its first 32 bytes. What follows the code names the SHA-256 of
 * everything before it; whether the hash is right is for the caller, who can read the whole slot.
 *
 * Context: the thread that owns it. Spec: MCUboot design, "Image format".
 */
#ifndef PHAROS_CORE_IMAGE_H
#define PHAROS_CORE_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define IMAGE_HEADER_SIZE 32u
#define IMAGE_HASH_SIZE   32u

enum image_result {
	IMAGE_OK,            /* so far */
	IMAGE_NOT_AN_IMAGE,  /* another magic number, an impossible header */
	IMAGE_TOO_LARGE,     /* for its slot */
	IMAGE_BAD_TRAILER,   /* what follows the code is not MCUboot's */
	IMAGE_TRAILING_DATA, /* more bytes than the image has */
	IMAGE_INCOMPLETE,    /* the bytes ended too early */
	IMAGE_WITHOUT_HASH,
};

struct image_version {
	uint8_t major;
	uint8_t minor;
	uint16_t revision;
	uint32_t build;
};

enum image_part {
	IMAGE_PART_HEADER,
	IMAGE_PART_CODE,
	IMAGE_PART_AREA,  /* the head of a trailer area */
	IMAGE_PART_ENTRY, /* the head of an entry there */
	IMAGE_PART_VALUE,
	IMAGE_PART_END,
};

/* Readable by the owner; only the functions below write. */
struct image {
	uint32_t max_size;
	uint32_t offset; /* bytes taken */
	uint32_t end;    /* where the present part ends */
	uint32_t area_end;
	uint32_t hashed_size; /* the hash covers this many bytes from the beginning */
	uint32_t protected_size;
	struct image_version version;
	enum image_part part;
	enum image_result result;
	uint16_t entry_type;
	bool has_hash;
	uint8_t field_size; /* bytes of `field` that are there */
	uint8_t field[IMAGE_HEADER_SIZE];
	uint8_t hash[IMAGE_HASH_SIZE];
};

/* max_size: of an image in the slot, bytes. */
void image_init(struct image *self, uint32_t max_size);

/* The next bytes. Once it is not IMAGE_OK it stays so. */
enum image_result image_write(struct image *self, const uint8_t *data, size_t size);

/* There are no more bytes. IMAGE_OK: whole, hash and hashed_size are set. */
enum image_result image_finish(struct image *self);

/* For people, constant and never NULL: "ok", "not an image of MCUboot's", … */
const char *image_result_text(enum image_result result);

#endif
