/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The models against their formulas. Expected values were computed apart from the models, with
 * Python's math.exp and math.log from the formula beside each.
 */
#include <math.h>

#include <zephyr/ztest.h>

#include "models/lamp.h"
#include "models/lines.h"
#include "models/noise.h"
#include "models/ntc_input.h"
#include "models/servo.h"
#include "models/thermal_mass.h"

#define S INT64_C(1000000)

/* --- noise --- */

ZTEST(models, test_noise_is_standard_normal_to_its_second_moment)
{
	const int draws = 100000;
	struct noise noise = {.state = 7};
	double sum = 0.0;
	double squares = 0.0;
	int beyond_one = 0;

	for (int i = 0; i < draws; i++) {
		const double x = noise_next(&noise);

		sum += x;
		squares += x * x;
		beyond_one += fabs(x) > 1.0;
	}
	/* bounds of 4 standard errors: 4/sqrt(n), 4*sqrt(2/n) */
	zassert_within(sum / draws, 0.0, 0.0127);
	zassert_within(squares / draws, 1.0, 0.0179);
	/* normal: 31.73 % are beyond 1; 4 standard errors are 0.59 % */
	zassert_within((double)beyond_one / draws, 0.3173, 0.0059);
}

ZTEST(models, test_noise_repeats_with_its_seed)
{
	struct noise a = {.state = 1};
	struct noise b = {.state = 1};
	struct noise other = {.state = 2};
	int same = 0;

	for (int i = 0; i < 100; i++) {
		const double x = noise_next(&a);

		zassert_true(x == noise_next(&b));
		same += x == noise_next(&other);
	}
	zassert_true(same < 3);
}

/* --- thermal mass --- */

/* time constants: 96 s with the fan, 750 s without */
static const struct thermal_mass_params params = {
	.capacity_j_per_k = 60.0,
	.fan_k_per_w = 1.6,
	.no_fan_k_per_w = 12.5,
};

ZTEST(models, test_heat_rises_exponentially)
{
	struct thermal_mass mass;

	thermal_mass_init(&mass, &params, 25.0);
	thermal_mass_set_heat(&mass, 0, 25.0);
	/* 25 + 40 (1 - e^-1) */
	zassert_within(thermal_mass_advance(&mass, 96 * S), 50.28482235, 1e-6);
	/* steady: 25 °C + 25 W * 1.6 K/W */
	zassert_within(thermal_mass_advance(&mass, 9600 * S), 65.0, 1e-6);
}

ZTEST(models, test_failed_fan_changes_resistance)
{
	struct thermal_mass mass;

	thermal_mass_init(&mass, &params, 25.0);
	thermal_mass_set_fan(&mass, 0, true);
	thermal_mass_set_heat(&mass, 0, 4.0);
	/* 25 + 50 (1 - e^(-100/750)) */
	zassert_within(thermal_mass_advance(&mass, 100 * S), 31.24133405, 1e-6);
	thermal_mass_set_fan(&mass, 100 * S, false);
	/* 25 °C + 4 W * 1.6 K/W */
	zassert_within(thermal_mass_advance(&mass, 10000 * S), 31.4, 1e-6);
}

ZTEST(models, test_step_size_does_not_matter)
{
	struct thermal_mass once;
	struct thermal_mass often;

	thermal_mass_init(&once, &params, 25.0);
	thermal_mass_set_heat(&once, 0, 25.0);
	often = once;
	for (int64_t step = 1; step <= 100000; step++) {
		thermal_mass_advance(&often, step * 1000);
	}
	zassert_within(often.temp_c, thermal_mass_advance(&once, 100 * S), 1e-9);
}

ZTEST(models, test_time_does_not_run_back)
{
	struct thermal_mass mass;

	thermal_mass_init(&mass, &params, 25.0);
	thermal_mass_set_heat(&mass, 0, 25.0);

	const double later = thermal_mass_advance(&mass, 10 * S);

	zassert_true(thermal_mass_advance(&mass, 5 * S) == later);
	thermal_mass_set_temp(&mass, 10 * S, 90.0);
	thermal_mass_set_ambient(&mass, 10 * S, 90.0 - 40.0);
	zassert_within(thermal_mass_advance(&mass, 20 * S), 90.0, 1e-9);
}

/* --- lamp --- */

static struct lamp lamp;

