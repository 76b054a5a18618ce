/* SPDX-License-Identifier: Apache-2.0 */
/* The sensor machine: what counts as a failure, what it limits, and how it heals. */
#include "core/thermal.h"

#include <zephyr/ztest.h>

#include "core/limits.h"
#include "thermal_fixture.h"

static struct thermal_rig rig;

static void before(void *fixture)
{
	rig_start(&rig);
	rig_temp(&rig, 25000);
}

ZTEST_SUITE(core_thermal_sensor, NULL, NULL, before, NULL, NULL);

static void assert_failed(enum thermal_fault fault)
{
	const struct thermal_report *report = &rig.thermal.report;

	zassert_equal(report->sensor, THERMAL_SENSOR_FAILED);
	zassert_equal(report->fault, fault);
	zassert_equal(report->flags, THERMAL_FLAG_THERMISTOR);
	zassert_equal(report->limit_ppm, 100000);
	zassert_false(report->temp_valid);
	zassert_true(thermal_allows_light(report));
}

/* Failed, and no light: before the first sample in range. */
static void assert_no_light(enum thermal_fault fault)
{
	const struct thermal_report *report = &rig.thermal.report;

	zassert_equal(report->sensor, THERMAL_SENSOR_FAILED);
	zassert_equal(report->fault, fault);
	zassert_equal(report->flags, THERMAL_FLAG_THERMISTOR);
	zassert_equal(report->limit_ppm, 0);
	zassert_false(thermal_allows_light(report));
}

/* The same, and it is heat. */
static void assert_heat(enum thermal_fault fault)
{
	const struct thermal_report *report = &rig.thermal.report;

	zassert_equal(report->sensor, THERMAL_SENSOR_FAILED);
	zassert_equal(report->fault, fault);
	zassert_equal(report->state, THERMAL_STATE_SHUTDOWN);
	zassert_equal(report->flags, THERMAL_FLAG_THERMISTOR | THERMAL_FLAG_SHUTDOWN);
	zassert_equal(report->limit_ppm, 0);
	zassert_false(thermal_allows_light(report));
}

static void assert_failed_while(uint32_t flags, enum thermal_fault fault)
{
	const struct thermal_report *report = &rig.thermal.report;

	zassert_equal(report->sensor, THERMAL_SENSOR_FAILED);
	zassert_equal(report->fault, fault);
	zassert_equal(report->flags, flags | THERMAL_FLAG_THERMISTOR);
	zassert_equal(report->limit_ppm, 100000);
}

static void assert_ok_but_waiting(void)
{
	zassert_equal(rig.thermal.report.sensor, THERMAL_SENSOR_WAITING);
	zassert_equal(rig.thermal.report.limit_ppm, 0);
	zassert_true(thermal_allows_light(&rig.thermal.report));
}

/* By 0.5 degC a sample, which is 5 degC/s. */
static void warm_up(int32_t from_mdegc, int32_t to_mdegc)
{
	rig_start(&rig);
	for (int32_t mdegc = from_mdegc; mdegc <= to_mdegc; mdegc += 500) {
		rig_temp(&rig, mdegc);
	}
}

static void assert_ok(void)
{
	zassert_equal(rig.thermal.report.sensor, THERMAL_SENSOR_OK);
	zassert_equal(rig.thermal.report.fault, THERMAL_FAULT_NONE);
	zassert_equal(rig.thermal.report.flags, 0);
}

ZTEST(core_thermal_sensor, test_open_limits_with_the_very_sample)
{
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	assert_failed(THERMAL_FAULT_OPEN);
}

/* An NTC's resistance falls as it heats: a short is its hot end. */
ZTEST(core_thermal_sensor, test_short_is_heat_with_the_very_sample)
{
	rig_sample(&rig, THERMAL_SAMPLE_SHORT, 0);
	assert_heat(THERMAL_FAULT_SHORT);
	zassert_equal(rig.thermal.stats.shutdowns, 1);
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	assert_heat(THERMAL_FAULT_OPEN);
	for (int i = 0; i < 3; i++) {
		zassert_equal(rig_temp(&rig, 25000).limit_ppm, i < 2 ? 0 : 50000);
	}
	assert_ok();
}

