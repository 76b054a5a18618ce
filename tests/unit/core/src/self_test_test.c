/* SPDX-License-Identifier: Apache-2.0 */
#include "core/self_test.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define STEP_US 50000
#define STEPS   40

static struct illuminator light;
static struct illuminator_outbox out;
static struct self_test test;
static int64_t now_us;

static enum illuminator_result give(const struct illuminator_event *event)
{
	return illuminator_step(&light, now_us, event, &out);
}

static void thermal(enum thermal_state state, enum thermal_sensor sensor)
{
	const struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_THERMAL,
		.thermal = {.state = state, .sensor = sensor},
	};

	zassert_equal(give(&event), ILLUMINATOR_ACCEPTED);
}

static void before(void *fixture)
{
	const struct illuminator_config config = {
		.min_period_us = 10000,
		.max_period_us = 10000000,
		.curve = ILLUMINATOR_CURVE_LINEAR,
	};

	now_us = 0;
	illuminator_init(&light, &config);
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK);
	self_test_init(&test);
}

ZTEST_SUITE(core_self_test, NULL, NULL, before, NULL, NULL);

static void begin(uint32_t peak_ppm)
{
	const struct illuminator_event first = self_test_first();

	zassert_equal(self_test_obstacle(&test, &light), SELF_TEST_NONE);
	zassert_equal(give(&first), ILLUMINATOR_ACCEPTED);
	self_test_begin(&test, now_us, peak_ppm);
}

/* Steps at its deadlines up to then. */
static void run_until(int64_t until_us)
{
	struct illuminator_event event;

	for (;;) {
		while (self_test_step(&test, now_us, &light, &event)) {
			zassert_equal(give(&event), ILLUMINATOR_ACCEPTED);
		}
		if (self_test_deadline_us(&test) > until_us) {
			break;
		}
		now_us = self_test_deadline_us(&test);
	}
	now_us = until_us;
}

ZTEST(core_self_test, test_goes_up_and_down_and_passes)
{
	begin(PPM_ONE);
	zassert_true(light.plan.on);
	zassert_equal(light.plan.level_ppm, 0);
	run_until(10 * STEP_US);
	zassert_equal(light.plan.level_ppm, 500000);
	zassert_equal(self_test_percent(&test), 25);
	run_until(20 * STEP_US);
	zassert_equal(light.plan.level_ppm, 1000000);
	run_until(30 * STEP_US);
	zassert_equal(light.plan.level_ppm, 500000);
	run_until(STEPS * STEP_US - 1);
	zassert_equal(light.plan.level_ppm, 50000);
	zassert_equal(test.state, SELF_TEST_RUNNING);
	run_until(STEPS * STEP_US);
	zassert_equal(test.state, SELF_TEST_PASSED);
	zassert_equal(self_test_percent(&test), 100);
	zassert_false(light.plan.on);
	zassert_equal(self_test_deadline_us(&test), TIME_NEVER_US);
}

ZTEST(core_self_test, test_goes_no_higher_than_its_peak)
{
	uint32_t highest = 0;

	begin(300000);
	while (test.state == SELF_TEST_RUNNING) {
		run_until(now_us + STEP_US);
		highest = light.plan.level_ppm > highest ? light.plan.level_ppm : highest;
	}
	zassert_equal(highest, 300000);
}

ZTEST(core_self_test, test_leaves_the_lamp_as_it_was_commanded)
{
	const struct illuminator_event strobe = {
		.kind = ILLUMINATOR_EVENT_CONFIGURE,
		.configure = {ILLUMINATOR_MODE_INTERNAL, 700000, 200000, 100000},
	};
	const struct illuminator_event on = {.kind = ILLUMINATOR_EVENT_ON_OFF, .on_off = true};

	zassert_equal(give(&strobe), ILLUMINATOR_ACCEPTED);
	zassert_equal(give(&on), ILLUMINATOR_ACCEPTED);

	const struct illuminator before_test = light;

	begin(PPM_ONE);
	zassert_equal(light.plan.period_us, 0, "a test does not strobe");
	run_until(STEPS * STEP_US);
	zassert_mem_equal(&light.settings, &before_test.settings, sizeof(light.settings));
	zassert_equal(light.revision, before_test.revision);
	zassert_equal(light.plan.level_ppm, 700000);
	zassert_equal(light.plan.period_us, 200000);
	zassert_equal(light.plan.on_us, 20000);
}

