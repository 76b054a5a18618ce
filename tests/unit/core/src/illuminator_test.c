/* SPDX-License-Identifier: Apache-2.0 */
#include "core/illuminator.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "assert_hook.h"

static struct illuminator light;
static struct illuminator_outbox out;

/* How many things are to be done and told. */
static int news(void)
{
	return out.light + out.status + __builtin_popcount(out.notices);
}

static uint8_t bit(enum illuminator_notice_kind kind)
{
	return (uint8_t)(1u << kind);
}

static void before(void *fixture)
{
	const struct illuminator_config config = {
		.min_period_us = 10000,
		.max_period_us = 10000000,
		.curve = ILLUMINATOR_CURVE_LINEAR,
		.beacon = {.period_us = 1000000, .duty_ppm = 100000, .brightness_ppm = 900000},
	};

	illuminator_init(&light, &config);
	memset(&out, 0xA5, sizeof(out));
}

ZTEST_SUITE(core_illuminator, NULL, NULL, before, NULL, NULL);

static enum illuminator_result step(const struct illuminator_event *event)
{
	return illuminator_step(&light, 1000, event, &out);
}

static enum illuminator_result on_off(bool on)
{
	return step(&(struct illuminator_event){.kind = ILLUMINATOR_EVENT_ON_OFF, .on_off = on});
}

static enum illuminator_result brightness(uint32_t ppm)
{
	return step(&(struct illuminator_event){.kind = ILLUMINATOR_EVENT_BRIGHTNESS,
	                                        .brightness_ppm = ppm});
}

static enum illuminator_result configure(uint32_t mode, uint32_t ppm, uint32_t period_us,
                                         uint32_t duty_ppm)
{
	return step(&(struct illuminator_event){
		.kind = ILLUMINATOR_EVENT_CONFIGURE,
		.configure = {mode, ppm, period_us, duty_ppm},
	});
}

static void thermal(enum thermal_state state, enum thermal_sensor sensor, enum thermal_fault fault,
                    uint32_t flags)
{
	const struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_THERMAL,
		.thermal = {.state = state, .sensor = sensor, .fault = fault, .flags = flags},
	};

	zassert_equal(step(&event), ILLUMINATOR_ACCEPTED);
}

static void shut_down(void)
{
	thermal(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE,
	        THERMAL_FLAG_SHUTDOWN);
}

ZTEST(core_illuminator, test_starts_dark_and_internal)
{
	zassert_false(light.settings.enable);
	zassert_equal(light.settings.mode, ILLUMINATOR_MODE_INTERNAL);
	zassert_false(light.plan.on);
	zassert_equal(light.revision, 0);
	zassert_equal(illuminator_error_flags(&light), 0);
}

ZTEST(core_illuminator, test_on_lights_and_tells)
{
	zassert_equal(on_off(true), ILLUMINATOR_ACCEPTED);
	zassert_equal(news(), 2);
	zassert_true(out.light);
	zassert_true(light.plan.on);
	zassert_equal(light.plan.level_ppm, 1000000);
	zassert_equal(light.plan.period_us, 0);
	zassert_true(out.status);
	zassert_true(out.settings);
	zassert_equal(light.revision, 1);
	zassert_equal(light.changed_us, 1000);
}

ZTEST(core_illuminator, test_repeated_command_is_accepted_and_done_once)
{
	on_off(true);
	zassert_equal(on_off(true), ILLUMINATOR_ACCEPTED);
	zassert_equal(news(), 0);
	zassert_equal(light.revision, 1);
	zassert_equal(configure(1, 500000, 100000, 500000), ILLUMINATOR_ACCEPTED);
	zassert_equal(configure(1, 500000, 100000, 500000), ILLUMINATOR_ACCEPTED);
	zassert_equal(news(), 0);
	zassert_equal(light.revision, 2);
	zassert_equal(light.stats.accepted, 4);
}

ZTEST(core_illuminator, test_off_is_dark)
{
	on_off(true);
	zassert_equal(on_off(false), ILLUMINATOR_ACCEPTED);
	zassert_false(light.plan.on);
	zassert_equal(light.plan.level_ppm, 0);
}

