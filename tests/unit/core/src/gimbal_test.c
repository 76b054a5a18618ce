/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A gimbal of ±90 degrees and 1000…2000 us on both axes: 1500 us is straight ahead, a degree is
 * 5555.5 ns. Pan turns at 100 degrees per second, tilt at 50: 2 and 1 degrees per frame of 20 ms.
 */
#include "core/gimbal.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define FRAME  INT64_C(20000)
#define SECOND INT64_C(1000000)

static struct gimbal gimbal;
static struct gimbal_config config;
static struct gimbal_outbox out;
static int64_t now_us;
static uint32_t moves; /* times that the servos were told */

static void advance(void)
{
	gimbal_advance(&gimbal, now_us, &out);
	moves += out.move ? 1 : 0;
}

static void before(void *fixture)
{
	const struct gimbal_axis_config axis = {
		.min_mdeg = -90000,
		.max_mdeg = 90000,
		.rate_mdeg_per_s = 50000,
		.pulse_min_us = 1000,
		.pulse_max_us = 2000,
	};

	config = (struct gimbal_config){
		.axes = {axis, axis},
		.rate_timeout_us = SECOND / 2,
		.attitude_timeout_us = SECOND,
	};
	config.axes[GIMBAL_PAN].rate_mdeg_per_s = 100000;
	config.axes[GIMBAL_TILT].retract_mdeg = -90000;
	now_us = 0;
	moves = 0;
	gimbal_init(&gimbal, now_us, &config);
	advance();
}

ZTEST_SUITE(core_gimbal, NULL, NULL, before, NULL, NULL);

static void run_until(int64_t until_us)
{
	while (gimbal_deadline_us(&gimbal) <= until_us) {
		zassert_true(gimbal_deadline_us(&gimbal) >= now_us, "due in the past");
		now_us = gimbal_deadline_us(&gimbal);
		advance();
	}
	now_us = until_us;
}

static void run_for(int64_t duration_us)
{
	run_until(now_us + duration_us);
}

static enum gimbal_result step(const struct gimbal_event *event)
{
	const enum gimbal_result result = gimbal_step(&gimbal, now_us, event);

	return result;
}

static const struct gimbal_aim keep = {.kind = GIMBAL_KEEP};

static struct gimbal_aim angle(int32_t mdeg)
{
	return (struct gimbal_aim){.kind = GIMBAL_ANGLE, .value = mdeg};
}

static struct gimbal_aim locked(int32_t mdeg)
{
	return (struct gimbal_aim){.kind = GIMBAL_ANGLE, .lock = true, .value = mdeg};
}

static struct gimbal_aim rate(int32_t mdeg_per_s)
{
	return (struct gimbal_aim){.kind = GIMBAL_RATE, .value = mdeg_per_s};
}

static struct gimbal_aim locked_rate(int32_t mdeg_per_s)
{
	return (struct gimbal_aim){.kind = GIMBAL_RATE, .lock = true, .value = mdeg_per_s};
}

static enum gimbal_result aim(struct gimbal_aim pan, struct gimbal_aim tilt)
{
	const struct gimbal_event event = {.kind = GIMBAL_EVENT_AIM, .aim = {pan, tilt}};

	return step(&event);
}

static void vehicle(int32_t roll_mdeg, int32_t pitch_mdeg, int32_t yaw_mdeg)
{
	const struct gimbal_event event = {
		.kind = GIMBAL_EVENT_ATTITUDE,
		.attitude = {roll_mdeg, pitch_mdeg, yaw_mdeg},
	};

	zassert_equal(step(&event), GIMBAL_ACCEPTED);
}

/* The vehicle's attitude comes at 10 Hz for so long. */
static void fly_for(int64_t duration_us, int32_t roll_mdeg, int32_t pitch_mdeg, int32_t yaw_mdeg)
{
	const int64_t end_us = now_us + duration_us;

	while (now_us < end_us) {
		vehicle(roll_mdeg, pitch_mdeg, yaw_mdeg);
		run_for(SECOND / 10);
	}
}

static struct gimbal_report report(void)
{
	return gimbal_report(&gimbal, now_us);
}