ZTEST(models, test_lamp_is_lit_only_with_duty_and_enable)
{
	lamp_init(&lamp, 30000);
	zassert_false(lamp_set_duty(&lamp, 0, 400000));
	zassert_equal(lamp.level_ppm, 0);
	zassert_true(lamp_set_enable(&lamp, 0, true));
	zassert_equal(lamp.level_ppm, 400000);
	zassert_false(lamp_set_enable(&lamp, 0, true));
	zassert_true(lamp_set_duty(&lamp, 0, 0));
	zassert_equal(lamp.level_ppm, 0);
	zassert_equal(lamp.edges, 2);
}

ZTEST(models, test_lamp_energy_and_light)
{
	lamp_init(&lamp, 30000);
	lamp_set_enable(&lamp, 0, true);
	lamp_set_duty(&lamp, 1 * S, 500000);
	zassert_within(lamp_power_w(&lamp), 15.0, 1e-9);
	lamp_set_duty(&lamp, 3 * S, 1000000);
	lamp_set_duty(&lamp, 4 * S, 0);
	lamp_advance(&lamp, 100 * S);
	/* 15 W for 2 s and 30 W for 1 s: 60 J */
	zassert_within(lamp_energy_mj(&lamp), 60000.0, 1e-6);
	zassert_equal(lamp.light_us, 2000000);
	zassert_equal(lamp.lit_us, 3000000);
	zassert_equal(lamp.peak_ppm, 1000000);
	zassert_equal(lamp.edges, 2);
	zassert_equal(lamp.changes, 3);
}

ZTEST(models, test_lamp_light_does_not_lose_remainders)
{
	lamp_init(&lamp, 30000);
	lamp_set_enable(&lamp, 0, true);
	lamp_set_duty(&lamp, 0, 333333);
	for (int64_t us = 1; us <= 1000000; us++) {
		lamp_advance(&lamp, us);
	}
	/* 1 s at 333333 ppm */
	zassert_equal(lamp.light_us, 333333);
	zassert_equal(lamp.light_rest_ppm_us, 0);
}

ZTEST(models, test_lamp_totals_start_again)
{
	lamp_init(&lamp, 30000);
	lamp_set_enable(&lamp, 0, true);
	lamp_set_duty(&lamp, 0, 1000000);
	lamp_set_duty(&lamp, 1 * S, 200000);
	lamp_reset_totals(&lamp, 2 * S);
	zassert_equal(lamp.peak_ppm, 200000);
	lamp_advance(&lamp, 3 * S);
	/* 6 W for 1 s */
	zassert_within(lamp_energy_mj(&lamp), 6000.0, 1e-6);
	zassert_equal(lamp.changes, 2);
}

ZTEST(models, test_lamp_log_keeps_the_last_changes)
{
	const uint64_t changes = LAMP_LOG_SIZE + 100u;

	lamp_init(&lamp, 30000);
	lamp_set_enable(&lamp, 0, true);
	for (uint64_t n = 0; n < changes; n++) {
		lamp_set_duty(&lamp, (int64_t)n * 10, n % 2 == 0 ? 700000 : 0);
	}
	zassert_equal(lamp.changes, changes);
	zassert_equal(lamp_oldest_change(&lamp), 100);
	zassert_is_null(lamp_change_at(&lamp, 99));
	zassert_is_null(lamp_change_at(&lamp, changes));
	zassert_equal(lamp_change_at(&lamp, 100)->time_us, 1000);
	zassert_equal(lamp_change_at(&lamp, 100)->level_ppm, 700000);
	zassert_equal(lamp_change_at(&lamp, 16001)->time_us, 160010);
	zassert_equal(lamp_change_at(&lamp, 16001)->level_ppm, 0);
}

/* --- thermistor and its converter --- */

static const struct ntc_input_params ntc_params = {
	.pullup_ohms = 10000.0,
	.r25_ohms = 10000.0,
	.beta_k = 3435.0,
	.noise_lsb = 0.5,
	.noisy_noise_lsb = 400.0,
};

ZTEST(models, test_ntc_divider)
{
	/* R = 1e4 exp(3435 (1/T - 1/298.15)), ratio = R / (R + 1e4) */
	static const struct {
		double temp_c;
		double ratio;
	} points[] = {
		{-40.0, 0.961281808}, {0.0, 0.741630711},  {25.0, 0.5},
		{65.0, 0.203780309},  {85.0, 0.126740293}, {125.0, 0.052468623},
	};
	struct ntc_input ntc;

	ntc_input_init(&ntc, &ntc_params, 1);
	for (size_t i = 0; i < ARRAY_SIZE(points); i++) {
		zassert_within(ntc_input_ratio(&ntc, points[i].temp_c), points[i].ratio, 1e-8);
	}
}

