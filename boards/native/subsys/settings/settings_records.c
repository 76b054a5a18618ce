/* SPDX-License-Identifier: Apache-2.0 */
#include "settings_records.h"

#include <errno.h>
#include <string.h>

#define MAGIC 0x53A7u

#define MARK "PHAROS settings 1\n"

enum {
	MARK_SIZE = sizeof(MARK) - 1,
	HEAD_SIZE = (MARK_SIZE + SETTINGS_WORD - 1) / SETTINGS_WORD * SETTINGS_WORD,
	HEADER_SIZE = SETTINGS_RECORD_HEADER_SIZE,
	RECORD_MAX = (HEADER_SIZE + SETTINGS_RECORD_NAME_MAX + SETTINGS_RECORD_VALUE_MAX +
	              SETTINGS_WORD - 1) /
	             SETTINGS_WORD * SETTINGS_WORD,
};

static const char head[HEAD_SIZE] = MARK;

_Static_assert(SETTINGS_RECORDS_SIZE >= HEAD_SIZE + RECORD_MAX, "the longest record fits");

static uint16_t crc16(const uint8_t *data, size_t length)
{
	uint16_t crc = 0xFFFF;

	for (size_t i = 0; i < length; i++) {
		crc ^= (uint16_t)(data[i] << 8);
		for (int bit = 0; bit < 8; bit++) {
			crc = (uint16_t)((crc & 0x8000) != 0 ? (crc << 1) ^ 0x1021 : crc << 1);
		}
	}
	return crc;
}

static uint32_t crc32(uint32_t crc, const uint8_t *data, size_t length)
{
	crc = ~crc;
	for (size_t i = 0; i < length; i++) {
		crc ^= data[i];
		for (int bit = 0; bit < 8; bit++) {
			crc = (crc & 1) != 0 ? (crc >> 1) ^ 0xEDB88320u : crc >> 1;
		}
	}
	return ~crc;
}

static void put16(uint8_t *out, uint16_t value)
{
	out[0] = (uint8_t)value;
	out[1] = (uint8_t)(value >> 8);
}

static void put32(uint8_t *out, uint32_t value)
{
	put16(out, (uint16_t)value);
	put16(&out[2], (uint16_t)(value >> 16));
}

static uint16_t get16(const uint8_t *in)
{
	return (uint16_t)(in[0] | in[1] << 8);
}

static uint32_t get32(const uint8_t *in)
{
	return get16(in) | (uint32_t)get16(&in[2]) << 16;
}

/* The two checks: first the header's own eight bytes, then all of the record. */
static uint32_t record_crc(const uint8_t *at, size_t body)
{
	return crc32(crc32(0, at, 8), &at[HEADER_SIZE], body);
}

/* Of a record in whole words. */
static size_t padded(size_t length)
{
	return (length + SETTINGS_WORD - 1) / SETTINGS_WORD * SETTINGS_WORD;
}

/* Length of the record whose header is at `at`, or 0: no sound header. */
static size_t header_length(const uint8_t *at, size_t left)
{
	if (left < HEADER_SIZE || get16(at) != MAGIC || at[3] != 0 ||
	    get16(&at[6]) != crc16(at, 6) || at[2] == 0 || at[2] > SETTINGS_RECORD_NAME_MAX ||
	    get16(&at[4]) > SETTINGS_RECORD_VALUE_MAX) {
		return 0;
	}
	return (size_t)HEADER_SIZE + at[2] + get16(&at[4]);
}

static bool is_sound(const uint8_t *at, size_t left)
{
	const size_t length = header_length(at, left);

	return length != 0 && length <= left &&
	       get32(&at[8]) == record_crc(at, length - HEADER_SIZE);
}

/* Returns the bytes that it takes. */
static size_t view(const uint8_t *at, struct settings_record *record)
{
	record->name_length = at[2];
	record->value_length = get16(&at[4]);
	record->name = (const char *)&at[HEADER_SIZE];
	record->value = &at[HEADER_SIZE + record->name_length];
	return padded(HEADER_SIZE + record->name_length + record->value_length);
}

static size_t build(uint8_t *out, const char *name, const void *value, size_t value_length)
{
	const size_t name_length = strlen(name);

	put16(out, MAGIC);
	out[2] = (uint8_t)name_length;
	out[3] = 0;
	put16(&out[4], (uint16_t)value_length);
	put16(&out[6], crc16(out, 6));
	memcpy(&out[HEADER_SIZE], name, name_length);
	if (value_length > 0) {
		memcpy(&out[HEADER_SIZE + name_length], value, value_length);
	}
	put32(&out[8], record_crc(out, name_length + value_length));

	const size_t length = HEADER_SIZE + name_length + value_length;

	memset(&out[length], 0, padded(length) - length);
	return padded(length);
}

