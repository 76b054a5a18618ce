/* SPDX-License-Identifier: Apache-2.0 */
#include "core/store.h"

#include <string.h>

#include <zephyr/ztest.h>

#define S INT64_C(1000000)

static struct store store;
static struct params params; /* as accepted */
static uint8_t slots[STORE_SLOTS][STORE_RECORD_MAX];
static size_t lengths[STORE_SLOTS];

static void before(void *fixture)
{
	params_init(&params);
	store_init(&store);
	memset(lengths, 0, sizeof(lengths));
}

ZTEST_SUITE(core_store, NULL, NULL, before, NULL, NULL);

static void set_at(int64_t now_us, enum param_id id, int32_t value)
{
	struct param_set changed;

	zassert_equal(params_set(&params, id, value, &changed), PARAMS_OK);
	store_params(&store, now_us, &params, &changed);
}

static void set_light_at(int64_t now_us, uint32_t brightness_ppm)
{
	const struct illuminator_settings light = {
		.enable = true,
		.mode = ILLUMINATOR_MODE_INTERNAL,
		.brightness_ppm = brightness_ppm,
		.strobe_period_us = 500000,
		.duty_ppm = 100000,
	};

	store_light(&store, now_us, &light);
}

/* Writes what is due. Returns whether something was. */
static bool write_at(int64_t now_us)
{
	uint8_t record[STORE_RECORD_MAX];
	uint8_t slot;
	const size_t length = store_begin(&store, now_us, record, &slot);

	if (length == 0) {
		return false;
	}
	zassert_true(slot < STORE_SLOTS && length <= sizeof(record));
	memcpy(slots[slot], record, length);
	lengths[slot] = length;
	store_done(&store, now_us, true);
	return true;
}

/* As after a reset. Returns how many slots read whole. */
static int reboot(void)
{
	int whole = 0;

	store_init(&store);
	for (uint8_t slot = 0; slot < STORE_SLOTS; slot++) {
		whole += store_offer(&store, slot, slots[slot], lengths[slot]) ? 1 : 0;
	}
	return whole;
}

static int32_t stored(enum param_id id)
{
	return store.state.params.values[id];
}

/*
 * Made with Python's struct and zlib:
 * body = struct.pack("<IBB", 1, 1, 7) + struct.pack("<IIIBB", 400000, 500000, 100000, 1, 1)
 *        + bytes([5]) + bytes(range(1, 41)) + keys and values
 * record = struct.pack("<I", zlib.crc32(body)) + body
 */
ZTEST(core_store, test_layout)
{
	static const uint8_t expected[] = {
		0x46, 0x27, 0xf5, 0x46, 0x01, 0x00, 0x00, 0x00, 0x01, 0x07, 0x80, 0x1a, 0x06, 0x00,
		0x20, 0xa1, 0x07, 0x00, 0xa0, 0x86, 0x01, 0x00, 0x01, 0x01, 0x05, 0x01, 0x02, 0x03,
		0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0a, 0x0b, 0x0c, 0x0d, 0x0e, 0x0f, 0x10, 0x11,
		0x12, 0x13, 0x14, 0x15, 0x16, 0x17, 0x18, 0x19, 0x1a, 0x1b, 0x1c, 0x1d, 0x1e, 0x1f,
		0x20, 0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x27, 0x28,
		/* STRB_MIN 20000 */
		0xd6, 0x5c, 0xc0, 0xb8, 0x02,
		/* CAN_LIGHT_ID -1 is behind THR_RECOVER -30000 in the table */
		0x06, 0x46, 0xdf, 0xd4, 0x03, 0xbc, 0xbb, 0x01};
	uint8_t signing[STORE_SIGNING_BYTES];

	for (size_t i = 0; i < sizeof(signing); i++) {
		signing[i] = (uint8_t)(i + 1);
	}
	set_at(0, PARAM_STRB_MIN, 20000);
	set_at(0, PARAM_THR_RECOVER, -30000);
	set_at(0, PARAM_CAN_LIGHT_ID, -1);
	set_light_at(0, 400000);
	store_power(&store, 0, 5);
	store_signing(&store, 0, signing);
	zassert_true(write_at(0));
	zassert_equal(lengths[0], sizeof(expected));
	zassert_mem_equal(slots[0], expected, sizeof(expected));
	zassert_equal(reboot(), 1);
	zassert_equal(stored(PARAM_THR_RECOVER), -30000);
	zassert_equal(stored(PARAM_CAN_LIGHT_ID), -1);
	zassert_equal(store.state.power, 5);
	zassert_mem_equal(store.state.signing, signing, sizeof(signing));
	zassert_equal(store.state.light.brightness_ppm, 400000);
	zassert_equal(store.state.light.mode, ILLUMINATOR_MODE_INTERNAL);
	zassert_true(store.state.light.enable);
}

