/* SPDX-License-Identifier: Apache-2.0 */
#include "torn_flash.h"

#include <errno.h>
#include <string.h>

struct torn_flash torn_flash;

static uint64_t chance;

void chance_seed(uint64_t seed)
{
	chance = seed;
}

uint64_t draw(uint64_t below) /* splitmix64 */
{
	uint64_t z = chance += 0x9E3779B97F4A7C15u;

	z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
	z = (z ^ z >> 27) * 0x94D049BB133111EBu;
	return (z ^ z >> 31) % below;
}

static int length_of(void)
{
	return (int)torn_flash.content.length;
}

static int read(size_t offset, void *buffer, size_t length)
{
	const struct torn_content *const content = &torn_flash.content;

	if (content->lost_size > 0 && offset < content->lost_at + content->lost_size &&
	    content->lost_at < offset + length) {
		memset(buffer, 0xEE, length);
		return -EIO;
	}
	memcpy(buffer, &content->bytes[offset], length);
	return 0;
}

/* How many of these bytes get through. */
static size_t pass(size_t length)
{
	const size_t through = length < torn_flash.bytes_left ? length : torn_flash.bytes_left;

	torn_flash.bytes_left = through < length ? 0 : torn_flash.bytes_left - through;
	torn_flash.programmed += through;
	return through;
}

/* The word that was only begun. */
static void tear_word(size_t at)
{
	struct torn_content *const content = &torn_flash.content;

	if (torn_flash.torn == TORN_AS_IT_CAME) {
		return;
	}
	for (size_t i = at; i < at + torn_flash.word; i++) {
		content->bytes[i] = torn_flash.torn == TORN_ERASED ? 0xFF : (uint8_t)draw(256);
	}
	content->length = at + torn_flash.word;
	if (torn_flash.torn == TORN_UNREADABLE) {
		content->lost_at = at;
		content->lost_size = torn_flash.word;
	}
}

static int append(const void *data, size_t length)
{
	struct torn_content *const content = &torn_flash.content;
	const size_t through = pass(length);
	const size_t at = content->length;

	memcpy(&content->bytes[at], data, through);
	content->length += through;
	if (through < length && through % torn_flash.word != 0) {
		tear_word(at + through - through % torn_flash.word);
	}
	return through == length ? 0 : -EIO;
}

/* All at once; that is the one byte more. */
static int replace(const void *data, size_t length)
{
	if (pass(length) != length || pass(1) != 1) {
		return -EIO;
	}
	memcpy(torn_flash.content.bytes, data, length);
	torn_flash.content.length = length;
	torn_flash.content.lost_size = 0;
	return 0;
}

const struct settings_medium torn_flash_medium = {
	.length = length_of,
	.read = read,
	.append = append,
	.replace = replace,
};

/* A place: the length in two bytes, the value. */
bool torn_flash_put(uint8_t place, const uint8_t *value, size_t length)
{
	struct torn_content *const content = &torn_flash.content;
	uint8_t *const at = &content->bytes[place * TORN_PLACE_SIZE];
	const uint8_t head[2] = {(uint8_t)length, (uint8_t)(length >> 8)};
	const bool was_lost_here = content->lost_at / TORN_PLACE_SIZE == place;
	const size_t through = pass(length + sizeof(head));

	content->lost_size = was_lost_here ? 0 : content->lost_size;
	if (draw(2) == 0) {
		memset(at, 0xFF, TORN_PLACE_SIZE); /* erased before */
	}
	memcpy(at, head, through < sizeof(head) ? through : sizeof(head));
	if (through > sizeof(head)) {
		memcpy(at + sizeof(head), value, through - sizeof(head));
	}
	content->length = sizeof(content->bytes);
	if (through < length + sizeof(head) && through % torn_flash.word != 0) {
		tear_word(place * TORN_PLACE_SIZE + through - through % torn_flash.word);
	}
	content->length = sizeof(content->bytes);
	return through == length + sizeof(head);
}

const uint8_t *torn_flash_place(uint8_t place, size_t *length)
{
	const struct torn_content *const content = &torn_flash.content;
	const uint8_t *const at = &content->bytes[place * TORN_PLACE_SIZE];
	const size_t told = (size_t)(at[0] | at[1] << 8);

	*length = told <= TORN_PLACE_SIZE - 2 ? told : TORN_PLACE_SIZE - 2;
	if (content->lost_size > 0 && content->lost_at / TORN_PLACE_SIZE == place) {
		*length = 0;
	}
	return at + 2;
}