ZTEST(models, test_converter_has_half_a_code_of_noise)
{
	const int count = 20000;
	struct ntc_input ntc;
	double sum = 0.0;
	double squares = 0.0;

	ntc_input_init(&ntc, &ntc_params, 3);
	for (int i = 0; i < count; i++) {
		const double error = ntc_input_convert(&ntc, 0.25, 12) - 0.25 * 4095;

		sum += error;
		squares += error * error;
	}
	zassert_within(sum / count, 0.0, 0.02);
	/* 0.5² and the 1/12 of rounding */
	zassert_within(squares / count, 0.3333, 0.02);
}

ZTEST(models, test_ntc_faults)
{
	struct ntc_input ntc;
	uint16_t stuck;
	int least = 4095;
	int most = 0;

	ntc_input_init(&ntc, &ntc_params, 3);
	ntc_input_set_fault(&ntc, NTC_FAULT_OPEN);
	zassert_true(ntc_input_convert(&ntc, ntc_input_ratio(&ntc, 25.0), 12) >= 4090);
	ntc_input_set_fault(&ntc, NTC_FAULT_SHORT);
	zassert_true(ntc_input_convert(&ntc, ntc_input_ratio(&ntc, 25.0), 12) <= 5);
	ntc_input_set_fault(&ntc, NTC_FAULT_STUCK);
	stuck = ntc_input_convert(&ntc, ntc_input_ratio(&ntc, 25.0), 12);
	zassert_within((int)stuck, 2047, 5);
	for (int i = 0; i < 100; i++) {
		zassert_equal(ntc_input_convert(&ntc, ntc_input_ratio(&ntc, 80.0), 12), stuck);
	}
	ntc_input_set_fault(&ntc, NTC_FAULT_NOISY);
	for (int i = 0; i < 100; i++) {
		const int code = ntc_input_convert(&ntc, 0.5, 12);

		least = MIN(least, code);
		most = MAX(most, code);
	}
	zassert_true(most - least > 800, "two standard deviations of 400 codes");
}

/* --- lines --- */

ZTEST(models, test_line_level_by_who_drives_it)
{
	struct lines lines = {0};

	zassert_equal(lines_levels(&lines), 0, "nobody drives: low");
	lines.pull_up = 1;
	zassert_equal(lines_levels(&lines), 1);
	lines.driven = 1;
	zassert_equal(lines_levels(&lines), 0, "the world is stronger than a pull");
	lines.output = 1;
	lines.output_level = 1;
	zassert_equal(lines_levels(&lines), 1, "an output is stronger than the world");
	lines_reset(&lines);
	zassert_equal(lines_levels(&lines), 0, "the world still drives low");
	lines.driven_level = 1;
	zassert_equal(lines_levels(&lines), 1);
}

/* --- servo --- */

/* 500 us off 1500 us are 90 degrees; 500 degrees per second. */
ZTEST(models, test_servo_turns_to_its_pulse_at_its_speed)
{
	struct servo servo = {0};

	servo_set_pulse_ns(&servo, 0, 2000000);
	servo_advance(&servo, 100000);
	zassert_within(servo.angle_mdeg, 50000.0, 1e-6);
	servo_advance(&servo, S);
	zassert_within(servo.angle_mdeg, 90000.0, 1e-6);
	servo_set_pulse_ns(&servo, S, 1250000);
	servo_advance(&servo, 2 * S);
	zassert_within(servo.angle_mdeg, -45000.0, 1e-6);
}

ZTEST(models, test_servo_without_pulses_stays_and_has_ends)
{
	struct servo servo = {0};

	servo_set_pulse_ns(&servo, 0, 2500000); /* 180 degrees, beyond its mechanics */
	servo_advance(&servo, S);
	zassert_within(servo.angle_mdeg, 125000.0, 1e-6);
	servo_set_pulse_ns(&servo, S, 1500000);
	servo_set_pulse_ns(&servo, S + 100000, 0);
	servo_advance(&servo, 9 * S);
	zassert_within(servo.angle_mdeg, 75000.0, 1e-6);
}

ZTEST_SUITE(models, NULL, NULL, NULL, NULL, NULL);
