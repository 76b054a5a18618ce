/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Settings as a log of records. Pure: no kernel, no host, no allocation.
 *
 * The content of a medium, integers little-endian:
 *
 *	head     "PHAROS settings 1\n"
 *	record   magic 0x53A7 (2) | name length (1) | zero (1) | value length (2) |
 *	         CRC-16/CCITT-FALSE of the six bytes before (2) |
 *	         CRC-32/ISO-HDLC of the eight bytes before, name and value (4) | name | value
 *
 * Head and records are filled up with zeros to whole words (settings_medium.h), so that a cut
 *spoils no record but the one being written; content without that, of an earlier version, is read
 *as well.
 *
 * The last record of a name counts; value length 0 means deleted. A record is appended, and never
 * changed. When half of the content is of no use any more, or something is broken, the next write
 * replaces the content by the live records.
 *
 * A broken record is left out; the records after it are found by its own length if that is sound,
 *else by searching for the next sound record.
 *
 * When nothing is sound, either the first write ever was cut short, and nothing is lost; or there
 * is more than that can leave, and what was stored is.
 */
#ifndef SETTINGS_RECORDS_H
#define SETTINGS_RECORDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "settings_medium.h"

#ifndef SETTINGS_RECORDS_SIZE
#define SETTINGS_RECORDS_SIZE CONFIG_SETTINGS_STORAGE_SIZE
#endif
#define SETTINGS_RECORD_HEADER_SIZE  12
#define SETTINGS_RECORD_NAME_MAX     72
/* Zephyr's flash stores take what fits a sector. */
#define SETTINGS_RECORD_VALUE_MAX    512
/* Below this size the content is not compacted. */
#define SETTINGS_RECORDS_COMPACT_MIN 512

struct settings_records_stats {
	uint32_t broken;      /* runs of broken or unreadable bytes found at opening */
	uint32_t writes;      /* records that were stored */
	uint32_t compactions; /* contents that were replaced */
	uint32_t errors;      /* writes that the medium refused */
};

struct settings_records {
	const struct settings_medium *medium; /* NULL: not open */
	struct settings_records_stats stats;
	bool lost;    /* there was something, and none of it is sound */
	bool rewrite; /* the medium's content is not what `image` is: replace it */
	size_t live;  /* bytes of `image` that count, its head included */
	size_t length;
	uint8_t image[SETTINGS_RECORDS_SIZE]; /* head and sound records */
	uint8_t scratch[SETTINGS_RECORDS_SIZE];
};

/* A view into the image; good until the next save. */
struct settings_record {
	const char *name; /* not terminated */
	const uint8_t *value;
	size_t name_length;
	size_t value_length;
};

/* 0, or -errno: -EBADMSG: the content is not empty, and nothing in it is ours; -EFBIG: too long. */
int settings_records_open(struct settings_records *self, const struct settings_medium *medium);

/* Visits the live records: start with *cursor 0. False: no more. */
bool settings_records_next(const struct settings_records *self, size_t *cursor,
                           struct settings_record *record);

bool settings_records_find(const struct settings_records *self, const char *name,
                           struct settings_record *record);

/* value_length 0 deletes. 0, -EINVAL, -ENOSPC, -ENODEV (not open), or the medium's error; then the
 * old value stays.
 */
int settings_records_save(struct settings_records *self, const char *name, const void *value,
                          size_t value_length);

#endif