ZTEST(core_thermal_sensor, test_first_sample_ever_may_be_the_failure)
{
	rig_start(&rig);
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	assert_no_light(THERMAL_FAULT_OPEN);
	rig_start(&rig);
	rig_sample(&rig, THERMAL_SAMPLE_SHORT, 0);
	assert_heat(THERMAL_FAULT_SHORT);
}

/* 0.5 degC below what a shutdown would be, and 0.5 above, by the trend of 5 degC/s. */
ZTEST(core_thermal_sensor, test_sensor_that_went_hotter_until_it_failed_is_heat)
{
	warm_up(25000, 49500);
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	assert_heat(THERMAL_FAULT_OPEN);
	warm_up(25000, 49500);
	rig.now_us += 600000;
	thermal_step(&rig.thermal, rig.now_us, NULL);
	assert_heat(THERMAL_FAULT_MISSING);
	warm_up(5000, 29500);
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	assert_failed(THERMAL_FAULT_OPEN);
}

ZTEST(core_thermal_sensor, test_hot_sensor_that_fails_is_no_heat_when_it_did_not_get_hotter)
{
	warm_up(60000, 84500);
	for (int i = 0; i < 200; i++) {
		rig_temp(&rig, 84500);
	}
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	assert_failed_while(THERMAL_FLAG_THROTTLING, THERMAL_FAULT_OPEN);
}

ZTEST(core_thermal_sensor, test_trend_begins_anew_after_a_failure)
{
	warm_up(25000, 40000);
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	for (int i = 0; i < 3; i++) {
		rig_temp(&rig, 40000);
	}
	assert_ok();
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	assert_failed(THERMAL_FAULT_OPEN);
}

ZTEST(core_thermal_sensor, test_implausible_heat_is_heat)
{
	rig_temp(&rig, 89999);
	assert_failed(THERMAL_FAULT_RATE);
	rig_start(&rig);
	rig_temp(&rig, 25000);
	rig_temp(&rig, 90000);
	assert_heat(THERMAL_FAULT_RATE);
}

ZTEST(core_thermal_sensor, test_heat_of_a_failed_sensor_may_allow_a_level)
{
	struct thermal_config config = thermal_defaults;

	config.hot_ppm = 30000;
	thermal_configure(&rig.thermal, &config);
	zassert_equal(rig_sample(&rig, THERMAL_SAMPLE_SHORT, 0).limit_ppm, 30000);
	zassert_equal(rig.thermal.report.flags, THERMAL_FLAG_THERMISTOR);
	zassert_true(thermal_allows_light(&rig.thermal.report));
	zassert_equal(rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0).limit_ppm, 30000, "still hot");
	for (int i = 0; i < 12; i++) {
		rig_temp(&rig, 25000);
	}
	assert_ok();
	zassert_equal(rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0).limit_ppm, 100000, "healed since");
	config.hot_ppm = 1000000;
	thermal_configure(&rig.thermal, &config);
	zassert_equal(rig_sample(&rig, THERMAL_SAMPLE_SHORT, 0).limit_ppm, 100000, "at most safe");
	/* and never before the first sample */
	rig_start(&rig);
	thermal_configure(&rig.thermal, &config);
	rig_sample(&rig, THERMAL_SAMPLE_SHORT, 0);
	assert_no_light(THERMAL_FAULT_SHORT);
}

ZTEST(core_thermal_sensor, test_without_a_first_sample_the_safe_level_may_be_allowed)
{
	struct thermal_config config = thermal_defaults;

	config.first_us = 2000000;
	rig_start(&rig);
	thermal_configure(&rig.thermal, &config);
	thermal_step(&rig.thermal, rig.now_us + 1999999, NULL);
	assert_no_light(THERMAL_FAULT_MISSING);
	thermal_step(&rig.thermal, rig.now_us + 2000000, NULL);
	assert_failed(THERMAL_FAULT_MISSING);
	rig_start(&rig);
	thermal_configure(&rig.thermal, &config);
	for (int i = 0; i < 19; i++) {
		rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
		assert_no_light(THERMAL_FAULT_OPEN);
	}
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	assert_failed(THERMAL_FAULT_OPEN);
	rig_sample(&rig, THERMAL_SAMPLE_SHORT, 0);
	assert_heat(THERMAL_FAULT_SHORT);
}

