/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Values as people read them. Expected binary32 come from Python's struct.pack("<f", …).hex() and
 * from the compiler's own literals, which are correctly rounded.
 */
#include <string.h>

#include <zephyr/ztest.h>

#include "core/param_units.h"

#define UNTOUCHED (-77)

static const struct param_info *info_of(const char *name)
{
	const struct param_info *const info = params_info(params_find(name, strlen(name)));

	zassert_not_null(info, "%s", name);
	return info;
}

static uint32_t bits_of(float real)
{
	uint32_t bits;

	memcpy(&bits, &real, sizeof(bits));
	return bits;
}

static float real_of(uint32_t bits)
{
	float real;

	memcpy(&real, &bits, sizeof(real));
	return real;
}

static void expect_real(const char *name, int32_t value, float expected)
{
	const uint32_t real = param_to_real(info_of(name), value);

	zassert_equal(real, bits_of(expected), "%s %d is 0x%08x", name, value, real);
}

static void expect_taken(const char *name, float real, int32_t expected)
{
	int32_t value = UNTOUCHED;

	zassert_true(param_from_real(info_of(name), bits_of(real), &value), "%s", name);
	zassert_equal(value, expected, "%s is %d", name, value);
}

static void expect_refused(const char *name, float real)
{
	int32_t value = UNTOUCHED;

	zassert_false(param_from_real(info_of(name), bits_of(real), &value), "%s", name);
	zassert_equal(value, UNTOUCHED);
}

ZTEST_SUITE(core_param_units, NULL, NULL, NULL, NULL, NULL);

ZTEST(core_param_units, test_reals)
{
	expect_real("THR_SHUTDOWN", 100000, 100.0f);
	expect_real("THR_SHUTDOWN", -40000, -40.0f);
	expect_real("THR_SENS_MIN", -273150, -273.15f);
	expect_real("THR_NOISE", 1, 0.001f);
	expect_real("STRB_MAX", 1000, 0.001f);
	expect_real("STRB_MAX", 15999999, 15.999999f);
	expect_real("STRB_MAX", 16000000, 16.0f);
	expect_real("BCN_DUTY", 1, 0.0001f);
	expect_real("LGT_LOSS", 0, 0.0f);
	expect_real("LGT_LOSS", 3599999, 3599.999f);
	expect_real("CAN_LIGHT_ID", -1, -1.0f);
	expect_real("CAN_BITRATE", 1000000, 1e6f);
	zassert_equal(param_to_real(info_of("LGT_LOSS"), 100), 0x3dcccccdu); /* 0.1 */
}

/* Against the division of the processor that this runs on, which rounds correctly. */
ZTEST(core_param_units, test_reals_are_the_nearest)
{
	static const char *const names[] = {"STRB_MAX", "BCN_DUTY", "LGT_LOSS"};
	static const float scales[] = {1e6f, 1e4f, 1e3f};

	for (size_t i = 0; i < ARRAY_SIZE(names); i++) {
		const struct param_info *const info = info_of(names[i]);

		for (int32_t value = info->min; value <= info->max; value += 7) {
			expect_real(names[i], value, (float)value / scales[i]);
		}
	}
}

static void check_round_trip(const struct param_info *info, int32_t value)
{
	char text[DECIMAL_TEXT_MAX];
	int32_t back = UNTOUCHED;

	zassert_true(param_from_real(info, param_to_real(info, value), &back), "%s %d", info->name,
	             value);
	zassert_equal(back, value, "%s: %d came back as %d", info->name, value, back);

	const size_t length = param_print(info, value, text);

	zassert_true(param_parse(info, text, length, &back) && back == value, "%s: %s", info->name,
	             text);
}

/* Every value of each range up to 100 000 values, of wider ones about as many, and both ends. */
ZTEST(core_param_units, test_every_parameter_comes_back_over_its_range)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const struct param_info *const info = params_info(i);
		const int32_t span = info->max - info->min;
		const int32_t step = 1 + span / 100000;

		for (int32_t value = info->min; value <= info->max; value += step) {
			check_round_trip(info, value);
		}
		for (int32_t near = 0; near < 1000 && near <= span; near++) {
			check_round_trip(info, info->max - near);
			check_round_trip(info, info->min + near);
		}
	}
}