static void assert_at(int32_t pan_mdeg, int32_t tilt_mdeg)
{
	const struct direction own = report().own;

	zassert_within(own.yaw_mdeg, pan_mdeg, 1, "pan %d, not %d", own.yaw_mdeg, pan_mdeg);
	zassert_within(own.pitch_mdeg, tilt_mdeg, 1, "tilt %d, not %d", own.pitch_mdeg, tilt_mdeg);
}

/* --- servos ----------------------------------------------------------------------------------- */

ZTEST(core_gimbal, test_starts_neutral_and_tells_the_servos_once)
{
	zassert_true(out.move);
	zassert_equal(out.pulse_ns[GIMBAL_PAN], 1500000);
	zassert_equal(out.pulse_ns[GIMBAL_TILT], 1500000);
	zassert_equal(gimbal_deadline_us(&gimbal), TIME_NEVER_US, "silent when still");
	zassert_equal(report().mode, GIMBAL_MODE_NEUTRAL);
}

ZTEST(core_gimbal, test_pulse_is_linear_in_the_angle)
{
	aim(angle(45000), angle(-30000));
	run_for(2 * SECOND);
	zassert_equal(gimbal.pulse_ns[GIMBAL_PAN], 1750000);  /* 1500 + 500 / 2 */
	zassert_equal(gimbal.pulse_ns[GIMBAL_TILT], 1333333); /* 1500 - 500 / 3 */
}

ZTEST(core_gimbal, test_pulse_ends_may_be_swapped_and_trimmed)
{
	struct gimbal_event event = {.kind = GIMBAL_EVENT_CONFIG, .config = config};

	event.config.axes[GIMBAL_PAN].pulse_min_us = 2000;
	event.config.axes[GIMBAL_PAN].pulse_max_us = 1000;
	event.config.axes[GIMBAL_PAN].trim_us = 20;
	event.config.axes[GIMBAL_TILT].trim_us = -40;
	step(&event);
	run_for(FRAME);
	zassert_equal(gimbal.pulse_ns[GIMBAL_PAN], 1520000);
	zassert_equal(gimbal.pulse_ns[GIMBAL_TILT], 1460000);
	aim(angle(90000), keep);
	run_for(2 * SECOND);
	zassert_equal(gimbal.pulse_ns[GIMBAL_PAN], 1020000);
}

ZTEST(core_gimbal, test_no_pulse_leaves_what_any_servo_takes)
{
	struct gimbal_event event = {.kind = GIMBAL_EVENT_CONFIG, .config = config};

	event.config.axes[GIMBAL_PAN].pulse_max_us = 2500;
	event.config.axes[GIMBAL_PAN].trim_us = 500;
	step(&event);
	aim(angle(90000), keep);
	run_for(3 * SECOND);
	zassert_equal(gimbal.pulse_ns[GIMBAL_PAN], 2500000);
}

/* --- angles ----------------------------------------------------------------------------------- */

ZTEST(core_gimbal, test_turns_at_its_rate_in_frames_of_20_ms_then_falls_silent)
{
	moves = 0;
	now_us = 7000;
	zassert_equal(aim(angle(10000), angle(10000)), GIMBAL_ACCEPTED);
	zassert_equal(gimbal_deadline_us(&gimbal), 7000 + FRAME);
	run_for(FRAME);
	assert_at(2000, 1000);
	run_for(4 * FRAME);
	assert_at(10000, 5000);
	run_for(10 * SECOND);
	assert_at(10000, 10000);
	zassert_equal(moves, 10, "50 degrees per second over 10 degrees");
	zassert_equal(gimbal_deadline_us(&gimbal), TIME_NEVER_US);
}

ZTEST(core_gimbal, test_beyond_the_limits_is_the_limit_and_told)
{
	aim(angle(120000), angle(-90000));
	run_for(3 * SECOND);
	assert_at(90000, -90000);
	zassert_true(report().at_limit[GIMBAL_PAN]);
	zassert_false(report().at_limit[GIMBAL_TILT], "at it, not beyond");
	aim(angle(-200000), keep); /* as 160 degrees */
	run_for(3 * SECOND);
	assert_at(90000, -90000);
	aim(angle(89999), keep);
	zassert_false(report().at_limit[GIMBAL_PAN]);
}

