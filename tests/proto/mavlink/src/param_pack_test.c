/* SPDX-License-Identifier: Apache-2.0 */
/* The packed parameters, byte by byte. */
#include "proto/mavlink/param_pack.h"

#include <string.h>

#include <zephyr/ztest.h>

static struct params params;
static struct mavlink_param_pack pack;

static void before(void *unused)
{
	(void)unused;
	params_init(&params);
	mavlink_param_pack_take(&pack, &params);
}

ZTEST_SUITE(mavlink_param_pack, NULL, NULL, before, NULL, NULL);

/* LGT_CURVE 1, its default, then LGT_RESTORE 1 where 0 is the default, then STRB_MIN.
 * Values are binary32: 1.0 is 0x3F800000, 0.01 is 0x3C23D70A. */
ZTEST(mavlink_param_pack, test_head_and_first_entries)
{
	/* but for the 20 of the gimbal's component */
	static const uint8_t head[] = {0x1C, 0x67, PARAM_COUNT - 20, 0, PARAM_COUNT - 20, 0};
	static const uint8_t curve[] = "\x04\x80LGT_CURVE\0\0\x80\x3F";       /* 9 letters */
	static const uint8_t restore[] = "\x14\x64RESTORE\0\0\x80\x3F\0\0\0"; /* 4 and 7 */
	static const uint8_t shortest[] = "\x04\x70STRB_MIN\x0A\xD7\x23\x3C"; /* 0.01 */
	uint8_t bytes[100];

	BUILD_ASSERT(PARAM_COUNT < 256, "as the bytes above have it");
	pack.values[PARAM_LGT_RESTORE] = 1;
	zassert_equal(params_info(PARAM_LGT_CURVE)->fallback, 1);
	zassert_equal(params_info(PARAM_LGT_RESTORE)->fallback, 0);
	mavlink_param_pack_read(&pack, true, 0, sizeof(bytes), bytes);
	zassert_mem_equal(bytes, head, 6);
	zassert_mem_equal(bytes + 6, curve, 15);
	zassert_mem_equal(bytes + 21, restore, 17);
	zassert_mem_equal(bytes + 38, shortest, 14);
}

ZTEST(mavlink_param_pack, test_without_defaults_there_are_none)
{
	uint8_t head[2];
	uint32_t plain;

	plain = mavlink_param_pack_length(&pack, false);
	zassert_equal(mavlink_param_pack_length(&pack, true), plain, "all have their default");
	pack.values[PARAM_LGT_RESTORE] = 1;
	pack.values[PARAM_LGT_FALLBACK] = 2;
	zassert_equal(mavlink_param_pack_length(&pack, false), plain);
	zassert_equal(mavlink_param_pack_length(&pack, true), plain + 2 * 4);
	mavlink_param_pack_read(&pack, false, 0, sizeof(head), head);
	zassert_equal(head[0], 0x1B);
	zassert_equal(head[1], 0x67);
}

ZTEST(mavlink_param_pack, test_parts_of_any_size_make_the_same_file)
{
	static uint8_t whole[4096];
	const uint32_t length = mavlink_param_pack_length(&pack, false);
	uint32_t got = 0;

	zassert_true(length < sizeof(whole));
	while (got < length) {
		const uint8_t count = (uint8_t)(length - got < 239 ? length - got : 239);

		mavlink_param_pack_read(&pack, false, got, count, whole + got);
		got += count;
	}
	for (uint8_t part = 1; part < 60; part = (uint8_t)(part + 7)) {
		for (uint32_t at = 0; at + part <= length; at += part) {
			uint8_t bytes[60];

			mavlink_param_pack_read(&pack, false, at, part, bytes);
			zassert_mem_equal(bytes, whole + at, part);
		}
	}
}

ZTEST(mavlink_param_pack, test_what_has_changed_since_is_outdated)
{
	struct param_set outdated = mavlink_param_pack_outdated(&pack, &params);

	zassert_true(param_set_is_empty(&outdated));
	params.values[PARAM_LGT_CURVE] ^= 1;
	outdated = mavlink_param_pack_outdated(&pack, &params);
	zassert_equal(param_set_take(&outdated), PARAM_LGT_CURVE);
	zassert_true(param_set_is_empty(&outdated));
}

/* It is the illuminator's. */
ZTEST(mavlink_param_pack, test_the_gimbals_parameters_are_not_in_it)
{
	const struct param_set none = {0};
	struct param_set outdated;

	params.values[PARAM_GMB_PAN_MIN] -= 1000;
	outdated = mavlink_param_pack_outdated(&pack, &params);
	zassert_mem_equal(&outdated, &none, sizeof(none));
}