ZTEST(core_param_units, test_between_two_steps_the_nearer_one_is_taken)
{
	expect_taken("THR_SHUTDOWN", 99.9994f, 99999);
	expect_taken("THR_SHUTDOWN", 99.9996f, 100000);
	expect_taken("THR_SHUTDOWN", -0.0006f, -1);
	expect_taken("STRB_MIN", 0.0123456f, 12346);
	expect_taken("SYNC_PULSE", 99.6f, 100); /* us are whole */
	expect_taken("PRG_RATE", 60.4f, 60);
	expect_taken("LGT_LOSS", 1e-30f, 0);
	expect_taken("LGT_LOSS", real_of(1), 0); /* the smallest there is */
	expect_taken("LGT_LOSS", -0.0f, 0);
}

ZTEST(core_param_units, test_choices_have_no_fraction)
{
	expect_taken("LGT_FALLBACK", 2.0f, 2);
	expect_taken("LGT_FALLBACK", -0.0f, 0);
	expect_refused("LGT_FALLBACK", 1.5f);
	expect_refused("LGT_FALLBACK", 1.0000001f);
	expect_refused("LGT_FALLBACK", 1e-30f);
	expect_refused("CAN_LIGHT_ID", -0.5f);
}

ZTEST(core_param_units, test_what_no_value_can_be_is_refused)
{
	expect_taken("LGT_CURVE", -2147483648.0f, INT32_MIN); /* its range is another matter */
	expect_taken("LGT_CURVE", 2147483520.0f, 2147483520);
	expect_refused("LGT_CURVE", 2147483648.0f);
	expect_refused("LGT_CURVE", -2147483904.0f);
	expect_taken("THR_HYST", 2147483.5f, 2147483500);
	expect_refused("THR_HYST", 2147484.0f);
	expect_refused("THR_HYST", -2147484.0f);
	expect_refused("THR_HYST", 3e38f);
	expect_refused("THR_HYST", real_of(0x7f800000u)); /* infinite */
	expect_refused("THR_HYST", real_of(0xff800000u));
	expect_refused("THR_HYST", real_of(0x7fc00000u)); /* NaN */
	expect_refused("THR_HYST", real_of(0x7f800001u));
}

ZTEST(core_param_units, test_integers_are_whole_units)
{
	int32_t value = UNTOUCHED;

	zassert_true(param_from_integer(info_of("THR_SHUTDOWN"), -40, &value));
	zassert_equal(value, -40000);
	zassert_true(param_from_integer(info_of("LGT_CURVE"), 1, &value));
	zassert_equal(value, 1);
	zassert_true(param_from_integer(info_of("STRB_MAX"), 2147, &value));
	zassert_equal(value, 2147000000);
	value = UNTOUCHED;
	zassert_false(param_from_integer(info_of("STRB_MAX"), 2148, &value));
	zassert_false(param_from_integer(info_of("STRB_MAX"), INT64_MIN, &value));
	zassert_false(param_from_integer(info_of("LGT_CURVE"), INT64_C(1) << 32, &value));
	zassert_equal(value, UNTOUCHED);
}

static void expect_text(const char *name, const char *text, int32_t expected)
{
	int32_t value = UNTOUCHED;

	zassert_true(param_parse(info_of(name), text, strlen(text), &value), "%s", text);
	zassert_equal(value, expected, "%s is %d", text, value);
}

ZTEST(core_param_units, test_texts)
{
	int32_t value = UNTOUCHED;

	expect_text("THR_SHUTDOWN", "80.5", 80500);
	expect_text("THR_SHUTDOWN", "-0.0006", -1);
	expect_text("LGT_CURVE", "1.000", 1);
	zassert_false(param_parse(info_of("LGT_CURVE"), "0.5", 3, &value));
	zassert_false(param_parse(info_of("THR_SHUTDOWN"), "2147484", 7, &value));
	zassert_false(param_parse(info_of("THR_SHUTDOWN"), "1e3", 3, &value));
	zassert_false(param_parse(info_of("THR_SHUTDOWN"), "", 0, &value));
	zassert_equal(value, UNTOUCHED);
}