ZTEST(core_gimbal, test_one_axis_leaves_the_other)
{
	aim(angle(20000), angle(10000));
	run_for(SECOND);
	aim(keep, angle(-10000));
	run_for(SECOND);
	assert_at(20000, -10000);
	step(&(struct gimbal_event){.kind = GIMBAL_EVENT_RETRACT});
	run_for(3 * SECOND);
	assert_at(0, -90000);
	aim(angle(5000), keep);
	run_for(SECOND);
	assert_at(5000, -90000);
	zassert_equal(report().mode, GIMBAL_MODE_AIMED);
}

ZTEST(core_gimbal, test_neutral_and_retracted_positions)
{
	struct gimbal_event event = {.kind = GIMBAL_EVENT_CONFIG, .config = config};

	event.config.axes[GIMBAL_PAN].neutral_mdeg = 3000;
	event.config.axes[GIMBAL_TILT].neutral_mdeg = -4000;
	event.config.axes[GIMBAL_PAN].retract_mdeg = 170000; /* beyond the limit: at it */
	step(&event);
	run_for(SECOND);
	assert_at(3000, -4000);
	step(&(struct gimbal_event){.kind = GIMBAL_EVENT_RETRACT});
	run_for(3 * SECOND);
	assert_at(90000, -90000);
	zassert_equal(report().mode, GIMBAL_MODE_RETRACTED);
	step(&(struct gimbal_event){.kind = GIMBAL_EVENT_NEUTRAL});
	run_for(3 * SECOND);
	assert_at(3000, -4000);
	zassert_equal(gimbal.stats.accepted, 2);
}

ZTEST(core_gimbal, test_what_is_out_of_range_changes_nothing)
{
	static const struct gimbal_aim bad[] = {
		{.kind = GIMBAL_ANGLE, .value = 360001},
		{.kind = GIMBAL_ANGLE, .value = INT32_MIN},
		{.kind = GIMBAL_RATE, .value = 2000001},
		{.kind = GIMBAL_RATE, .value = -2000001},
	};
	static struct gimbal kept;

	aim(angle(10000), angle(10000));
	kept = gimbal;
	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_equal(aim(bad[i], angle(0)), GIMBAL_DENIED);
		zassert_equal(aim(angle(0), bad[i]), GIMBAL_DENIED);
	}
	zassert_equal(gimbal.stats.denied, 8);
	gimbal.stats = kept.stats;
	zassert_mem_equal(&gimbal, &kept, sizeof(kept));
}

ZTEST(core_gimbal, test_narrower_limits_bring_it_back)
{
	struct gimbal_event event = {.kind = GIMBAL_EVENT_CONFIG, .config = config};

	aim(angle(80000), angle(0));
	run_for(SECOND);
	event.config.axes[GIMBAL_PAN].max_mdeg = 40000;
	step(&event);
	run_for(SECOND);
	assert_at(40000, 0);
}

/* --- rates ------------------------------------------------------------------------------------ */

ZTEST(core_gimbal, test_rate_turns_until_it_is_not_renewed)
{
	aim(rate(10000), rate(-20000));
	run_for(300000);
	aim(rate(10000), rate(-20000)); /* renewed: 0.8 s in all */
	run_for(5 * SECOND);
	assert_at(8000, -16000);
	zassert_equal(gimbal.stats.rate_timeouts, 1);
	zassert_equal(gimbal_deadline_us(&gimbal), TIME_NEVER_US);
}

ZTEST(core_gimbal, test_slow_rate_adds_up_exactly)
{
	for (int i = 0; i < 1000; i++) {
		aim(rate(7), keep); /* 0.007 degrees per second for 100 s */
		run_for(SECOND / 10);
	}
	assert_at(700, 0);
}

ZTEST(core_gimbal, test_rate_starts_from_where_it_is_and_is_no_faster_than_the_axis)
{
	aim(angle(90000), keep);
	run_for(10 * FRAME);
	assert_at(20000, 0);
	aim(rate(-2000000), keep);
	run_for(5 * FRAME);
	assert_at(10000, 0);
}

