/* SPDX-License-Identifier: Apache-2.0 */
/* The heat machine and the limit. The sensor's faults are in thermal_sensor_test.c. */
#include "core/thermal.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "assert_hook.h"
#include "core/limits.h"
#include "thermal_fixture.h"

static struct thermal_rig rig;

static void before(void *fixture)
{
	rig_start(&rig);
}

ZTEST_SUITE(core_thermal, NULL, NULL, before, NULL, NULL);

ZTEST(core_thermal, test_before_the_first_sample_there_is_no_light)
{
	zassert_equal(rig.thermal.report.limit_ppm, 0);
	zassert_equal(rig.thermal.report.flags, 0);
	zassert_false(rig.thermal.report.temp_valid);
	zassert_true(thermal_allows_light(&rig.thermal.report), "it may be switched on");
}

ZTEST(core_thermal, test_first_good_sample_sets_the_limit_outright)
{
	const struct thermal_report report = rig_temp(&rig, 25000);

	zassert_equal(report.limit_ppm, 1000000);
	zassert_equal(report.sensor, THERMAL_SENSOR_OK);
	zassert_true(report.temp_valid);
	zassert_equal(report.temp_mdegc, 25000);
}

ZTEST(core_thermal, test_first_sample_that_is_too_hot_shuts_down)
{
	const struct thermal_report report = rig_temp(&rig, 90000);

	zassert_equal(report.state, THERMAL_STATE_SHUTDOWN);
	zassert_equal(report.limit_ppm, 0);
	zassert_equal(report.flags, THERMAL_FLAG_SHUTDOWN);
}

/* From 1 at 70 °C to 0.2 just below 90 °C: 0.04 per degree. */
ZTEST(core_thermal, test_derating_is_linear_and_applies_at_once)
{
	rig_temp(&rig, 69000);
	zassert_equal(rig_go(&rig, 70000).limit_ppm, 1000000);
	zassert_equal(rig_go(&rig, 71000).limit_ppm, 960000);
	zassert_equal(rig_go(&rig, 75000).limit_ppm, 800000);
	zassert_equal(rig_go(&rig, 80000).limit_ppm, 600000);
	zassert_equal(rig_go(&rig, 89999).limit_ppm, 200040);
	zassert_equal(rig_go(&rig, 90000).limit_ppm, 0);
}

ZTEST(core_thermal, test_limit_is_rounded_down)
{
	rig_temp(&rig, 70000);
	/* 1 m°C above: 1 000 000 - 40 = 999 960; and of 3 m°C with a span of 7 m°C, never up. */
	zassert_equal(rig_temp(&rig, 70001).limit_ppm, 999960);
	struct thermal_config config = thermal_defaults;

	config.shutdown_mdegc = 70007;
	config.floor_ppm = 0;
	thermal_configure(&rig.thermal, &config);
	zassert_equal(rig_temp(&rig, 70003).limit_ppm, 571428); /* 4/7 = 0.5714285… */
}

ZTEST(core_thermal, test_throttling_begins_at_its_threshold_and_ends_below_the_hysteresis)
{
	rig_temp(&rig, 69999);
	zassert_equal(rig.thermal.report.state, THERMAL_STATE_NORMAL);
	zassert_equal(rig_temp(&rig, 70000).state, THERMAL_STATE_THROTTLING);
	zassert_equal(rig.thermal.report.flags, THERMAL_FLAG_THROTTLING);
	zassert_equal(rig_temp(&rig, 68000).state, THERMAL_STATE_THROTTLING);
	zassert_equal(rig_temp(&rig, 67999).state, THERMAL_STATE_NORMAL);
	zassert_equal(rig_temp(&rig, 69999).state, THERMAL_STATE_NORMAL);
}