/* Late, and then it takes good samples in a row, as any sensor that has failed. */
ZTEST(core_thermal_sensor, test_late_first_sample_heals)
{
	rig_start(&rig);
	rig.now_us += 600000;
	thermal_step(&rig.thermal, rig.now_us, NULL);
	assert_no_light(THERMAL_FAULT_MISSING);
	zassert_equal(rig_temp(&rig, 25000).limit_ppm, 0);
	zassert_equal(rig_temp(&rig, 25000).limit_ppm, 0);
	zassert_equal(rig_temp(&rig, 25000).limit_ppm, 50000);
	assert_ok();
}

ZTEST(core_thermal_sensor, test_temperature_out_of_the_physical_range)
{
	rig_start(&rig);
	rig_temp(&rig, -50000);
	assert_ok();
	rig_start(&rig);
	rig_temp(&rig, -50001);
	assert_no_light(THERMAL_FAULT_RANGE);
	rig_start(&rig);
	rig_temp(&rig, INT32_MIN);
	assert_no_light(THERMAL_FAULT_RANGE);
	rig_start(&rig);
	rig_temp(&rig, -50000);
	rig_temp(&rig, -50001);
	assert_failed(THERMAL_FAULT_RANGE);
	/* the hot end is heat, also as the first sample: a reset amid a fire */
	rig_start(&rig);
	rig_temp(&rig, 150001);
	assert_heat(THERMAL_FAULT_RANGE);
	rig_start(&rig);
	rig_temp(&rig, INT32_MAX);
	assert_heat(THERMAL_FAULT_RANGE);
}

/* 20 °C/s for 100 ms is 2 °C, and 1 °C of noise. */
ZTEST(core_thermal_sensor, test_jump_is_implausible)
{
	rig_temp(&rig, 28000);
	assert_ok();
	rig_temp(&rig, 25000);
	assert_ok();
	rig_temp(&rig, 28001);
	assert_failed(THERMAL_FAULT_RATE);
	rig_start(&rig);
	rig_temp(&rig, 25000);
	rig_temp(&rig, 21999);
	assert_failed(THERMAL_FAULT_RATE);
}

ZTEST(core_thermal_sensor, test_jump_is_measured_by_the_time_it_took)
{
	rig.now_us += 400000;
	rig_temp(&rig, 36000); /* 500 ms: 10 °C + 1 °C */
	assert_ok();
}

ZTEST(core_thermal_sensor, test_code_that_stands_still_while_lit_is_stuck)
{
	rig.lit = true;
	rig_temp(&rig, 25000);
	for (int i = 0; i < 9; i++) {
		rig_sample(&rig, THERMAL_SAMPLE_OK, 25000);
		assert_ok();
	}
	rig_sample(&rig, THERMAL_SAMPLE_OK, 25000); /* 1 s since it changed */
	assert_failed(THERMAL_FAULT_STUCK);
}

ZTEST(core_thermal_sensor, test_code_may_stand_still_while_dark)
{
	for (int i = 0; i < 1000; i++) {
		rig_sample(&rig, THERMAL_SAMPLE_OK, 25000);
	}
	assert_ok();
	rig.lit = true;
	for (int i = 0; i < 9; i++) {
		rig_sample(&rig, THERMAL_SAMPLE_OK, 25000);
	}
	assert_ok();
	rig_sample(&rig, THERMAL_SAMPLE_OK, 25000);
	assert_failed(THERMAL_FAULT_STUCK);
}

ZTEST(core_thermal_sensor, test_stuck_does_not_heal_by_darkness)
{
	rig.lit = true;
	for (int i = 0; i < 11; i++) {
		rig_sample(&rig, THERMAL_SAMPLE_OK, 25000);
	}
	assert_failed(THERMAL_FAULT_STUCK);
	rig.lit = false;
	for (int i = 0; i < 100; i++) {
		rig_sample(&rig, THERMAL_SAMPLE_OK, 25000);
		assert_failed(THERMAL_FAULT_STUCK);
	}
	for (int i = 0; i < 3; i++) {
		rig_temp(&rig, 25000);
	}
	assert_ok();
}

ZTEST(core_thermal_sensor, test_missing_samples_are_a_failure)
{
	const int64_t last_us = rig.now_us;

	thermal_step(&rig.thermal, last_us + 500000, NULL);
	assert_ok();
	thermal_step(&rig.thermal, last_us + 500001, NULL);
	assert_failed(THERMAL_FAULT_MISSING);
}