/* The same, with "GONE" 1 before and "NO_SUCH" -70000 after STRB_MIN; sequence 7, nothing else.
 */
ZTEST(core_store, test_a_parameter_that_is_not_in_the_table_is_skipped)
{
	static const uint8_t record[] = {0x68, 0xf2, 0x2f, 0x16, 0x07, 0x00, 0x00, 0x00,
	                                 0x01, 0x00, 0x5a, 0x66, 0x02, 0xd6, 0x5c, 0xc0,
	                                 0xb8, 0x02, 0x00, 0x9d, 0xdf, 0xc5, 0x08};

	zassert_true(store_offer(&store, 0, record, sizeof(record)));
	params.values[PARAM_STRB_MIN] = 20000;
	zassert_mem_equal(store.state.params.values, params.values, sizeof(params.values));
	zassert_false(store.state.has_light || store.state.has_power || store.state.has_signing);
	zassert_equal(store.sequence, 7);
}

/*
 * A record of version 0.1, whose names had their unit: each with a value of its own, those whose
 * range has become narrower with more than it has today. Made as above, with the names of then.
 */
static const uint8_t record_of_0_1[] = {
	0x73, 0x56, 0xe4, 0xd0, 0x09, 0x00, 0x00, 0x00, 0x01, 0x00, 0xff, 0xd2, 0xc0, 0xb8, 0x02,
	0x3b, 0x6d, 0x80, 0x9c, 0x9c, 0x39, 0x56, 0xf8, 0x82, 0x90, 0xa1, 0x0f, 0x93, 0x9d, 0x16,
	0x57, 0x18, 0x80, 0x08, 0x23, 0x0b, 0x6a, 0xca, 0x49, 0xa4, 0x27, 0x24, 0x1c, 0xee, 0x0f,
	0x16, 0x9a, 0xe8, 0x01, 0x7f, 0x4f, 0x22, 0x57, 0x23, 0x24, 0xa3, 0x10, 0x04, 0xe0, 0x8c,
	0x26, 0xae, 0xc9, 0xfe, 0x9b, 0x9c, 0x39, 0x4b, 0xa1, 0xfa, 0x0f, 0x29, 0x64, 0xcc, 0x1f,
	0x5c, 0xe6, 0x2e, 0x1b, 0xc5, 0x98, 0x08, 0xb5, 0x41, 0xba, 0x0e, 0xcf, 0x3c, 0x34, 0x14,
	0xd8, 0xfe, 0x01, 0x26, 0x20, 0x80, 0x02, 0x61, 0xfc, 0x80, 0xa8, 0xd6, 0xb9, 0x07,
};

static const struct {
	enum param_id id;
	int32_t value;
} values_of_0_1[] = {
	{PARAM_STRB_MIN, 20000},   {PARAM_STRB_MAX, 16000000},   {PARAM_BCN_PERIOD, 16000000},
	{PARAM_PRG_FLASH, 11},     {PARAM_PRG_FADE, 512},        {PARAM_PRG_DOT, 53},
	{PARAM_LGT_LOSS, 2514},    {PARAM_THR_STUCK, 1015},      {PARAM_THR_MISS, 116},
	{PARAM_THR_FIRST, 17},     {PARAM_SYNC_TMO, 18},         {PARAM_SYNC_LOSS, 2},
	{PARAM_SYNC_FILT, 19},     {PARAM_SYNC_PULSE, 16000000}, {PARAM_THR_SLEW, 10000000},
#ifdef CONFIG_PHAROS_IMC
	{PARAM_ESC_MIN, 1021},     {PARAM_ESC_MAX, 2022},        {PARAM_ESC_ARM, 23},
	{PARAM_ESC_LOSS, 524},     {PARAM_ZOOM_TIME, 925},       {PARAM_DOWN_TIME, 26},
#endif
#ifdef CONFIG_PHAROS_GIMBAL
	{PARAM_GMB_RATE_TMO, 127}, {PARAM_GMB_ATT_TMO, 128},
#endif
};

static void assert_values_of_0_1(void)
{
	for (size_t i = 0; i < ARRAY_SIZE(values_of_0_1); i++) {
		zassert_equal(stored(values_of_0_1[i].id), values_of_0_1[i].value, "%s is %d",
		              params_info(values_of_0_1[i].id)->name, stored(values_of_0_1[i].id));
		params.values[values_of_0_1[i].id] = values_of_0_1[i].value;
	}
	zassert_mem_equal(store.state.params.values, params.values, sizeof(params.values));
}