ZTEST(core_illuminator, test_configure_carries_the_whole_plan)
{
	on_off(true);
	zassert_equal(configure(2, 250000, 200000, 100000), ILLUMINATOR_ACCEPTED);
	zassert_equal(light.plan.level_ppm, 250000);
	zassert_equal(light.plan.period_us, 200000);
	zassert_equal(light.plan.on_us, 20000); /* 10 % of 200 ms */
	zassert_true(light.plan.external_sync);
	zassert_true(light.settings.enable, "406 leaves enable alone");
}

ZTEST(core_illuminator, test_configure_while_off_changes_settings_and_stays_dark)
{
	zassert_equal(configure(1, 250000, 200000, 100000), ILLUMINATOR_ACCEPTED);
	zassert_equal(news(), 1);
	zassert_true(out.status);
	zassert_false(light.plan.on);
	zassert_equal(light.settings.strobe_period_us, 200000);
}

/* MAVLink reference, 406: each parameter's range; outside: DENIED and nothing changes. */
ZTEST(core_illuminator, test_configure_is_all_or_nothing)
{
	static const struct illuminator_configure wrong[] = {
		{0, 500000, 100000, 500000},
		{3, 500000, 100000, 500000},
		{UINT32_MAX, 500000, 100000, 500000},
		{1, 1000001, 100000, 500000},
		{1, UINT32_MAX, 100000, 500000},
		{1, 500000, 1, 500000},
		{1, 500000, 9999, 500000},
		{1, 500000, 10000001, 500000},
		{1, 500000, 100000, 1000001},
	};
	on_off(true);
	const struct illuminator kept = light;

	for (size_t i = 0; i < ARRAY_SIZE(wrong); i++) {
		zassert_equal(configure(wrong[i].mode, wrong[i].brightness_ppm,
		                        wrong[i].strobe_period_us, wrong[i].duty_ppm),
		              ILLUMINATOR_DENIED, "row %zu", i);
		zassert_equal(news(), 0);
		zassert_mem_equal(&light.settings, &kept.settings, sizeof(kept.settings));
		zassert_mem_equal(&light.plan, &kept.plan, sizeof(kept.plan));
	}
	zassert_equal(light.revision, kept.revision);
	zassert_equal(light.stats.denied, ARRAY_SIZE(wrong));
}

ZTEST(core_illuminator, test_ends_of_each_range_are_accepted)
{
	zassert_equal(configure(1, 0, 0, 0), ILLUMINATOR_ACCEPTED);
	zassert_equal(configure(2, 1000000, 10000, 1000000), ILLUMINATOR_ACCEPTED);
	zassert_equal(configure(2, 1000000, 10000000, 1), ILLUMINATOR_ACCEPTED);
}

/* 406: duty 0 = no strobe, duty 100 % = constantly on, period 0 = no strobe. */
ZTEST(core_illuminator, test_no_strobe_is_steady_light)
{
	static const uint32_t steady[][2] = {{100000, 0}, {100000, 1000000}, {0, 500000}, {0, 0}};

	on_off(true);
	for (size_t i = 0; i < ARRAY_SIZE(steady); i++) {
		zassert_equal(configure(1, 700000, steady[i][0], steady[i][1]),
		              ILLUMINATOR_ACCEPTED);
		zassert_true(light.plan.on);
		zassert_equal(light.plan.period_us, 0);
		zassert_equal(light.plan.on_us, 0);
		zassert_equal(light.settings.duty_ppm, steady[i][1], "kept as commanded");
		zassert_equal(light.settings.strobe_period_us, steady[i][0]);
	}
}

ZTEST(core_illuminator, test_brightness_leaves_the_rest)
{
	on_off(true);
	configure(1, 500000, 100000, 300000);
	zassert_equal(brightness(200000), ILLUMINATOR_ACCEPTED);
	zassert_equal(light.settings.strobe_period_us, 100000);
	zassert_equal(light.plan.on_us, 30000);
	zassert_equal(light.plan.level_ppm, 200000);
	zassert_equal(brightness(1000001), ILLUMINATOR_DENIED);
	zassert_equal(light.plan.level_ppm, 200000);
}