ZTEST(core_self_test, test_follows_the_curve)
{
	const struct illuminator_event curve = {
		.kind = ILLUMINATOR_EVENT_CONFIG,
		.config = {.min_period_us = 10000,
	                   .max_period_us = 10000000,
	                   .curve = ILLUMINATOR_CURVE_PERCEPTUAL},
	};

	zassert_equal(give(&curve), ILLUMINATOR_ACCEPTED);
	begin(PPM_ONE);
	run_until(10 * STEP_US);
	zassert_equal(light.plan.level_ppm, 184187, "CIE 1931: ((50 + 16) / 116)^3");
}

ZTEST(core_self_test, test_any_command_interrupts_and_rules)
{
	const struct illuminator_event commands[] = {
		{.kind = ILLUMINATOR_EVENT_ON_OFF, .on_off = true},
		{.kind = ILLUMINATOR_EVENT_CONFIGURE,
	         .configure = {ILLUMINATOR_MODE_INTERNAL, 400000, 0, PPM_ONE}},
		{.kind = ILLUMINATOR_EVENT_BRIGHTNESS, .brightness_ppm = 123456},
		{.kind = ILLUMINATOR_EVENT_FALLBACK, .fallback = ILLUMINATOR_FALLBACK_OFF},
	};

	for (size_t i = 0; i < ARRAY_SIZE(commands); i++) {
		before(NULL);
		begin(PPM_ONE);
		run_until(5 * STEP_US);
		zassert_equal(give(&commands[i]), ILLUMINATOR_ACCEPTED);
		zassert_equal(light.plan.on, light.settings.enable);
		run_until(now_us);
		zassert_equal(test.state, SELF_TEST_INTERRUPTED, "command %u", (unsigned int)i);
	}
}

ZTEST(core_self_test, test_a_refused_command_interrupts_nothing)
{
	const struct illuminator_event wrong = {.kind = ILLUMINATOR_EVENT_BRIGHTNESS,
	                                        .brightness_ppm = PPM_ONE + 1};

	begin(PPM_ONE);
	zassert_equal(give(&wrong), ILLUMINATOR_DENIED);
	run_until(STEPS * STEP_US);
	zassert_equal(test.state, SELF_TEST_PASSED);
}

ZTEST(core_self_test, test_other_reports_and_parameters_interrupt_nothing)
{
	const struct illuminator_event config = {
		.kind = ILLUMINATOR_EVENT_CONFIG,
		.config = {.min_period_us = 20000,
	                   .max_period_us = 10000000,
	                   .curve = ILLUMINATOR_CURVE_LINEAR},
	};

	begin(PPM_ONE);
	run_until(20 * STEP_US);
	thermal(THERMAL_STATE_THROTTLING, THERMAL_SENSOR_OK);
	zassert_equal(give(&config), ILLUMINATOR_ACCEPTED);
	zassert_equal(light.plan.level_ppm, 1000000);
	run_until(STEPS * STEP_US);
	zassert_equal(test.state, SELF_TEST_PASSED);
}

ZTEST(core_self_test, test_heat_ends_it)
{
	begin(PPM_ONE);
	run_until(20 * STEP_US);
	thermal(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_OK);
	zassert_false(light.plan.on, "the lamp is off with the report");
	run_until(now_us);
	zassert_equal(test.state, SELF_TEST_TOO_HOT);
}

ZTEST(core_self_test, test_loss_of_power_ends_it)
{
	const struct illuminator_event cut = {.kind = ILLUMINATOR_EVENT_POWER, .powered = false};

	begin(PPM_ONE);
	zassert_equal(give(&cut), ILLUMINATOR_ACCEPTED);
	zassert_false(light.plan.on);
	run_until(now_us);
	zassert_equal(test.state, SELF_TEST_NO_POWER);
}