ZTEST(core_store, test_a_record_of_version_0_1_is_converted)
{
	zassert_true(store_offer(&store, 0, record_of_0_1, sizeof(record_of_0_1)));
	assert_values_of_0_1();
	const struct param_set mended = store_check(&store);

	zassert_true(param_set_is_empty(&mended));
	assert_values_of_0_1();
	/* Once: the next record has the names of today, and as many values. */
	store_touch(&store, 0);
	zassert_true(write_at(0));
	zassert_equal(reboot(), 1);
	assert_values_of_0_1();
	zassert_equal(store_find("STRB_MIN_US"), PARAM_STRB_MIN);
	zassert_equal(store_find("STRB_MIN"), PARAM_STRB_MIN);
	zassert_equal(strcmp(store_former_name(PARAM_STRB_MIN), "STRB_MIN_US"), 0);
	zassert_is_null(store_former_name(PARAM_LGT_CURVE));
}

/* What was out of range then is no end of a range. */
ZTEST(core_store, test_only_what_a_range_once_had_becomes_its_end)
{
	store_put(&store, PARAM_STRB_MAX, 60000000);
	zassert_equal(stored(PARAM_STRB_MAX), 16000000);
	store_put(&store, PARAM_STRB_MAX, 60000001);
	zassert_equal(stored(PARAM_STRB_MAX), 60000001);
	store_put(&store, PARAM_THR_SLEW, 1000000000);
	zassert_equal(stored(PARAM_THR_SLEW), 10000000);
	store_put(&store, PARAM_THR_SLEW, 1000000001);
	zassert_equal(stored(PARAM_THR_SLEW), 1000000001);
	store_put(&store, PARAM_THR_STUCK, 3600001);
	zassert_equal(stored(PARAM_THR_STUCK), 3600001);
}

/* Each alone, at both ends of its range: no two names have one key. */
ZTEST(core_store, test_every_parameter_comes_back_as_itself)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const struct param_info *const info = params_info(i);
		const int32_t ends[] = {info->min, info->max};
		const bool read_only = (info->flags & PARAM_FLAG_READ_ONLY) != 0;

		for (size_t end = 0; end < ARRAY_SIZE(ends); end++) {
			struct param_set set = {0};

			before(NULL);
			params.values[i] = ends[end];
			param_set_add(&set, i);
			store_params(&store, 0, &params, &set);
			store_touch(&store, 0);
			zassert_true(write_at(0));
			zassert_equal(reboot(), 1);
			params.values[i] = read_only ? info->fallback : ends[end];
			zassert_mem_equal(store.state.params.values, params.values,
			                  sizeof(params.values), "%s", info->name);
		}
	}
}

ZTEST(core_store, test_the_longest_record_has_room)
{
	static const uint8_t signing[STORE_SIGNING_BYTES] = {1};
	const struct param_set all = params_settable();

	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const struct param_info *const info = params_info(i);

		params.values[i] = info->fallback == info->max ? info->max - 1 : info->max;
		if (-(int64_t)info->min > info->max) {
			params.values[i] = info->min;
		}
	}
	store_params(&store, 0, &params, &all);
	set_light_at(0, 1);
	store_power(&store, 0, 1);
	store_signing(&store, 0, signing);
	zassert_true(write_at(0));
	zassert_within(lengths[0], STORE_RECORD_MAX, 10, "the bound is close: %zu", lengths[0]);
	zassert_equal(reboot(), 1);
	params.values[PARAM_LGT_SRC_NOW] = params_info(PARAM_LGT_SRC_NOW)->fallback;
	zassert_mem_equal(store.state.params.values, params.values, sizeof(params.values));
}

ZTEST(core_store, test_slots_take_turns_and_the_newest_counts)
{
	for (int32_t i = 1; i <= 5; i++) {
		set_at(i, PARAM_STRB_MIN, 10000 + i);
		zassert_true(write_at(i));
		zassert_equal(reboot(), i == 1 ? 1 : 2);
		zassert_equal(stored(PARAM_STRB_MIN), 10000 + i);
	}
	/* And goes on where it was. */
	zassert_equal(store.sequence, 5);
	lengths[0] = 0;
	zassert_equal(reboot(), 1);
	zassert_equal(stored(PARAM_STRB_MIN), 10004);
}

ZTEST(core_store, test_a_record_that_is_cut_or_changed_anywhere_does_not_read_whole)
{
	size_t length;

	set_at(0, PARAM_STRB_MIN, 20000);
	set_light_at(0, 7);
	zassert_true(write_at(0));
	length = lengths[0];
	for (lengths[0] = 0; lengths[0] < length; lengths[0]++) {
		zassert_equal(reboot(), 0, "%zu bytes", lengths[0]);
	}
	for (size_t bit = 0; bit < 8 * length; bit++) {
		slots[0][bit / 8] ^= (uint8_t)(1 << bit % 8);
		zassert_equal(reboot(), 0, "bit %zu", bit);
		slots[0][bit / 8] ^= (uint8_t)(1 << bit % 8);
	}
	zassert_equal(reboot(), 1);
}