static bool same_name(const struct settings_record *a, const struct settings_record *b)
{
	return a->name_length == b->name_length && memcmp(a->name, b->name, a->name_length) == 0;
}

static bool is_superseded(const struct settings_records *self, size_t next,
                          const struct settings_record *record)
{
	struct settings_record later;

	while (next < self->length) {
		next += view(&self->image[next], &later);
		if (same_name(&later, record)) {
			return true;
		}
	}
	return false;
}

bool settings_records_next(const struct settings_records *self, size_t *cursor,
                           struct settings_record *record)
{
	if (*cursor == 0) {
		*cursor = HEAD_SIZE;
	}
	while (*cursor < self->length) {
		*cursor += view(&self->image[*cursor], record);
		if (record->value_length > 0 && !is_superseded(self, *cursor, record)) {
			return true;
		}
	}
	return false;
}

bool settings_records_find(const struct settings_records *self, const char *name,
                           struct settings_record *record)
{
	const struct settings_record wanted = {.name = name, .name_length = strlen(name)};
	struct settings_record each;
	size_t cursor = HEAD_SIZE;
	bool found = false;

	while (cursor < self->length) {
		cursor += view(&self->image[cursor], &each);
		if (same_name(&each, &wanted)) {
			*record = each;
			found = true;
		}
	}
	return found && record->value_length > 0;
}

/* Where the next record begins: behind zeros up to a whole word. */
static size_t skip_padding(const struct settings_records *self, size_t at, size_t length)
{
	while (at < length && at % SETTINGS_WORD != 0 && self->image[at] == 0) {
		at++;
	}
	return at;
}

/* Copies the sound record at `at` of so many bytes, filled up; false: there is no room. */
static bool keep(struct settings_records *self, size_t at, size_t record)
{
	const size_t size = padded(record);

	if (size > sizeof(self->scratch) - self->length) {
		return false;
	}
	memset(&self->scratch[self->length], 0, size);
	memcpy(&self->scratch[self->length], &self->image[at], record);
	self->length += size;
	return true;
}

/* Keeps the sound records of image[0…length) and counts the runs of other bytes. */
static void keep_sound(struct settings_records *self, size_t length, size_t from)
{
	size_t at = skip_padding(self, from, length);
	bool in_run = false;

	memcpy(self->scratch, head, HEAD_SIZE);
	self->length = HEAD_SIZE;
	while (at < length) {
		const size_t left = length - at;
		const size_t record = header_length(&self->image[at], left);

		if (is_sound(&self->image[at], left) && keep(self, at, record)) {
			self->rewrite = self->rewrite || at % SETTINGS_WORD != 0;
			at = skip_padding(self, at + record, length);
			in_run = false;
			continue;
		}
		if (!in_run || record != 0) {
			self->stats.broken++;
		}
		in_run = true;
		at += record != 0 && record <= left ? record : 1;
	}
	memcpy(self->image, self->scratch, self->length);
}

/* The medium's content into the image; zeros where it cannot be read. The length, or -errno. */
static int read_content(struct settings_records *self, const struct settings_medium *medium)
{
	const int length = medium->length();
	int rc;

	/* The head takes room even where the medium has lost it. */
	if (length > (int)(sizeof(self->image) - HEAD_SIZE)) {
		return -EFBIG;
	}
	if (length <= 0) {
		return length;
	}
	rc = medium->read(0, self->image, (size_t)length);
	for (size_t at = 0; rc == -EIO && at < (size_t)length; at += SETTINGS_WORD) {
		const size_t left = (size_t)length - at;
		const size_t size = left < SETTINGS_WORD ? left : SETTINGS_WORD;

		if (medium->read(at, &self->image[at], size) != 0) {
			memset(&self->image[at], 0, size);
		}
	}
	self->rewrite = rc == -EIO || length % (int)SETTINGS_WORD != 0;
	return rc == 0 || rc == -EIO ? length : rc;
}

static void count_live(struct settings_records *self)
{
	struct settings_record record;
	size_t cursor = 0;

	self->live = HEAD_SIZE;
	while (settings_records_next(self, &cursor, &record)) {
		self->live += padded(HEADER_SIZE + record.name_length + record.value_length);
	}
}