ZTEST(core_gimbal, test_rate_against_a_limit_turns_back_at_once)
{
	aim(angle(85000), angle(0));
	run_for(2 * SECOND);
	for (int i = 0; i < 20; i++) {
		aim(rate(50000), keep);
		run_for(SECOND / 10);
	}
	assert_at(90000, 0);
	zassert_true(report().at_limit[GIMBAL_PAN]);
	aim(rate(-50000), keep);
	run_for(SECOND / 10);
	assert_at(85000, 0);
	zassert_false(report().at_limit[GIMBAL_PAN]);
}

ZTEST(core_gimbal, test_report_tells_the_speed)
{
	aim(rate(10000), rate(-20000));
	run_for(5 * FRAME);
	zassert_equal(report().speed[GIMBAL_PAN], 10000);
	zassert_equal(report().speed[GIMBAL_TILT], -20000);
	run_for(SECOND);
	zassert_equal(report().speed[GIMBAL_PAN], 0);
}

/* --- locks ------------------------------------------------------------------------------------ */

ZTEST(core_gimbal, test_pan_locked_to_north_takes_the_heading_out)
{
	vehicle(0, 0, 350000);
	aim(locked(10000), angle(0));
	fly_for(SECOND, 0, 0, 350000);
	assert_at(20000, 0);
	zassert_true(report().pan_locked);
	zassert_false(report().tilt_locked);
	fly_for(2 * SECOND, 0, 0, 70000);
	assert_at(-60000, 0);
	fly_for(3 * SECOND, 0, 0, 120000); /* 110 degrees to the left: beyond */
	assert_at(-90000, 0);
	zassert_true(report().at_limit[GIMBAL_PAN]);
}

ZTEST(core_gimbal, test_tilt_locked_to_the_horizon_takes_roll_and_pitch_out)
{
	aim(angle(0), locked(0));
	fly_for(SECOND, 0, 20000, 123000);
	assert_at(0, -20000); /* nose up: look down */
	aim(angle(90000), locked(0));
	fly_for(2 * SECOND, 30000, 0, -77000);
	assert_at(90000, 30000); /* right wing down: the horizon is up there */
	aim(angle(45000), locked(0));
	fly_for(2 * SECOND, 0, 30000, 0);
	assert_at(49107, -20705); /* atan(2 / sqrt 3), asin(sqrt 2 / 4) */
	zassert_within(report().level.yaw_mdeg, 45000, 1);
	zassert_within(report().level.pitch_mdeg, 0, 1);
}

ZTEST(core_gimbal, test_both_locked_point_at_a_direction_of_the_earth)
{
	aim(locked(130000), locked(-40000)); /* as angle_test.c: 30 from the heading */
	fly_for(3 * SECOND, 25000, -15000, 100000);
	assert_at(33634, -14195);
	aim(locked(40000), locked(10000)); /* -60 from the heading */
	fly_for(3 * SECOND, -10000, 5000, 100000);
	assert_at(-58256, 16033);
}

ZTEST(core_gimbal, test_lock_without_attitude_holds_and_goes_on_when_it_comes)
{
	aim(angle(10000), angle(10000));
	run_for(SECOND);
	aim(locked(0), locked(0));
	run_for(SECOND);
	assert_at(10000, 10000);
	zassert_true(report().attitude_lost);
	zassert_false(report().pan_locked);
	zassert_equal(gimbal.stats.attitude_losses, 1);
	fly_for(2 * SECOND, 0, 0, 30000);
	assert_at(-30000, 0);
	zassert_false(report().attitude_lost);
	run_for(SECOND - SECOND / 10 - 1);
	zassert_false(report().attitude_lost);
	run_for(1);
	zassert_true(report().attitude_lost, "none for a second");
	zassert_equal(gimbal.stats.attitude_losses, 2);
	zassert_equal(gimbal_deadline_us(&gimbal), TIME_NEVER_US);
	run_for(10 * SECOND);
	assert_at(-30000, 0);
}

ZTEST(core_gimbal, test_attitude_moves_nothing_without_a_lock)
{
	aim(angle(10000), angle(10000));
	run_for(SECOND);
	moves = 0;
	fly_for(SECOND, 20000, 30000, 40000);
	zassert_equal(moves, 0);
	step(&(struct gimbal_event){.kind = GIMBAL_EVENT_NEUTRAL});
	aim(locked(0), locked(0));
	step(&(struct gimbal_event){.kind = GIMBAL_EVENT_RETRACT});
	fly_for(3 * SECOND, 20000, 30000, 40000);
	assert_at(0, -90000); /* no stabilisation when retracted */
}

