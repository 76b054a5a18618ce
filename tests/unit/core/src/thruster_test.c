/* SPDX-License-Identifier: Apache-2.0 */
#include "core/thruster.h"

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define S INT64_C(1000000)

static struct thruster thruster;

static const struct thruster_config config = {
	.min_us = 1000, .max_us = 2000, .arm_us = 2 * S, .loss_us = S};

static void before(void *fixture)
{
	thruster_init(&thruster, 0, &config);
}

ZTEST_SUITE(core_thruster, NULL, NULL, before, NULL, NULL);

ZTEST(core_thruster, test_takes_no_setpoint_before_it_is_armed)
{
	zassert_equal(thruster_pulse_us(&thruster), 1500);
	zassert_false(thruster_set(&thruster, 2 * S - 1, 1000000));
	zassert_equal(thruster_pulse_us(&thruster), 1500);
	zassert_true(thruster_set(&thruster, 2 * S, 1000000));
	zassert_equal(thruster_pulse_us(&thruster), 2000);
}

ZTEST(core_thruster, test_pulses_of_a_common_esc)
{
	/* value in ppm, pulse in us: 1500 + 500 * value */
	static const int32_t rows[][2] = {{-1000000, 1000}, {-500000, 1250}, {0, 1500},
	                                  {1, 1500},        {999, 1500},     {1000, 1501},
	                                  {250000, 1625},   {1000000, 2000}};

	for (size_t i = 0; i < ARRAY_SIZE(rows); i++) {
		zassert_true(thruster_set(&thruster, 3 * S, rows[i][0]));
		zassert_equal(thruster_pulse_us(&thruster), (uint32_t)rows[i][1], "row %zu", i);
	}
}

ZTEST(core_thruster, test_silence_is_neutral)
{
	zassert_true(thruster_set(&thruster, 3 * S, 500000));
	zassert_equal(thruster_deadline_us(&thruster), 4 * S);
	zassert_true(thruster_set(&thruster, 3 * S + 500000, 500000));
	thruster_advance(&thruster, 4 * S);
	zassert_equal(thruster_pulse_us(&thruster), 1750);
	thruster_advance(&thruster, 4 * S + 499999);
	zassert_equal(thruster_pulse_us(&thruster), 1750);
	thruster_advance(&thruster, 4 * S + 500000);
	zassert_equal(thruster_pulse_us(&thruster), 1500);
	zassert_equal(thruster_deadline_us(&thruster), TIME_NEVER_US);
}

ZTEST(core_thruster, test_new_parameters_make_it_neutral_but_not_unarmed)
{
	const struct thruster_config narrow = {
		.min_us = 1100, .max_us = 1900, .arm_us = 5 * S, .loss_us = S};

	zassert_true(thruster_set(&thruster, 3 * S, 1000000));
	thruster_configure(&thruster, &narrow);
	zassert_equal(thruster_pulse_us(&thruster), 1500);
	zassert_true(thruster_set(&thruster, 3 * S, 1000000));
	zassert_equal(thruster_pulse_us(&thruster), 1900);
}

ZTEST(core_thruster, test_after_its_power_was_off_it_arms_anew)
{
	zassert_true(thruster_set(&thruster, 3 * S, 1000000));
	thruster_restart(&thruster, 10 * S);
	zassert_equal(thruster_pulse_us(&thruster), 1500);
	zassert_equal(thruster_deadline_us(&thruster), TIME_NEVER_US);
	zassert_false(thruster_set(&thruster, 12 * S - 1, 1));
	zassert_true(thruster_set(&thruster, 12 * S, 1));
}

ZTEST(core_thruster, test_impossible_ends_are_a_bug)
{
	struct thruster_config wrong = config;

	wrong.min_us = 2000;
	expect_assert();
	thruster_configure(&thruster, &wrong);
	zassert_unreachable("no assertion");
}

ZTEST(core_thruster, test_impossible_setpoint_is_a_bug)
{
	expect_assert();
	thruster_set(&thruster, 3 * S, 1000001);
	zassert_unreachable("no assertion");
}