ZTEST(core_store, test_of_a_broken_record_limits_of_heat_count_where_they_are_lower)
{
	set_at(0, PARAM_THR_RECOVER, 30000);
	set_at(0, PARAM_THR_THROTTLE, 40000);
	set_at(0, PARAM_THR_SHUTDOWN, 120000); /* warmer than its default */
	set_at(0, PARAM_THR_SAFE, 0);
	set_at(0, PARAM_THR_FLOOR, 1000000);
	set_at(0, PARAM_STRB_MIN, 20000);
	set_light_at(0, 7);
	zassert_true(write_at(0));
	slots[0][0] ^= 1;
	zassert_equal(reboot(), 0);
	store_salvage(&store, slots[0], lengths[0]);
	zassert_true(store_check(&store).words[0] == 0, "what was salvaged holds together");
	params_init(&params);
	params.values[PARAM_THR_RECOVER] = 30000;
	params.values[PARAM_THR_THROTTLE] = 40000;
	params.values[PARAM_THR_SAFE] = 0;
	zassert_mem_equal(store.state.params.values, params.values, sizeof(params.values));
	zassert_false(store.state.has_light, "the lamp stays dark");
}

ZTEST(core_store, test_what_is_there_already_costs_nothing)
{
	static const uint8_t signing[STORE_SIGNING_BYTES] = {1};
	const struct param_set all = params_settable();

	store.state.power = 7; /* holds, and is not stored */
	store_power(&store, 0, 7);
	zassert_equal(store_deadline_us(&store), TIME_NEVER_US);
	set_at(0, PARAM_STRB_MIN, 20000);
	set_light_at(0, 7);
	store_power(&store, 0, 5);
	store_signing(&store, 0, signing);
	zassert_true(write_at(0));
	store_params(&store, S, &params, &all);
	set_light_at(S, 7);
	store_power(&store, S, 5);
	store_signing(&store, S, signing);
	zassert_equal(store_deadline_us(&store), TIME_NEVER_US);
	zassert_false(write_at(1000 * S));
}

ZTEST(core_store, test_light_settles_and_goes_along_with_what_does_not)
{
	set_light_at(10 * S, 1);
	zassert_equal(store_deadline_us(&store), 11 * S);
	zassert_false(write_at(11 * S - 1));
	set_at(10 * S + 100, PARAM_STRB_MIN, 20000);
	zassert_equal(store_deadline_us(&store), 10 * S + 100);
	zassert_true(write_at(10 * S + 100));
	zassert_equal(store_deadline_us(&store), TIME_NEVER_US);
	zassert_equal(reboot(), 1);
	zassert_true(store.state.has_light);
	zassert_equal(store.state.light.brightness_ppm, 1);
	zassert_equal(stored(PARAM_STRB_MIN), 20000);
}

ZTEST(core_store, test_what_is_accepted_during_a_write_is_for_the_next)
{
	uint8_t record[STORE_RECORD_MAX];
	uint8_t slot;

	set_at(0, PARAM_STRB_MIN, 20000);
	zassert_true(store_begin(&store, 0, record, &slot) > 0);
	set_at(1, PARAM_STRB_MIN, 30000);
	store_done(&store, 2, true);
	zassert_equal(store_deadline_us(&store), 1);
	zassert_true(write_at(2));
	zassert_equal(reboot(), 1, "the first one was not put anywhere");
	zassert_equal(stored(PARAM_STRB_MIN), 30000);
	zassert_equal(store.sequence, 2);
}

ZTEST(core_store, test_a_write_that_failed_is_tried_again)
{
	uint8_t record[STORE_RECORD_MAX];
	uint8_t first;
	uint8_t second;

	set_light_at(0, 1);
	zassert_true(store_begin(&store, S, record, &first) > 0);
	store_done(&store, S, false);
	zassert_equal(store_deadline_us(&store), S + STORE_RETRY_US);
	/* Sooner, when something is accepted; and into the same slot: the other one is whole. */
	set_at(2 * S, PARAM_STRB_MIN, 20000);
	zassert_equal(store_deadline_us(&store), 2 * S);
	zassert_true(store_begin(&store, 2 * S, record, &second) > 0);
	zassert_equal(second, first);
	store_done(&store, 2 * S, true);
	zassert_equal(store_deadline_us(&store), TIME_NEVER_US);
}