ZTEST(core_thermal, test_noise_around_a_threshold_does_not_chatter)
{
	uint32_t changes = 0;
	enum thermal_state last = THERMAL_STATE_NORMAL;

	rig_temp(&rig, 69500);
	for (int i = 0; i < 1000; i++) {
		/* ±0.9 °C: less than half the hysteresis. */
		const struct thermal_report report =
			rig_temp(&rig, 70000 + ((i * 7919) % 1801) - 900);

		changes += (report.state != last) ? 1 : 0;
		last = report.state;
	}
	zassert_equal(changes, 1);
}

ZTEST(core_thermal, test_shutdown_is_latched_until_below_recover)
{
	rig_temp(&rig, 89000);
	zassert_equal(rig_go(&rig, 90000).state, THERMAL_STATE_SHUTDOWN);
	zassert_equal(rig_go(&rig, 60000).state, THERMAL_STATE_SHUTDOWN);
	zassert_equal(rig.thermal.report.limit_ppm, 0);
	const struct thermal_report report = rig_temp(&rig, 59999);

	zassert_equal(report.state, THERMAL_STATE_NORMAL);
	zassert_equal(report.flags, 0);
	zassert_equal(rig.thermal.stats.shutdowns, 1);
}

/* 500 000 ppm/s is 50 000 ppm per sample of 100 ms. */
ZTEST(core_thermal, test_limit_rises_with_the_slew_and_falls_at_once)
{
	rig_temp(&rig, 89000);
	rig_go(&rig, 90000);
	rig_go(&rig, 60000);
	zassert_equal(rig_temp(&rig, 59000).limit_ppm, 50000);
	zassert_equal(rig_temp(&rig, 59000).limit_ppm, 100000);
	for (int i = 0; i < 17; i++) {
		rig_temp(&rig, 59000);
	}
	zassert_equal(rig.thermal.report.limit_ppm, 950000);
	zassert_equal(rig_temp(&rig, 59000).limit_ppm, 1000000);
	zassert_equal(rig_temp(&rig, 59000).limit_ppm, 1000000);
	rig_go(&rig, 71000);
	zassert_equal(rig.thermal.report.limit_ppm, 960000);
}

ZTEST(core_thermal, test_slow_slew_loses_nothing_to_rounding)
{
	struct thermal_config config = thermal_defaults;

	config.slew_ppm_per_s = 3; /* 0.3 ppm per sample */
	thermal_configure(&rig.thermal, &config);
	rig_temp(&rig, 89000);
	rig_go(&rig, 90000);
	rig_go(&rig, 60000);
	for (int i = 0; i < 1000; i++) {
		rig_temp(&rig, 59000);
	}
	zassert_equal(rig.thermal.report.limit_ppm, 300);
}

ZTEST(core_thermal, test_new_thresholds_apply_with_the_next_sample)
{
	struct thermal_config config = thermal_defaults;

	rig_temp(&rig, 65000);
	config.recover_mdegc = 40000;
	config.throttle_mdegc = 50000;
	config.shutdown_mdegc = 60000;
	thermal_configure(&rig.thermal, &config);
	zassert_equal(rig_temp(&rig, 65000).limit_ppm, 0);
}

ZTEST(core_thermal, test_time_going_back_is_a_bug)
{
	rig_temp(&rig, 25000);
	expect_assert();
	thermal_step(&rig.thermal, rig.now_us - 1, NULL);
	zassert_unreachable("no assertion");
}

ZTEST(core_thermal, test_thresholds_out_of_order_are_a_bug)
{
	struct thermal_config config = thermal_defaults;

	config.recover_mdegc = config.throttle_mdegc;
	expect_assert();
	thermal_configure(&rig.thermal, &config);
	zassert_unreachable("no assertion");
}

ZTEST(core_thermal, test_states_and_faults_have_words)
{
	zassert_equal(strcmp(thermal_state_name(THERMAL_STATE_SHUTDOWN), "shutdown"), 0);
	for (enum thermal_fault fault = THERMAL_FAULT_NONE; fault <= THERMAL_FAULT_MISSING;
	     fault++) {
		zassert_true(strlen(thermal_fault_name(fault)) > 0);
	}
}