ZTEST(core_self_test, test_a_sensor_that_fails_meanwhile_is_found)
{
	begin(PPM_ONE);
	run_until(STEPS * STEP_US - 1);
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_FAILED);
	run_until(now_us);
	zassert_equal(test.state, SELF_TEST_SENSOR_FAILED);
	zassert_false(light.plan.on);
}

ZTEST(core_self_test, test_a_driver_that_fails_meanwhile_is_found)
{
	begin(PPM_ONE);
	run_until(STEP_US);
	self_test_driver(&test, true);
	run_until(now_us);
	zassert_equal(test.state, SELF_TEST_DRIVER_FAILED);
	zassert_false(light.plan.on);
}

ZTEST(core_self_test, test_says_what_stands_against_it)
{
	const struct illuminator_event cut = {.kind = ILLUMINATOR_EVENT_POWER, .powered = false};
	const struct illuminator_event back = {.kind = ILLUMINATOR_EVENT_POWER, .powered = true};

	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_WAITING);
	zassert_equal(self_test_obstacle(&test, &light), SELF_TEST_SENSOR_FAILED);
	thermal(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_OK);
	zassert_equal(self_test_obstacle(&test, &light), SELF_TEST_TOO_HOT);
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK);
	zassert_equal(give(&cut), ILLUMINATOR_ACCEPTED);
	zassert_equal(self_test_obstacle(&test, &light), SELF_TEST_NO_POWER);
	zassert_equal(give(&back), ILLUMINATOR_ACCEPTED);
	self_test_driver(&test, true);
	zassert_equal(self_test_obstacle(&test, &light), SELF_TEST_DRIVER_FAILED);
	self_test_driver(&test, false);
	begin(1);
	zassert_equal(self_test_obstacle(&test, &light), SELF_TEST_RUNNING);
}

ZTEST(core_self_test, test_cancelled_the_lamp_is_back_at_once)
{
	struct illuminator_event event;

	begin(PPM_ONE);
	run_until(20 * STEP_US);
	event = self_test_cancel(&test);
	zassert_equal(give(&event), ILLUMINATOR_ACCEPTED);
	zassert_false(light.plan.on);
	zassert_equal(test.state, SELF_TEST_CANCELLED);
	zassert_false(self_test_step(&test, now_us, &light, &event));
}

ZTEST(core_self_test, test_runs_again_after_any_end)
{
	for (int i = 0; i < 3; i++) {
		begin(PPM_ONE);
		run_until(now_us + STEPS * STEP_US);
		zassert_equal(test.state, SELF_TEST_PASSED);
	}
}

ZTEST(core_self_test, test_a_late_caller_finds_it_done)
{
	struct illuminator_event event;

	begin(PPM_ONE);
	now_us = 100 * STEP_US;
	while (self_test_step(&test, now_us, &light, &event)) {
		zassert_equal(give(&event), ILLUMINATOR_ACCEPTED);
	}
	zassert_equal(test.state, SELF_TEST_PASSED);
	zassert_false(light.plan.on);
}

ZTEST(core_self_test, test_the_illuminator_refuses_the_sweep_when_it_refuses_on)
{
	const struct illuminator_event first = self_test_first();
	const struct illuminator_event too_bright = {
		.kind = ILLUMINATOR_EVENT_TEST,
		.test = {.on = true, .brightness_ppm = PPM_ONE + 1},
	};

	zassert_equal(give(&too_bright), ILLUMINATOR_DENIED);
	thermal(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_OK);
	zassert_equal(give(&first), ILLUMINATOR_FAILED);
	zassert_false(light.test.on);
}

ZTEST(core_self_test, test_asserts_that_none_runs)
{
	begin(PPM_ONE);
	expect_assert();
	self_test_begin(&test, now_us, PPM_ONE);
}

ZTEST(core_self_test, test_asserts_the_peak)
{
	expect_assert();
	self_test_begin(&test, now_us, PPM_ONE + 1);
}

ZTEST(core_self_test, test_asserts_that_there_is_one_to_cancel)
{
	expect_assert();
	(void)self_test_cancel(&test);
}
