/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The log of settings records over a medium in memory, whose power can be cut at any byte: what has
 * reached it before stays, nothing after does.
 */
#include <errno.h>
#include <string.h>

#include <zephyr/ztest.h>

#include "subsys/settings/settings_records.h"

#define UNLIMITED UINT64_MAX

static uint8_t disk[CONFIG_SETTINGS_STORAGE_SIZE];
static size_t disk_length;
static uint64_t bytes_left;
static uint64_t bytes_written;

static struct settings_records records;

/* How many of these bytes reach the disk. */
static size_t pass(size_t length)
{
	const size_t through = length <= bytes_left ? length : (size_t)bytes_left;

	if (bytes_left != UNLIMITED) {
		/* After the cut nothing more does. */
		bytes_left = through == length ? bytes_left - through : 0;
	}
	bytes_written += through;
	return through;
}

static int disk_size(void)
{
	return (int)disk_length;
}

/* The word that cannot be read. */
static size_t lost_at;
static size_t lost_size;

static int disk_read(size_t offset, void *buffer, size_t length)
{
	zassert_true(offset + length <= disk_length);
	if (lost_size > 0 && offset < lost_at + lost_size && lost_at < offset + length) {
		memset(buffer, 0xA5, length);
		return -EIO;
	}
	memcpy(buffer, &disk[offset], length);
	return 0;
}

static int disk_append(const void *data, size_t length)
{
	const size_t through = pass(length);

	memcpy(&disk[disk_length], data, through);
	disk_length += through;
	return through == length ? 0 : -EIO;
}

/* A new file, then a rename: one byte more stands for it. */
static int disk_replace(const void *data, size_t length)
{
	if (pass(length) != length || pass(1) != 1) {
		return -EIO;
	}
	memcpy(disk, data, length);
	disk_length = length;
	lost_size = 0;
	return 0;
}

static const struct settings_medium medium = {
	.length = disk_size,
	.read = disk_read,
	.append = disk_append,
	.replace = disk_replace,
};

static void power_on(void)
{
	bytes_left = UNLIMITED;
	zassert_equal(settings_records_open(&records, &medium), 0);
}

static int save(const char *name, const char *value)
{
	return settings_records_save(&records, name, value, strlen(value));
}

static bool has(const char *name, const char *value)
{
	struct settings_record record;

	if (!settings_records_find(&records, name, &record)) {
		return value == NULL;
	}
	return value != NULL && record.value_length == strlen(value) &&
	       memcmp(record.value, value, record.value_length) == 0;
}

static size_t count(void)
{
	struct settings_record record;
	size_t cursor = 0;
	size_t found = 0;

	while (settings_records_next(&records, &cursor, &record)) {
		found++;
	}
	return found;
}

static void before(void *fixture)
{
	memset(disk, 0, sizeof(disk));
	disk_length = 0;
	lost_size = 0;
	power_on();
	bytes_written = 0;
}

ZTEST_SUITE(settings_records, NULL, NULL, before, NULL, NULL);

ZTEST(settings_records, test_saved_values_are_read_after_power_on)
{
	zassert_equal(save("a", "1"), 0);
	zassert_equal(save("b/c", "two"), 0);
	power_on();
	zassert_true(has("a", "1"));
	zassert_true(has("b/c", "two"));
	zassert_false(has("b", "two"));
	zassert_equal(count(), 2);
	zassert_equal(records.stats.broken, 0);
}

ZTEST(settings_records, test_layout)
{
	/* The CRCs are Python's: binascii.crc_hqx(bytes.fromhex("a75301000100"), 0xffff) = 0x991c
	 * and binascii.crc32(bytes.fromhex("a753010001001c99") + b"a1") = 0x2112e6d2.
	 */
	static const uint8_t expected[64] = "PHAROS settings 1\n\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
					    "\xa7\x53\x01\x00\x01\x00\x1c\x99\xd2\xe6\x12\x21"
					    "a1";

	zassert_equal(save("a", "1"), 0);
	zassert_equal(disk_length, sizeof(expected));
	zassert_mem_equal(disk, expected, sizeof(expected));
}