ZTEST(core_gimbal, test_locked_rate_counts_from_the_earth)
{
	aim(angle(20000), angle(0));
	run_for(SECOND);
	vehicle(0, 0, 0);
	aim(locked_rate(0), locked_rate(0)); /* now looks at 20 degrees of the earth, and stays */
	fly_for(SECOND, 0, 10000, -30000);
	zassert_within(report().level.yaw_mdeg + report().heading_mdeg, 20000, 2);
	zassert_within(report().level.pitch_mdeg, 0, 2);
	aim(locked_rate(10000), locked_rate(-5000));
	fly_for(SECOND / 2, 0, 0, -30000);
	zassert_within(report().level.yaw_mdeg + report().heading_mdeg, 25000, 2);
	zassert_within(report().level.pitch_mdeg, -2500, 2);
}

ZTEST(core_gimbal, test_locked_rate_does_not_run_away_beyond_a_limit)
{
	vehicle(0, 0, 0);
	for (int i = 0; i < 30; i++) {
		vehicle(0, 0, 0);
		aim(locked_rate(100000), locked_rate(0));
		run_for(SECOND / 10);
	}
	assert_at(90000, 0);
	vehicle(0, 0, 0);
	aim(locked_rate(-50000), locked_rate(0));
	run_for(SECOND / 5);
	zassert_within(report().own.yaw_mdeg, 80000, 2100, "%d", report().own.yaw_mdeg);
}

ZTEST(core_gimbal, test_lock_that_goes_keeps_the_beam_where_it_is)
{
	aim(locked(30000), locked(-20000));
	fly_for(2 * SECOND, 10000, 5000, 0);
	const struct direction own = report().own;

	aim(rate(0), rate(0));
	fly_for(SECOND, -20000, -5000, 90000);
	assert_at(own.yaw_mdeg, own.pitch_mdeg);
}

ZTEST(core_gimbal, test_straight_down_keeps_pan)
{
	aim(angle(40000), angle(-90000));
	run_for(3 * SECOND);
	aim(angle(40000), locked(-90000));
	fly_for(2 * SECOND, 0, 0, 0);
	assert_at(40000, -90000);
}

/* --- the rest --------------------------------------------------------------------------------- */

ZTEST(core_gimbal, test_shares_of_the_range)
{
	struct gimbal_event event = {.kind = GIMBAL_EVENT_CONFIG, .config = config};

	event.config.axes[GIMBAL_TILT].max_mdeg = 30000;
	step(&event);
	zassert_equal(gimbal_share_mdeg(&gimbal, GIMBAL_PAN, 0), 0);
	zassert_equal(gimbal_share_mdeg(&gimbal, GIMBAL_PAN, -1000000), -90000);
	zassert_equal(gimbal_share_mdeg(&gimbal, GIMBAL_TILT, 1000000), 30000);
	zassert_equal(gimbal_share_mdeg(&gimbal, GIMBAL_TILT, 500000), 0);
}

ZTEST(core_gimbal, test_fault_is_told)
{
	step(&(struct gimbal_event){.kind = GIMBAL_EVENT_FAULT, .fault = true});
	zassert_true(report().fault);
	step(&(struct gimbal_event){.kind = GIMBAL_EVENT_FAULT, .fault = false});
	zassert_false(report().fault);
}

ZTEST(core_gimbal, test_late_frames_are_not_made_up_for_by_a_jump)
{
	aim(angle(90000), angle(0));
	now_us = 5 * FRAME + 100; /* the thread was held up */
	advance();
	assert_at(10010, 0);
	zassert_equal(gimbal_deadline_us(&gimbal), now_us + FRAME);
}

ZTEST(core_gimbal, test_modes_have_names)
{
	zassert_equal(strcmp(gimbal_mode_name(GIMBAL_MODE_RETRACTED), "retracted"), 0);
}

ZTEST(core_gimbal, test_limits_the_wrong_way_round_are_a_bug)
{
	config.axes[GIMBAL_PAN].max_mdeg = config.axes[GIMBAL_PAN].min_mdeg;
	expect_assert();
	gimbal_init(&gimbal, 0, &config);
	zassert_unreachable("no assertion");
}
