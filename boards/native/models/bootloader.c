/* SPDX-License-Identifier: Apache-2.0 */
#include "models/bootloader.h"

#include <string.h>

#include <nettle/sha2.h>

const uint8_t bootloader_magic[BOOTLOADER_MAGIC_SIZE] = {
	0x77, 0xC2, 0x95, 0xF3, 0x60, 0xD2, 0xEF, 0x7F,
	0x35, 0x52, 0x50, 0x0F, 0x2C, 0xB6, 0x79, 0x80,
};

/* MCUboot: struct image_header, struct image_tlv_info, struct image_tlv; little endian. */
#define IMAGE_MAGIC    0x96F3B83Du
#define AREA_MAGIC     0x6907u
#define ENTRY_SHA256   0x10u
#define HEADER_SIZE    32u
#define AT_HEADER_SIZE 8
#define AT_PROTECTED   10
#define AT_CODE_SIZE   12

static uint32_t get(const uint8_t *bytes, int count)
{
	uint32_t value = 0;

	for (int i = count - 1; i >= 0; i--) {
		value = value << 8 | bytes[i];
	}
	return value;
}

/* What cannot be read is zeros: neither a magic nor a hash. */
static void read(const struct flash *flash, uint32_t offset, void *data, uint32_t size)
{
	if (flash_read(flash, offset, data, size) != 0) {
		memset(data, 0, size);
	}
}

static void hash(const struct flash *flash, uint32_t offset, uint32_t size,
                 uint8_t digest[SHA256_DIGEST_SIZE])
{
	struct sha256_ctx context;
	uint8_t chunk[256];

	sha256_init(&context);
	for (uint32_t done = 0; done < size;) {
		const uint32_t count = size - done < sizeof(chunk) ? size - done : sizeof(chunk);

		read(flash, offset + done, chunk, count);
		sha256_update(&context, count, chunk);
		done += count;
	}
	sha256_digest(&context, SHA256_DIGEST_SIZE, digest);
}

/* Is there an entry with the hash of everything before the area? */
static bool hash_is_right(const struct flash *flash, uint32_t slot, uint32_t hashed, uint32_t size)
{
	uint8_t head[4];
	uint8_t wanted[SHA256_DIGEST_SIZE];
	uint8_t found[SHA256_DIGEST_SIZE];
	uint32_t at = hashed;

	read(flash, slot + at, head, sizeof(head));

	const uint32_t end = hashed + get(head + 2, 2);

	if (get(head, 2) != AREA_MAGIC || end > size) {
		return false;
	}
	for (at += sizeof(head); at + sizeof(head) <= end; at += sizeof(head) + get(head + 2, 2)) {
		read(flash, slot + at, head, sizeof(head));
		if (get(head, 2) == ENTRY_SHA256 && get(head + 2, 2) == sizeof(wanted) &&
		    at + sizeof(head) + sizeof(wanted) <= end) {
			read(flash, slot + at + sizeof(head), wanted, sizeof(wanted));
			hash(flash, slot, hashed, found);
			return memcmp(wanted, found, sizeof(found)) == 0;
		}
	}
	return false;
}

static bool image_is_whole(const struct flash *flash, uint32_t slot, uint32_t size)
{
	uint8_t header[HEADER_SIZE];

	read(flash, slot, header, sizeof(header));

	const uint64_t hashed = (uint64_t)get(header + AT_HEADER_SIZE, 2) +
	                        get(header + AT_PROTECTED, 2) + get(header + AT_CODE_SIZE, 4);

	return get(header, 4) == IMAGE_MAGIC && hashed + sizeof(uint32_t) <= size &&
	       hash_is_right(flash, slot, (uint32_t)hashed, size);
}

static bool has_magic(const struct flash *flash, uint32_t slot, uint32_t size)
{
	uint8_t magic[BOOTLOADER_MAGIC_SIZE];

	read(flash, slot + size - BOOTLOADER_AT_MAGIC, magic, sizeof(magic));
	return memcmp(magic, bootloader_magic, sizeof(magic)) == 0;
}

static bool has_flag(const struct flash *flash, uint32_t at)
{
	uint8_t flag;

	read(flash, at, &flag, 1);
	return flag == BOOTLOADER_FLAG_SET;
}

static void set_flag(struct flash *flash, uint32_t at)
{
	uint8_t block[FLASH_BLOCK_SIZE];

	memset(block, 0xFF, sizeof(block));
	block[0] = BOOTLOADER_FLAG_SET;
	(void)flash_write(flash, at, block, sizeof(block));
}

/* Everything but the last page, which holds the trailer and is erased in both. */
static void swap(struct flash *flash, const struct bootloader_slots *slots)
{
	static uint8_t first[FLASH_PAGE_SIZE];
	static uint8_t second[FLASH_PAGE_SIZE];

	for (uint32_t at = 0; at < slots->size; at += FLASH_PAGE_SIZE) {
		read(flash, slots->first + at, first, sizeof(first));
		read(flash, slots->second + at, second, sizeof(second));
		(void)flash_erase(flash, slots->first + at, FLASH_PAGE_SIZE);
		(void)flash_erase(flash, slots->second + at, FLASH_PAGE_SIZE);
		if (at + FLASH_PAGE_SIZE < slots->size) {
			(void)flash_write(flash, slots->first + at, second, sizeof(second));
			(void)flash_write(flash, slots->second + at, first, sizeof(first));
		}
	}
}

/* The first slot's trailer after a swap. */
static void write_trailer(struct flash *flash, const struct bootloader_slots *slots, bool image_ok)
{
	const uint32_t end = slots->first + slots->size;

	set_flag(flash, end - BOOTLOADER_AT_COPY_DONE);
	if (image_ok) {
		set_flag(flash, end - BOOTLOADER_AT_IMAGE_OK);
	}
	(void)flash_write(flash, end - BOOTLOADER_AT_MAGIC, bootloader_magic,
	                  sizeof(bootloader_magic));
}

enum bootloader_outcome bootloader_run(struct flash *flash, const struct bootloader_slots *slots)
{
	const uint32_t end = slots->first + slots->size;
	const uint32_t second_end = slots->second + slots->size;

	if (has_magic(flash, slots->second, slots->size)) {
		const bool permanent = has_flag(flash, second_end - BOOTLOADER_AT_IMAGE_OK);

		if (!image_is_whole(flash, slots->second, slots->size)) {
			(void)flash_erase(flash, second_end - FLASH_PAGE_SIZE, FLASH_PAGE_SIZE);
			return BOOTLOADER_REFUSED;
		}
		swap(flash, slots);
		write_trailer(flash, slots, permanent);
		return BOOTLOADER_SWAPPED;
	}
	if (has_magic(flash, slots->first, slots->size) &&
	    has_flag(flash, end - BOOTLOADER_AT_COPY_DONE) &&
	    !has_flag(flash, end - BOOTLOADER_AT_IMAGE_OK)) {
		swap(flash, slots);
		write_trailer(flash, slots, true);
		return BOOTLOADER_REVERTED;
	}
	return BOOTLOADER_NOTHING;
}