/* MAVLink reference, command protocol: FAILED = valid, but can't be done now. */
ZTEST(core_illuminator, test_on_in_shutdown_fails_and_the_rest_goes_on)
{
	shut_down();
	zassert_equal(on_off(true), ILLUMINATOR_FAILED);
	zassert_equal(news(), 0);
	zassert_false(light.settings.enable);
	zassert_equal(light.revision, 0);
	zassert_equal(configure(1, 100000, 0, 0), ILLUMINATOR_ACCEPTED);
	zassert_equal(on_off(false), ILLUMINATOR_ACCEPTED);
	zassert_equal(light.stats.failed, 1);
}

ZTEST(core_illuminator, test_on_while_lit_fails_in_shutdown_and_stays_commanded)
{
	on_off(true);
	shut_down();
	zassert_true(light.settings.enable, "heat does not change what was commanded");
	zassert_equal(on_off(true), ILLUMINATOR_FAILED);
	zassert_true(light.settings.enable);
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE, 0);
	zassert_equal(on_off(true), ILLUMINATOR_ACCEPTED);
}

ZTEST(core_illuminator, test_throttling_changes_status_but_no_setting)
{
	on_off(true);
	thermal(THERMAL_STATE_THROTTLING, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE,
	        THERMAL_FLAG_THROTTLING);
	zassert_equal(news(), 2);
	zassert_true(out.status);
	zassert_false(out.settings);
	zassert_equal(out.notices, bit(ILLUMINATOR_NOTICE_THROTTLING_BEGINS));
	zassert_equal(illuminator_error_flags(&light), 1); /* ILLUMINATOR_ERROR_FLAGS */
	zassert_equal(light.plan.level_ppm, 1000000);
	zassert_equal(light.revision, 1);
}

/* There is one. */
static enum illuminator_notice_kind last_notice(void)
{
	zassert_equal(__builtin_popcount(out.notices), 1);
	return (enum illuminator_notice_kind)__builtin_ctz(out.notices);
}

ZTEST(core_illuminator, test_each_turn_of_heat_has_its_notice)
{
	thermal(THERMAL_STATE_THROTTLING, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE, 1);
	zassert_equal(last_notice(), ILLUMINATOR_NOTICE_THROTTLING_BEGINS);
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE, 0);
	zassert_equal(last_notice(), ILLUMINATOR_NOTICE_THROTTLING_ENDS);
	thermal(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE, 2);
	zassert_equal(last_notice(), ILLUMINATOR_NOTICE_SHUTDOWN);
	thermal(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE, 2);
	zassert_equal(news(), 0, "nothing new, nothing said");
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE, 0);
	zassert_equal(last_notice(), ILLUMINATOR_NOTICE_RECOVERED);
}

ZTEST(core_illuminator, test_sensor_notices_name_the_fault)
{
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE, 0);
	zassert_equal(news(), 0, "the first sample is no news");
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_FAILED, THERMAL_FAULT_SHORT, 4);
	zassert_equal(last_notice(), ILLUMINATOR_NOTICE_SENSOR_FAILED);
	zassert_equal(light.thermal.fault, THERMAL_FAULT_SHORT);
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_FAILED, THERMAL_FAULT_MISSING, 4);
	zassert_equal(last_notice(), ILLUMINATOR_NOTICE_SENSOR_FAILED);
	zassert_equal(light.thermal.fault, THERMAL_FAULT_MISSING);
	thermal(THERMAL_STATE_NORMAL, THERMAL_SENSOR_OK, THERMAL_FAULT_NONE, 0);
	zassert_equal(last_notice(), ILLUMINATOR_NOTICE_SENSOR_OK);
	zassert_equal(light.thermal.fault, THERMAL_FAULT_NONE);
}

ZTEST(core_illuminator, test_heat_and_sensor_at_once_fit_the_outbox)
{
	thermal(THERMAL_STATE_SHUTDOWN, THERMAL_SENSOR_FAILED, THERMAL_FAULT_OPEN, 6);
	zassert_equal(news(), 3);
	zassert_equal(out.notices,
	              bit(ILLUMINATOR_NOTICE_SHUTDOWN) | bit(ILLUMINATOR_NOTICE_SENSOR_FAILED));
}