/* Whether so much is there as a first record that was cut short cannot leave. Of one that is there
 * to its end, the last word can be the one that was cut, if it cannot be read. */
static bool is_more_than_begun(const struct settings_records *self, size_t length, size_t from)
{
	const size_t at = skip_padding(self, from, length);
	const size_t first = header_length(&self->image[at], length - at);

	const size_t most = at + (first != 0 ? padded(first) : SETTINGS_WORD);
	const bool has_unreadable_word = self->rewrite;

	return length > most || (length == most && first != 0 && !has_unreadable_word);
}

int settings_records_open(struct settings_records *self, const struct settings_medium *medium)
{
	bool has_mark;
	int length;

	self->medium = NULL;
	self->rewrite = false;
	self->lost = false;
	memset(&self->stats, 0, sizeof(self->stats));
	length = read_content(self, medium);
	if (length < 0) {
		return length;
	}
	has_mark = length >= MARK_SIZE && memcmp(self->image, MARK, MARK_SIZE) == 0;
	self->lost = is_more_than_begun(self, (size_t)length, has_mark ? MARK_SIZE : 0);
	keep_sound(self, (size_t)length, has_mark ? MARK_SIZE : 0);
	self->lost = self->lost && self->length == HEAD_SIZE;
	if (length > 0 && !has_mark && self->length == HEAD_SIZE) {
		return -EBADMSG;
	}
	self->rewrite = self->rewrite || !has_mark || self->stats.broken > 0;
	self->medium = medium;
	count_live(self);
	return 0;
}

/* Puts the live records but those of `record`'s name, then `record`, in place of the content. */
static int compact(struct settings_records *self, const uint8_t *record, size_t record_length)
{
	struct settings_record saved;
	struct settings_record each;
	size_t cursor = 0;
	size_t length = HEAD_SIZE;
	int rc;

	(void)view(record, &saved);
	memcpy(self->scratch, head, HEAD_SIZE);
	while (settings_records_next(self, &cursor, &each)) {
		const size_t size = padded(HEADER_SIZE + each.name_length + each.value_length);

		if (!same_name(&each, &saved)) {
			memcpy(&self->scratch[length], each.name - HEADER_SIZE, size);
			length += size;
		}
	}
	if (saved.value_length > 0) {
		if (length + record_length > sizeof(self->image) - HEAD_SIZE) {
			return -ENOSPC;
		}
		memcpy(&self->scratch[length], record, record_length);
		length += record_length;
	}
	rc = self->medium->replace(self->scratch, length);
	if (rc != 0) {
		self->stats.errors++;
		return rc;
	}
	memcpy(self->image, self->scratch, length);
	self->length = length;
	self->rewrite = false;
	self->stats.compactions++;
	return 0;
}

static int append(struct settings_records *self, const uint8_t *record, size_t length)
{
	const int rc = self->medium->append(record, length);

	if (rc != 0) {
		/* Part of it may be there: nothing may follow it. */
		self->stats.errors++;
		self->rewrite = true;
		return rc;
	}
	memcpy(&self->image[self->length], record, length);
	self->length += length;
	return 0;
}

int settings_records_save(struct settings_records *self, const char *name, const void *value,
                          size_t value_length)
{
	const size_t name_length = strlen(name);
	uint8_t bytes[RECORD_MAX];
	struct settings_record old = {0};
	size_t length;
	size_t live;
	bool fits;
	int rc;

	if (self->medium == NULL) {
		return -ENODEV;
	}
	if (name_length == 0 || name_length > SETTINGS_RECORD_NAME_MAX ||
	    value_length > SETTINGS_RECORD_VALUE_MAX) {
		return -EINVAL;
	}
	if (!settings_records_find(self, name, &old)) {
		old.value_length = 0;
	}
	if (old.value_length == value_length &&
	    (value_length == 0 || memcmp(old.value, value, value_length) == 0)) {
		return 0;
	}
	live = self->live;
	live -= old.value_length > 0 ? padded(HEADER_SIZE + name_length + old.value_length) : 0;
	live += value_length > 0 ? padded(HEADER_SIZE + name_length + value_length) : 0;
	length = build(bytes, name, value, value_length);
	fits = self->length + length <= sizeof(self->image) - HEAD_SIZE &&
	       (self->length + length <= SETTINGS_RECORDS_COMPACT_MIN ||
	        self->length + length <= 2 * live);
	rc = fits && !self->rewrite ? append(self, bytes, length) : compact(self, bytes, length);
	if (rc == 0) {
		self->live = live;
		self->stats.writes++;
	}
	return rc;
}
