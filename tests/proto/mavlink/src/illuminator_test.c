/* SPDX-License-Identifier: Apache-2.0 */
/* Commands 405 and 406: what is accepted, what is refused, and that a refusal changes nothing. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

ZTEST_SUITE(mavlink_illuminator, NULL, NULL, fixture_before, NULL, NULL);

ZTEST(mavlink_illuminator, test_405_on_and_off)
{
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	zassert_true(light->settings.enable);
	zassert_equal(COMMAND(405, 0), MAV_RESULT_ACCEPTED);
	zassert_false(light->settings.enable);
}

ZTEST(mavlink_illuminator, test_405_denies_anything_but_0_and_1)
{
	static const float bad[] = {2, -1, 0.5f, 1.0000001f, 255, NAN, INFINITY, -INFINITY, 1e-30f};

	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_equal(COMMAND(405, bad[i]), MAV_RESULT_DENIED);
		zassert_false(effects.lights || effects.statuses);
		zassert_true(light->settings.enable);
	}
}

ZTEST(mavlink_illuminator, test_405_tolerates_an_illuminator_id_in_param2)
{
	static const float ids[] = {0, 1, 255, NAN};

	for (size_t i = 0; i < ARRAY_SIZE(ids); i++) {
		zassert_equal(COMMAND(405, 1, ids[i]), MAV_RESULT_ACCEPTED);
	}
}

ZTEST(mavlink_illuminator, test_405_on_fails_in_thermal_shutdown_and_off_does_not)
{
	thermal_report(THERMAL_STATE_SHUTDOWN, THERMAL_FAULT_NONE, 90000);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_FAILED);
	zassert_false(light->settings.enable);
	zassert_equal(COMMAND(405, 0), MAV_RESULT_ACCEPTED);
}

ZTEST(mavlink_illuminator, test_406_reaches_the_core)
{
	zassert_equal(COMMAND(406, 2, 33.3f, 0.05f, 12.5f), MAV_RESULT_ACCEPTED);
	zassert_equal(light->settings.mode, ILLUMINATOR_MODE_SYNC);
	zassert_equal(light->settings.brightness_ppm, 333000);
	zassert_equal(light->settings.strobe_period_us, 50000);
	zassert_equal(light->settings.duty_ppm, 125000);
	zassert_false(light->settings.enable);
}

ZTEST(mavlink_illuminator, test_406_edges_of_the_ranges)
{
	zassert_equal(COMMAND(406, 1, 0, 0, 0), MAV_RESULT_ACCEPTED);
	zassert_equal(light->settings.duty_ppm, 0);
	zassert_equal(COMMAND(406, 1, 100, 0.01f, 100), MAV_RESULT_ACCEPTED);
	zassert_equal(light->settings.brightness_ppm, 1000000);
	zassert_equal(light->settings.strobe_period_us, 10000);
	zassert_equal(light->settings.duty_ppm, 1000000);
	zassert_equal(COMMAND(406, 1, 100, 10, 100), MAV_RESULT_ACCEPTED);
	zassert_equal(light->settings.strobe_period_us, 10000000);
	zassert_equal(COMMAND(406, 1, -0.0f, -0.0f, -0.0f), MAV_RESULT_ACCEPTED);
	zassert_equal(light->settings.brightness_ppm, 0);
}

static const float good[] = {1, 50, 0.5f, 25};

ZTEST(mavlink_illuminator, test_406_denies_what_is_out_of_range_and_changes_nothing)
{
	/* Parameter, value: one wrong number among right ones. */
	static const struct {
		int which;
		float value;
	} bad[] = {
		{0, 0},         {0, 3},       {0, -1},       {0, 1.5f},      {0, NAN},
		{0, INFINITY},  {1, -0.001f}, {1, 100.001f}, {1, NAN},       {1, INFINITY},
		{1, -INFINITY}, {2, -0.1f},   {2, 0.00999f}, {2, 10.0001f},  {2, 1e-30f},
		{2, 1e30f},     {2, NAN},     {2, INFINITY}, {2, -INFINITY}, {3, -0.001f},
		{3, 100.001f},  {3, NAN},     {3, INFINITY}, {3, -INFINITY},
	};

	zassert_equal(COMMAND(406, 2, 20, 0.2f, 40), MAV_RESULT_ACCEPTED);

	const struct illuminator_settings kept = light->settings;
	const uint32_t revision = light->revision;

	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		struct command_params params = {{good[0], good[1], good[2], good[3]}};

		params.p[bad[i].which] = bad[i].value;
		zassert_equal(command(406, params), MAV_RESULT_DENIED, "row %u", (unsigned int)i);
		zassert_equal(out.count, 1);
		zassert_false(effects.lights || effects.statuses);
		zassert_equal(light->revision, revision);
		zassert_equal(light->settings.mode, kept.mode);
		zassert_equal(light->settings.brightness_ppm, kept.brightness_ppm);
		zassert_equal(light->settings.strobe_period_us, kept.strobe_period_us);
		zassert_equal(light->settings.duty_ppm, kept.duty_ppm);

		const mavlink_illuminator_status_t status = status_now();

		zassert_equal(status.mode, 2);
		zassert_equal(status.brightness, 20.0f);
		zassert_equal(status.strobe_period, 0.2f);
		zassert_equal(status.strobe_duty_cycle, 40.0f);
	}
}