/* Of version 0.1, without filling up. */
ZTEST(settings_records, test_layout_of_an_earlier_version_is_read_and_replaced)
{
	static const uint8_t earlier[] = "PHAROS settings 1\n"
					 "\xa7\x53\x01\x00\x01\x00\x1c\x99\xd2\xe6\x12\x21"
					 "a1"
					 "\xa7\x53\x01\x00\x01\x00\x1c\x99\xd2\xe6\x12\x21"
					 "a1";

	memcpy(disk, earlier, sizeof(earlier) - 1);
	disk_length = sizeof(earlier) - 1;
	power_on();
	zassert_true(has("a", "1"));
	zassert_equal(records.stats.broken, 0);
	zassert_equal(save("b", "2"), 0);
	zassert_equal(disk_length, 32 + 2 * 32);
	power_on();
	zassert_true(has("a", "1"));
	zassert_true(has("b", "2"));
}

ZTEST(settings_records, test_last_value_counts)
{
	zassert_equal(save("a", "1"), 0);
	zassert_equal(save("b", "2"), 0);
	zassert_equal(save("a", "longer"), 0);
	power_on();
	zassert_true(has("a", "longer"));
	zassert_equal(count(), 2);
}

ZTEST(settings_records, test_deleted_value_is_gone)
{
	zassert_equal(save("a", "1"), 0);
	zassert_equal(save("a", ""), 0);
	zassert_true(has("a", NULL));
	power_on();
	zassert_true(has("a", NULL));
	zassert_equal(count(), 0);
	zassert_equal(save("a", "2"), 0);
	power_on();
	zassert_true(has("a", "2"));
}

ZTEST(settings_records, test_value_that_is_stored_is_not_written_again)
{
	zassert_equal(save("a", "1"), 0);
	bytes_written = 0;
	zassert_equal(save("a", "1"), 0);
	zassert_equal(save("never", ""), 0);
	zassert_equal(bytes_written, 0);
	zassert_equal(save("a", "2"), 0);
	zassert_not_equal(bytes_written, 0);
}

ZTEST(settings_records, test_limits)
{
	char name[SETTINGS_RECORD_NAME_MAX + 2];
	char value[SETTINGS_RECORD_VALUE_MAX + 2];

	memset(name, 'n', sizeof(name));
	memset(value, 'v', sizeof(value));
	name[sizeof(name) - 1] = '\0';
	value[sizeof(value) - 1] = '\0';
	zassert_equal(save("", "1"), -EINVAL);
	zassert_equal(save(name, "1"), -EINVAL);
	zassert_equal(save("a", value), -EINVAL);
	name[SETTINGS_RECORD_NAME_MAX] = '\0';
	value[SETTINGS_RECORD_VALUE_MAX] = '\0';
	zassert_equal(save(name, value), 0);
	power_on();
	zassert_true(has(name, value));
}

ZTEST(settings_records, test_content_is_compacted)
{
	char value[8] = "0000000";

	zassert_equal(save("kept", "for ever"), 0);
	for (int i = 0; i < 10000; i++) {
		value[i % 7] = (char)('0' + i % 10);
		zassert_equal(save("a", value), 0);
	}
	zassert_true(disk_length < 2 * SETTINGS_RECORDS_COMPACT_MIN, "%zu", disk_length);
	zassert_true(records.stats.compactions > 10);
	power_on();
	zassert_true(has("kept", "for ever"));
	zassert_true(has("a", value));
}

ZTEST(settings_records, test_full_store_refuses_and_keeps)
{
	char name[16];
	char value[SETTINGS_RECORD_VALUE_MAX + 1];
	size_t stored = 0;
	int rc = 0;

	memset(value, 'v', sizeof(value) - 1);
	value[sizeof(value) - 1] = '\0';
	for (int i = 0; i < 10000 && rc == 0; i++) {
		(void)snprintf(name, sizeof(name), "n%04d", i);
		rc = save(name, value);
		stored += rc == 0 ? 1 : 0;
	}
	zassert_equal(rc, -ENOSPC);
	power_on();
	zassert_equal(count(), stored);
	/* Room is made by deleting. */
	zassert_equal(save("n0000", ""), 0);
	zassert_equal(save(name, value), 0);
	power_on();
	zassert_equal(count(), stored);
}

