/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A medium for the native settings: a flash of words, whose power can be cut after so many bytes.
 * The word that was only begun is then as `torn` says. And the chance that the simulation draws
 * from, seeded.
 */
#ifndef TORN_FLASH_H
#define TORN_FLASH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "subsys/settings/settings_records.h"

enum torn {
	TORN_AS_IT_CAME,
	TORN_ERASED,
	TORN_GARBAGE,
	TORN_UNREADABLE,
	TORN_COUNT
};

/* Two places for a value each, at the beginning of the content. */
#define TORN_PLACE_SIZE (SETTINGS_RECORDS_SIZE / 2)

struct torn_content {
	uint8_t bytes[SETTINGS_RECORDS_SIZE];
	size_t length;
	size_t lost_at; /* a word that cannot be read */
	size_t lost_size;
};

struct torn_flash {
	struct torn_content content;
	size_t word; /* 4, 8, 32 bytes */
	enum torn torn;
	size_t bytes_left; /* until the cut */
	size_t programmed; /* bytes */
};

extern struct torn_flash torn_flash;
extern const struct settings_medium torn_flash_medium;

/* Writes the place from its first byte; false: power was cut. And what can be read of it: length 0:
 * nothing, as when a word of it cannot. */
bool torn_flash_put(uint8_t place, const uint8_t *value, size_t length);
const uint8_t *torn_flash_place(uint8_t place, size_t *length);

void chance_seed(uint64_t seed);

/* One of 0…below - 1. */
uint64_t draw(uint64_t below);

#endif