ZTEST(mavlink_illuminator, test_406_tolerates_an_illuminator_id_in_param5)
{
	static const float ids[] = {0, 1, 255, NAN, INFINITY};

	for (size_t i = 0; i < ARRAY_SIZE(ids); i++) {
		zassert_equal(COMMAND(406, 1, 50, 0, 0, ids[i], ids[i], ids[i]),
		              MAV_RESULT_ACCEPTED);
	}
}

ZTEST(mavlink_illuminator, test_406_smallest_duty_stays_a_strobe)
{
	/* 0.00001 % is 0.1 ppm; duty 0 would mean steadily lit. */
	zassert_equal(COMMAND(406, 1, 50, 1, 0.00001f), MAV_RESULT_ACCEPTED);
	zassert_equal(light->settings.duty_ppm, 1);
	zassert_equal(status_now().strobe_duty_cycle, 0.00001f);
}

ZTEST(mavlink_illuminator, test_406_long_periods_are_exact_to_the_microsecond)
{
	/* 7.123456 s as a float is 7.12345600128173828125. */
	zassert_equal(COMMAND(406, 1, 50, 7.123456f, 50), MAV_RESULT_ACCEPTED);
	zassert_equal(light->settings.strobe_period_us, 7123456);
}

ZTEST(mavlink_illuminator, test_floats_are_echoed_exactly_as_commanded)
{
	/* None of these is a whole number of ppm or µs. */
	static const float odd[] = {33.333332f, 0.123456789f, 66.66667f, 99.999992f, 1.0e-7f};

	for (size_t i = 0; i < ARRAY_SIZE(odd); i++) {
		const float period = 0.01f + odd[i] / 11.0f;

		zassert_equal(COMMAND(406, 1, odd[i], period, odd[i]), MAV_RESULT_ACCEPTED);

		mavlink_illuminator_status_t status = status_now();

		zassert_mem_equal(&status.brightness, &odd[i], sizeof(float));
		zassert_mem_equal(&status.strobe_period, &period, sizeof(float));
		zassert_mem_equal(&status.strobe_duty_cycle, &odd[i], sizeof(float));
		zassert_equal(COMMAND(405, (float)(i & 1)), MAV_RESULT_ACCEPTED);
		status = status_now();
		zassert_mem_equal(&status.brightness, &odd[i], sizeof(float));
	}
}

ZTEST(mavlink_illuminator, test_a_change_by_another_is_reported_instead_of_the_echo)
{
	const struct device_who who = {.way = SECURITY_WAY_DRONECAN};
	const struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_BRIGHTNESS,
	                                        .brightness_ppm = 125000};

	zassert_equal(COMMAND(406, 1, 33.333332f, 0.3333f, 12.3456789f), MAV_RESULT_ACCEPTED);
	zassert_equal(pharos_device_apply(&device, now_us, &who, 0, &event, 1), DEVICE_ACCEPTED);
	settle();

	const mavlink_illuminator_status_t status = status_now();

	zassert_equal(status.brightness, 12.5f);
	zassert_equal(status.strobe_period, 0.3333f); /* not changed: still the echo */
	zassert_equal(status.strobe_duty_cycle, 12.3456789f);
}

ZTEST(mavlink_illuminator, test_an_excluded_source_is_denied)
{
	device.security.excluded = ARBITER_SOURCE_BIT(ARBITER_SOURCE_MAVLINK);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_DENIED);
	zassert_equal(COMMAND(406, 1, 50, 0, 0), MAV_RESULT_DENIED);
	zassert_false(light->settings.enable);
}

ZTEST(mavlink_illuminator, test_an_outranked_source_is_rejected_for_now)
{
	const struct arbiter_config config = {.priority = ARBITER_SOURCE_SHELL,
	                                      .hold_us = 5 * SECOND};

	arbiter_configure(arbiter, &config);
	arbiter_commit(arbiter, now_us, ARBITER_SOURCE_SHELL);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_TEMPORARILY_REJECTED);
	zassert_false(light->settings.enable);
	now_us = 6 * SECOND;
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	zassert_equal(arbiter->commander, ARBITER_SOURCE_MAVLINK);
}

ZTEST(mavlink_illuminator, test_heartbeats_of_commanders_are_signs_of_life)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(HEARTBEAT);
	mavlink_heartbeat_t alive = {.type = 26, .autopilot = 8}; /* a gimbal: no commander */

	now_us = 3 * SECOND;
	receive_message(0, &kind, &alive);
	zassert_equal(arbiter->heard_us, -1);
	alive.type = 6; /* MAV_TYPE_GCS */
	receive_message(0, &kind, &alive);
	zassert_equal(arbiter->heard_us, 3 * SECOND);
	now_us = 4 * SECOND;
	alive = (mavlink_heartbeat_t){.type = 2, .autopilot = 3}; /* ArduPilot, quadrotor */
	receive_message(0, &kind, &alive);
	zassert_equal(arbiter->heard_us, 4 * SECOND);
	zassert_equal(out.count, 0);
}