/* A few names with values of several lengths, small enough a store to be compacted often. */
static const struct {
	const char *name;
	const char *value;
} script[] = {
	{"light/level", "0123456789012345678901234567890123456789"},
	{"thermal/limit", "5"},
	{"light/level", "abcdefghijklmnopqrstuvwxyzabcdefghijklmn"},
	{"boots", "1"},
	{"thermal/limit", ""},
	{"light/level", "x"},
	{"boots", "22"},
	{"light/level", "00000000000000000000000000000000000000000000000000"},
	{"thermal/limit", "8888"},
	{"boots", ""},
	{"light/level", "1111111111111111111111111111111111111111111111111"},
	{"light/level", "2222222222222222222222222222222222222222222222222"},
	{"thermal/limit", "333333333333333333333333333333"},
	{"light/level", "4444444444444444444444444444444444444444444444444"},
	{"light/level", "5555555555555555555555555555555555555555555555555"},
	{"boots", "66666666666666666666666666666666666666666"},
	{"light/level", "77777777777777777777777777777777777777"},
	{"light/level", "8"},
};

/* Several times over, so that it is compacted on the way. */
#define STEPS (4 * ARRAY_SIZE(script))

static const char *const names[] = {"light/level", "thermal/limit", "boots"};

/* The value of a name after the first `steps` of the script; NULL: none. */
static const char *model(const char *name, size_t steps)
{
	const char *value = NULL;

	for (size_t i = 0; i < steps; i++) {
		const char *each = script[i % ARRAY_SIZE(script)].value;

		if (strcmp(script[i % ARRAY_SIZE(script)].name, name) == 0) {
			value = each[0] == '\0' ? NULL : each;
		}
	}
	return value;
}

static bool is_state_after(size_t steps)
{
	for (size_t i = 0; i < ARRAY_SIZE(names); i++) {
		if (!has(names[i], model(names[i], steps))) {
			return false;
		}
	}
	return true;
}

/* Runs the script until it fails; returns how many steps were acknowledged. */
static size_t run_script(void)
{
	for (size_t i = 0; i < STEPS; i++) {
		const size_t at = i % ARRAY_SIZE(script);

		if (save(script[at].name, script[at].value) != 0) {
			return i;
		}
	}
	return STEPS;
}

ZTEST(settings_records, test_power_cut_at_every_byte_of_every_write)
{
	uint64_t total;
	uint32_t compactions;
	size_t last = 0;

	zassert_equal(run_script(), STEPS);
	total = bytes_written;
	compactions = records.stats.compactions;
	zassert_true(compactions >= 5, "%u: cuts during compaction are tried, too",
	             (unsigned int)compactions);
	for (uint64_t cut = 0; cut <= total; cut++) {
		size_t done;

		before(NULL);
		bytes_left = cut;
		done = run_script();
		zassert_true(done >= last);
		last = done;
		power_on();
		/* What was acknowledged is there; the write that was cut is there whole, or not at
		 * all. */
		zassert_true(is_state_after(done) || (done < STEPS && is_state_after(done + 1)),
		             "cut after %llu bytes, step %zu", (unsigned long long)cut, done);
		/* And the store works on. */
		zassert_equal(save("after", "the cut"), 0);
		power_on();
		zassert_true(has("after", "the cut"));
		zassert_equal(records.stats.broken, 0);
	}
	zassert_equal(last, STEPS);
}