ZTEST(core_illuminator, test_new_curve_and_limits_apply_from_then_on)
{
	const struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_CONFIG,
		.config = {.min_period_us = 50000,
	                   .max_period_us = 100000,
	                   .curve = ILLUMINATOR_CURVE_PERCEPTUAL},
	};

	on_off(true);
	configure(1, 500000, 20000, 500000);
	zassert_equal(step(&event), ILLUMINATOR_ACCEPTED);
	zassert_equal(news(), 2);
	zassert_equal(light.plan.level_ppm, 184187); /* Y of L* = 50: (66/116)^3 */
	zassert_equal(light.settings.strobe_period_us, 20000, "what was accepted stays in force");
	zassert_equal(light.revision, 2);
	zassert_equal(configure(1, 500000, 20000, 400000), ILLUMINATOR_DENIED);
}

ZTEST(core_illuminator, test_nearest_period)
{
	static const uint32_t cases[][2] = {{60000000, 16000000}, {16000001, 16000000},
	                                    {16000000, 16000000}, {20000, 20000},
	                                    {19999, 20000},       {0, 0}};
	const struct illuminator_config allowed = {.min_period_us = 20000,
	                                           .max_period_us = 16000000};

	for (size_t i = 0; i < ARRAY_SIZE(cases); i++) {
		zassert_equal(illuminator_nearest_period_us(&allowed, cases[i][0]), cases[i][1]);
	}
}

ZTEST(core_illuminator, test_restore_is_checked_like_a_command)
{
	struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_RESTORE,
		.restore = {true, ILLUMINATOR_MODE_SYNC, 300000, 500000, 250000},
	};

	zassert_equal(step(&event), ILLUMINATOR_ACCEPTED);
	zassert_true(light.plan.on);
	zassert_equal(light.plan.on_us, 125000);
	event.restore.brightness_ppm = 1000001;
	zassert_equal(step(&event), ILLUMINATOR_DENIED);
	zassert_equal(light.settings.brightness_ppm, 300000);
	shut_down();
	event.restore.brightness_ppm = 1;
	zassert_equal(step(&event), ILLUMINATOR_FAILED);
	zassert_equal(light.settings.brightness_ppm, 300000);
}

ZTEST(core_illuminator, test_fallbacks)
{
	struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_FALLBACK,
	                                  .fallback = ILLUMINATOR_FALLBACK_KEEP};

	on_off(true);
	zassert_equal(step(&event), ILLUMINATOR_ACCEPTED);
	zassert_equal(news(), 0);
	event.fallback = ILLUMINATOR_FALLBACK_OFF;
	step(&event);
	zassert_false(light.plan.on);
	event.fallback = ILLUMINATOR_FALLBACK_BEACON;
	step(&event);
	zassert_true(light.plan.on);
	zassert_equal(light.plan.level_ppm, 900000);
	zassert_equal(light.plan.period_us, 1000000);
	zassert_equal(light.plan.on_us, 100000);
}

ZTEST(core_illuminator, test_beacon_keeps_to_the_strobe_limits)
{
	struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_CONFIG, .config = light.config};

	event.config.min_period_us = 2000000;
	step(&event);
	event.kind = ILLUMINATOR_EVENT_FALLBACK;
	event.fallback = ILLUMINATOR_FALLBACK_BEACON;
	step(&event);
	zassert_equal(light.plan.period_us, 2000000);
	zassert_equal(light.plan.on_us, 200000);
}

ZTEST(core_illuminator, test_program_shows_while_on_without_a_strobe)
{
	struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_CONFIG, .config = light.config};

	on_off(true);
	event.config.program = (struct program){.kind = PROGRAM_SOS, .unit_us = 200000};
	zassert_equal(step(&event), ILLUMINATOR_ACCEPTED);
	zassert_true(out.light);
	zassert_equal(light.plan.program.kind, PROGRAM_SOS);
	zassert_equal(light.plan.level_ppm, 1000000);
	/* a strobe that is commanded counts for more, also one that is lit for all of its period */
	configure(ILLUMINATOR_MODE_INTERNAL, 500000, 1000000, 100000);
	zassert_equal(light.plan.program.kind, PROGRAM_NONE);
	configure(ILLUMINATOR_MODE_INTERNAL, 500000, 1000000, 1000000);
	zassert_equal(light.plan.program.kind, PROGRAM_NONE);
	configure(ILLUMINATOR_MODE_SYNC, 500000, 0, 1000000);
	zassert_equal(light.plan.program.kind, PROGRAM_NONE);
	configure(ILLUMINATOR_MODE_INTERNAL, 500000, 0, 1000000);
	zassert_equal(light.plan.program.kind, PROGRAM_SOS);
	/* what is reported is what was commanded */
	zassert_equal(light.settings.strobe_period_us, 0);
	zassert_equal(light.settings.brightness_ppm, 500000);
	on_off(false);
	zassert_equal(light.plan.program.kind, PROGRAM_NONE);
	zassert_false(light.plan.on);
}