ZTEST(core_thermal_sensor, test_no_sample_ever_is_a_failure)
{
	rig_start(&rig);
	thermal_step(&rig.thermal, 1500000, NULL);
	assert_ok_but_waiting();
	thermal_step(&rig.thermal, 1500001, NULL);
	assert_no_light(THERMAL_FAULT_MISSING);
}

ZTEST(core_thermal_sensor, test_sample_after_a_gap_is_the_first_of_those_that_heal)
{
	rig.now_us += 500000;
	rig_temp(&rig, 25000);
	assert_failed(THERMAL_FAULT_MISSING);
	rig_temp(&rig, 25000);
	assert_failed(THERMAL_FAULT_MISSING);
	rig_temp(&rig, 25000);
	assert_ok();
}

ZTEST(core_thermal_sensor, test_heals_only_by_good_samples_in_a_row)
{
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	for (int i = 0; i < 20; i++) {
		rig_temp(&rig, 25000);
		rig_temp(&rig, 25000);
		assert_failed(i == 0 ? THERMAL_FAULT_OPEN : THERMAL_FAULT_RANGE);
		rig_temp(&rig, -50001);
	}
	rig_temp(&rig, 25000);
	rig_temp(&rig, 25000);
	rig_temp(&rig, 25000);
	assert_ok();
	zassert_equal(rig.thermal.stats.sensor_failures, 1);
	zassert_equal(rig.thermal.stats.bad_samples, 21);
}

ZTEST(core_thermal_sensor, test_limit_rises_slowly_after_healing)
{
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	rig_temp(&rig, 25000);
	rig_temp(&rig, 25000);
	zassert_equal(rig_temp(&rig, 25000).limit_ppm, 150000); /* 50 000 ppm per sample */
}

ZTEST(core_thermal_sensor, test_failure_never_makes_the_lamp_brighter)
{
	struct thermal_config config = thermal_defaults;

	config.floor_ppm = 0;
	thermal_configure(&rig.thermal, &config);
	rig_go(&rig, 89000);
	for (int i = 0; i < 200; i++) {
		rig_temp(&rig, 89000);
	}
	zassert_equal(rig.thermal.report.limit_ppm, 50000);
	zassert_equal(rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0).limit_ppm, 50000);
	zassert_equal(rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0).limit_ppm, 50000);
}

ZTEST(core_thermal_sensor, test_failure_in_shutdown_stays_dark_until_cool_and_healed)
{
	rig_go(&rig, 90000);
	const struct thermal_report report = rig_sample(&rig, THERMAL_SAMPLE_SHORT, 0);

	zassert_equal(report.limit_ppm, 0);
	zassert_equal(report.flags, THERMAL_FLAG_SHUTDOWN | THERMAL_FLAG_THERMISTOR);
	rig.now_us += 400000; /* time to cool, plausibly: 0.5 s, 11 °C */
	zassert_equal(rig_temp(&rig, 80000).limit_ppm, 0);
	zassert_equal(rig_go(&rig, 60000).limit_ppm, 0);
	zassert_equal(rig.thermal.report.flags, THERMAL_FLAG_SHUTDOWN);
	zassert_equal(rig_temp(&rig, 59000).limit_ppm, 50000);
}

ZTEST(core_thermal_sensor, test_heat_is_believed_even_while_healing)
{
	struct thermal_config config = thermal_defaults;

	config.good_samples = 1000;
	thermal_configure(&rig.thermal, &config);
	rig_sample(&rig, THERMAL_SAMPLE_OPEN, 0);
	const struct thermal_report report = rig_go(&rig, 90000);

	zassert_equal(report.sensor, THERMAL_SENSOR_FAILED);
	zassert_equal(report.state, THERMAL_STATE_SHUTDOWN);
	zassert_equal(report.limit_ppm, 0);
	zassert_equal(rig_go(&rig, 40000).state, THERMAL_STATE_SHUTDOWN, "cold is not");
}

ZTEST(core_thermal_sensor, test_gap_of_years_overflows_nothing)
{
	rig.now_us += INT64_C(31557600) * 1000000 * 100;
	rig_temp(&rig, -49000);
	assert_failed(THERMAL_FAULT_MISSING);
}