/* Flash words with a checksum: one that was only begun cannot be read, as long as it is there. */
ZTEST(settings_records, test_a_word_that_a_cut_left_unreadable_costs_the_record_being_written)
{
	static const size_t words[] = {4, 8, 32};

	for (size_t i = 0; i < ARRAY_SIZE(words); i++) {
		for (size_t cut = 0; cut < 32; cut++) {
			before(NULL);
			zassert_equal(save("a", "old"), 0);
			zassert_equal(save("b", "kept"), 0);
			bytes_left = cut;
			zassert_equal(save("a", "new, and with the filling two words long"), -EIO);
			if (cut % words[i] != 0) {
				lost_at = disk_length - cut % words[i];
				lost_size = words[i];
			}
			power_on();
			zassert_true(has("a", "old"), "word %zu, cut %zu", words[i], cut);
			zassert_true(has("b", "kept"), "word %zu, cut %zu", words[i], cut);
			/* The next write makes a new content, which can be read. */
			zassert_equal(save("a", "newer"), 0);
			power_on();
			zassert_equal(records.stats.broken, 0);
			zassert_true(has("a", "newer"));
			zassert_true(has("b", "kept"));
		}
	}
}

ZTEST(settings_records, test_failed_write_leaves_the_old_value_without_a_power_cut)
{
	zassert_equal(save("a", "old"), 0);
	bytes_left = 5;
	zassert_equal(save("a", "new"), -EIO);
	zassert_equal(records.stats.errors, 1);
	zassert_true(has("a", "old"));
	/* The disk works again, the device was not reset: half a record lies there. */
	bytes_left = UNLIMITED;
	zassert_equal(save("b", "1"), 0);
	power_on();
	zassert_true(has("a", "old"));
	zassert_true(has("b", "1"));
	zassert_equal(records.stats.broken, 0);
}

/* The head, or what fills up one of the three records to whole words. */
static bool is_filling(size_t byte)
{
	static const size_t lengths[] = {22, 23, 22}; /* 12 + name + value */

	return byte < 32 || byte % 32 >= lengths[byte / 32 - 1];
}

ZTEST(settings_records, test_each_flipped_bit_costs_at_most_its_own_record)
{
	size_t sound_length;

	zassert_equal(save("first", "11111"), 0);
	zassert_equal(save("second", "22222"), 0);
	zassert_equal(save("third", "33333"), 0);
	sound_length = disk_length;
	for (size_t bit = 0; bit < sound_length * 8; bit++) {
		uint8_t *const byte = &disk[bit / 8];
		int lost;

		*byte ^= (uint8_t)(1 << bit % 8);
		power_on();
		lost = !has("first", "11111") + !has("second", "22222") + !has("third", "33333");
		if (is_filling(bit / 8)) {
			zassert_equal(lost, 0, "head or filling, bit %zu", bit);
		} else {
			zassert_equal(lost, 1, "bit %zu: %d lost", bit, lost);
			zassert_equal(records.stats.broken, 1, "bit %zu: %u", bit,
			              (unsigned int)records.stats.broken);
		}
		zassert_equal(count(), (size_t)(3 - lost));
		*byte ^= (uint8_t)(1 << bit % 8);
	}
}

ZTEST(settings_records, test_broken_records_are_gone_after_the_next_write)
{
	zassert_equal(save("first", "11111"), 0);
	zassert_equal(save("second", "22222"), 0);
	disk[32 + SETTINGS_RECORD_HEADER_SIZE] ^= 1;
	power_on();
	zassert_equal(records.stats.broken, 1);
	zassert_equal(save("third", "33333"), 0);
	power_on();
	zassert_equal(records.stats.broken, 0);
	zassert_true(has("second", "22222"));
	zassert_true(has("third", "33333"));
	zassert_equal(count(), 2);
}

ZTEST(settings_records, test_foreign_content_is_left_alone)
{
	memcpy(disk, "root:x:0:0:root:/root:/bin/bash\n", 32);
	disk_length = 32;
	zassert_equal(settings_records_open(&records, &medium), -EBADMSG);
	zassert_equal(save("a", "1"), -ENODEV);
	zassert_equal(disk_length, 32);
	zassert_mem_equal(disk, "root:x:0", 8);
}

ZTEST(settings_records, test_content_that_is_too_long_is_refused)
{
	disk_length = sizeof(disk);
	zassert_equal(settings_records_open(&records, &medium), -EFBIG);
}