ZTEST(core_illuminator, test_lamp_without_power_is_off_and_stays_so)
{
	struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_POWER, .powered = false};

	on_off(true);
	zassert_equal(step(&event), ILLUMINATOR_ACCEPTED);
	zassert_false(light.settings.enable);
	zassert_false(light.plan.on);
	zassert_equal(on_off(true), ILLUMINATOR_FAILED);
	event.kind = ILLUMINATOR_EVENT_FALLBACK;
	event.fallback = ILLUMINATOR_FALLBACK_BEACON;
	step(&event);
	zassert_false(light.plan.on);
	event.kind = ILLUMINATOR_EVENT_POWER;
	event.powered = true;
	zassert_equal(step(&event), ILLUMINATOR_ACCEPTED);
	zassert_false(light.plan.on, "nobody has commanded it since");
	zassert_equal(on_off(true), ILLUMINATOR_ACCEPTED);
	zassert_true(light.plan.on);
}

/* CIE 15:2004, by hand, in ppm: Y is L / 903.3 below L = 8, ((L + 16)/116) cubed above. */
ZTEST(core_illuminator, test_perceptual_curve_has_cie_values)
{
	static const uint32_t rows[][2] = {
		{0, 0},           {10000, 1107},    {80000, 8856},      {250000, 44155},
		{500000, 184187}, {900000, 763034}, {1000000, 1000000},
	};

	for (size_t i = 0; i < ARRAY_SIZE(rows); i++) {
		zassert_equal(illuminator_curve_ppm(ILLUMINATOR_CURVE_PERCEPTUAL, rows[i][0]),
		              rows[i][1], "row %zu", i);
	}
}

ZTEST(core_illuminator, test_curves_are_monotone_over_every_value)
{
	uint32_t last = 0;

	for (uint32_t ppm = 0; ppm <= PPM_ONE; ppm++) {
		const uint32_t now = illuminator_curve_ppm(ILLUMINATOR_CURVE_PERCEPTUAL, ppm);

		zassert_true(now >= last && now <= ppm, "at %u", ppm);
		last = now;
	}
	zassert_equal(illuminator_curve_ppm(ILLUMINATOR_CURVE_LINEAR, 123456), 123456);
}

ZTEST(core_illuminator, test_on_time_is_rounded_and_never_nothing)
{
	zassert_equal(illuminator_on_us(100000, 500000), 50000);
	zassert_equal(illuminator_on_us(10000, 1), 1);         /* 0.01 us, but lit */
	zassert_equal(illuminator_on_us(10001, 500000), 5001); /* half up */
	zassert_equal(illuminator_on_us(10000, 0), 0);
	zassert_equal(illuminator_on_us(10000, 1000000), 10000);
	zassert_equal(illuminator_on_us(0, 1000000), 0);
	zassert_equal(illuminator_on_us(3600000000u, 999999), 3599996400u);
}

/* 99.99999 % of the shortest period rounds to all of it: no dark microsecond is left. */
ZTEST(core_illuminator, test_duty_that_leaves_no_dark_microsecond_is_steady)
{
	on_off(true);
	zassert_equal(configure(1, 500000, 10000, 999999), ILLUMINATOR_ACCEPTED);
	zassert_equal(light.plan.period_us, 0);
}

ZTEST(core_illuminator, test_every_notice_has_words_that_fit_a_statustext)
{
	for (enum illuminator_notice_kind kind = ILLUMINATOR_NOTICE_THROTTLING_BEGINS;
	     kind <= ILLUMINATOR_NOTICE_SENSOR_OK; kind++) {
		const size_t length = strlen(illuminator_notice_text(kind));

		zassert_true(length > 0 && length <= 40);
	}
}

ZTEST(core_illuminator, test_impossible_config_is_a_bug)
{
	const struct illuminator_config config = {.min_period_us = 20000, .max_period_us = 10000};

	expect_assert();
	illuminator_init(&light, &config);
	zassert_unreachable("no assertion");
}
