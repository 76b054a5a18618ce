/* SPDX-License-Identifier: Apache-2.0 */
/* What the gimbal hears of its vehicle, and asks it for. */
#include "gimbal_fixture.h"

ZTEST_SUITE(mavlink_gimbal_vehicle, NULL, NULL, gimbal_fixture_before, NULL, NULL);

ZTEST(mavlink_gimbal_vehicle, test_autopilot_state_gives_the_attitude)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(AUTOPILOT_STATE_FOR_GIMBAL_DEVICE);
	mavlink_autopilot_state_for_gimbal_device_t state = {.target_system = 1,
	                                                     .target_component = 154};

	/* yaw 90, roll 45: (H, 0, 0, H)(C, S, 0, 0) */
	memcpy(state.q, (const float[4]){H * C, H * S, H * S, H * C}, sizeof(state.q));
	say(1, 1, &kind, &state);
	zassert_within(gimbal->attitude.roll_mdeg, 45000, 2);
	zassert_within(gimbal->attitude.pitch_mdeg, 0, 2);
	zassert_within(gimbal->attitude.yaw_mdeg, 90000, 2);
	state.q[0] = NAN;
	say(1, 1, &kind, &state);
	zassert_equal(its.stats.bad, 1);
	zassert_within(gimbal->attitude.roll_mdeg, 45000, 2);
}

ZTEST(mavlink_gimbal_vehicle, test_attitude_of_others_is_not_the_vehicles)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(ATTITUDE);
	mavlink_attitude_t attitude = {.yaw = 1};

	say(2, 1, &kind, &attitude);   /* another vehicle */
	say(1, 190, &kind, &attitude); /* another component */
	zassert_equal(gimbal->attitude_us, -1);
	attitude.yaw = NAN;
	say(1, 1, &kind, &attitude);
	attitude.yaw = 1e9f;
	say(1, 1, &kind, &attitude);
	attitude.yaw = -12.7f; /* more than two turns: 12.566 */
	say(1, 1, &kind, &attitude);
	zassert_equal(gimbal->attitude_us, -1);
	zassert_equal(its.stats.bad, 3);
	attitude.yaw = -12.5f;
	say(1, 1, &kind, &attitude);
	zassert_equal(gimbal->attitude_us, now_us);
	zassert_equal(its.stats.bad, 3);
}

struct requests {
	uint32_t streams[2]; /* EXTRA1, POSITION */
	uint32_t intervals[2];
	uint32_t wrong;
};

static void count_request(struct requests *requests, uint16_t i)
{
	const struct mavlink_frame frame = sent(i);
	mavlink_request_data_stream_t stream;
	mavlink_command_long_t interval;

	if (frame.message_id == 66) { /* REQUEST_DATA_STREAM */
		mavlink_frame_payload(&frame, &stream, sizeof(stream));
		requests->streams[0] += stream.req_stream_id == 10 && stream.start_stop == 1;
		requests->streams[1] += stream.req_stream_id == 6 && stream.start_stop == 1;
		requests->wrong += stream.target_system != 1 || stream.target_component != 1;
	} else if (frame.message_id == 76) { /* COMMAND_LONG */
		mavlink_frame_payload(&frame, &interval, sizeof(interval));
		requests->intervals[0] += interval.param1 == 30 && interval.param2 == 50000;
		requests->intervals[1] += interval.param1 == 33 && interval.param2 == 500000;
		requests->wrong += interval.target_system != 1 || interval.command != 511;
	} else {
		return;
	}
	requests->wrong += out.frames[i].link != 1 || frame.component_id != 154;
}

/* The vehicle's heartbeat each second; every other requests its data when it says so. */
static struct requests fly(int64_t duration_us, bool attitude, bool position)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(GLOBAL_POSITION_INT);
	static const mavlink_global_position_int_t where = {.lat = 1, .lon = 1};
	const int64_t until_us = now_us + duration_us;
	struct requests requests = {0};

	for (int64_t beat_us = now_us; beat_us < until_us; beat_us += SECOND) {
		vehicle_beats();
		if (attitude) {
			vehicle_attitude(0, 0, 0);
		}
		if (position) {
			say(1, 1, &kind, &where);
		}
		while (mavlink_endpoint_deadline_us(&endpoint) < beat_us + SECOND) {
			const int64_t due_us = mavlink_endpoint_deadline_us(&endpoint);

			now_us = due_us > now_us ? due_us : now_us;
			mavlink_endpoint_step(&endpoint, now_us, &out);
			for (uint16_t i = 0; i < out.count; i++) {
				count_request(&requests, i);
			}
		}
		now_us = beat_us + SECOND;
	}
	return requests;
}

ZTEST(mavlink_gimbal_vehicle, test_data_are_asked_for_until_they_come_and_again_when_they_stop)
{
	struct requests requests = fly(10 * SECOND, false, false);

	zassert_equal(requests.streams[0], 10);
	zassert_equal(requests.streams[1], 10);
	zassert_equal(requests.intervals[0], 10);
	zassert_equal(requests.intervals[1], 10);
	zassert_equal(requests.wrong, 0);
	requests = fly(10 * SECOND, true, false);
	zassert_equal(requests.streams[0], 0, "attitude comes");
	zassert_equal(requests.streams[1], 0, "ten times in vain: later");
	requests = fly(10 * SECOND, true, true);
	zassert_equal(requests.streams[1], 0);
	requests = fly(10 * SECOND, false, false);
	zassert_within(requests.streams[0], 9, 1, "after 2 s of silence");
	zassert_within(requests.intervals[1], 9, 1);
}

/* A vehicle without a receiver of satellites has no position to tell. */
ZTEST(mavlink_gimbal_vehicle, test_what_never_comes_is_asked_for_ever_more_seldom)
{
	struct requests requests = fly(310 * SECOND, true, false);

	zassert_equal(requests.streams[0], 0);
	zassert_within(requests.streams[1], 10 + 10, 1, "each second, then each 30 s");
	/* a vehicle that has been away may have got one */
	(void)idle(10 * SECOND);
	requests = fly(5 * SECOND, true, false);
	zassert_equal(requests.streams[1], 5);
}

/* --- the manager ------------------------------------------------------------------------------ */

/* GIMBAL_DEVICE_SET_ATTITUDE with a yaw, from anyone: cosine and sine of its half. */
static void point(uint8_t system, uint8_t component, float w, float z)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(GIMBAL_DEVICE_SET_ATTITUDE);
	const mavlink_gimbal_device_set_attitude_t wire = {
		.q = {w, 0, 0, z},
		.angular_velocity_x = NAN,
		.angular_velocity_y = NAN,
		.angular_velocity_z = NAN,
		.target_system = 1,
		.target_component = 154,
	};

	say(system, component, &kind, &wire);
	pass(SECOND);
}

#define DEG_20  0.98480775f, 0.17364818f
#define DEG_M40 0.93969262f, -0.34202014f

ZTEST(mavlink_gimbal_vehicle, test_set_attitude_is_the_managers)
{
	static const uint8_t others[][2] = {{9, 25}, {1, 190}, {2, 1}, {255, 190}, {1, 191}};

	point(1, 1, DEG_20);
	assert_at(20000, 0);
	for (uint32_t i = 0; i < ARRAY_SIZE(others); i++) {
		point(others[i][0], others[i][1], DEG_M40);
		assert_at(20000, 0);
		zassert_equal(its.stats.foreign, i + 1);
	}
	point(1, 1, DEG_M40);
	assert_at(-40000, 0);
	zassert_equal(its.stats.set, 2);
}

/* A companion computer that says that it manages this gimbal; a station of another system can't. */
ZTEST(mavlink_gimbal_vehicle, test_manager_names_its_gimbal)
{
	static const struct mavlink_kind information = MAVLINK_KIND(GIMBAL_MANAGER_INFORMATION);
	static const struct mavlink_kind status = MAVLINK_KIND(GIMBAL_MANAGER_STATUS);
	mavlink_gimbal_manager_information_t told = {.gimbal_device_id = 171};
	const mavlink_gimbal_manager_status_t state = {.gimbal_device_id = 154};

	say(1, 191, &information, &told);
	point(1, 191, DEG_20);
	assert_at(0, 0);
	told.gimbal_device_id = 154;
	say(9, 191, &information, &told);
	point(9, 191, DEG_20);
	assert_at(0, 0);
	say(1, 191, &information, &told);
	point(1, 191, DEG_20);
	assert_at(20000, 0);
	say(1, 192, &status, &state);
	point(1, 192, DEG_M40);
	assert_at(-40000, 0);
	point(1, 191, DEG_20);
	assert_at(-40000, 0);
	point(1, 1, DEG_20);
	assert_at(20000, 0);
	/* it is heard: mount commands of others wait */
	zassert_equal(ORDER(205, 0, 0, 10, 0, 0, 0, 2), MAV_RESULT_TEMPORARILY_REJECTED);
	pass(5 * SECOND);
	zassert_equal(ORDER(205, 0, 0, 10, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
}

ZTEST(mavlink_gimbal_vehicle, test_anyones_mount_commands_count_while_no_manager_is_heard)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const mavlink_command_long_t vehicles = {.param3 = 30,
	                                         .param7 = 2,
	                                         .command = 205,
	                                         .target_system = 1,
	                                         .target_component = 154};

	zassert_equal(ORDER(205, 0, 0, 10, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	vehicle_beats();
	zassert_equal(ORDER(205, 0, 0, 20, 0, 0, 0, 2), MAV_RESULT_TEMPORARILY_REJECTED);
	zassert_equal(ORDER(204, 2, 0, 0, 0, 0, 0, 0), MAV_RESULT_TEMPORARILY_REJECTED);
	zassert_equal(its.stats.foreign, 2);
	/* to all, it is the manager that answers */
	receive_long(0, 1, 0, 205, (struct command_params){{0, 0, 20, 0, 0, 0, 2}});
	zassert_equal(out.count, 0);
	pass(SECOND);
	assert_at(10000, 0);
	say(1, 1, &kind, &vehicles);
	zassert_equal(out.count, 1);
	pass(SECOND);
	assert_at(30000, 0);
	pass(3 * SECOND - 1);
	zassert_equal(ORDER(205, 0, 0, 20, 0, 0, 0, 2), MAV_RESULT_TEMPORARILY_REJECTED);
	pass(1);
	zassert_equal(ORDER(205, 0, 0, 20, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
}

ZTEST(mavlink_gimbal_vehicle, test_nobody_is_asked_without_a_vehicle_or_when_told_not_to)
{
	(void)idle(10 * SECOND);
	zassert_equal(its.stats.requests, 0);
	device_params->values[PARAM_GMB_ASK_DATA] = 0;
	(void)fly(5 * SECOND, false, false);
	zassert_equal(its.stats.requests, 0);
	device_params->values[PARAM_GMB_ASK_DATA] = 1;
	(void)fly(SECOND, false, false);
	zassert_true(its.stats.requests > 0);
	const uint32_t asked_so_far = its.stats.requests;

	(void)idle(60 * SECOND); /* the vehicle has gone */
	zassert_true(its.stats.requests <= asked_so_far + 10);
}

ZTEST(mavlink_gimbal_vehicle, test_another_vehicle_is_not_asked)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(HEARTBEAT);
	mavlink_heartbeat_t heartbeat = {.type = 2, .autopilot = 3};

	say(2, 1, &kind, &heartbeat);
	heartbeat = (mavlink_heartbeat_t){.type = 6, .autopilot = 8};
	say(255, 190, &kind, &heartbeat);
	(void)idle(5 * SECOND);
	zassert_equal(its.stats.requests, 0);
}

/* --- places ----------------------------------------------------------------------------------- */

/* The vehicle is at 47 N, 8 E, 500 m over the sea, heads north. */
static void vehicle_at(int32_t lat, int32_t lon, int32_t alt)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(GLOBAL_POSITION_INT);
	const mavlink_global_position_int_t where = {.lat = lat, .lon = lon, .alt = alt};

	say(1, 1, &kind, &where);
	vehicle_attitude(0, 0, 0);
}

static void assert_near(int32_t pan_mdeg, int32_t tilt_mdeg)
{
	const struct direction own = gimbal_report(gimbal, now_us).own;

	zassert_within(own.yaw_mdeg, pan_mdeg, 100, "pan %d", own.yaw_mdeg);
	zassert_within(own.pitch_mdeg, tilt_mdeg, 100, "tilt %d", own.pitch_mdeg);
}

/*
 * Metres to degrees on a sphere of 40 075 km around: 1000 m of latitude are 0.0089832 degrees, of
 * longitude at 47 degrees 0.0131718. A float has the numbers to 0.4 m.
 */
ZTEST(mavlink_gimbal_vehicle, test_mount_control_points_at_a_place)
{
	vehicle_at(470000000, 80000000, 500000);
	/* 1000 m north and east, level */
	zassert_equal(ORDER(205, 0, 0, 0, 500, (float)470089832, (float)80131718, 4),
	              MAV_RESULT_ACCEPTED);
	pass(SECOND / 2);
	assert_near(45000, 0);
	/* 200 m west, 100 m up: atan(1 / 2) */
	zassert_equal(ORDER(205, 0, 0, 0, 600, 470000000, 79973656, 4), MAV_RESULT_ACCEPTED);
	pass(SECOND * 9 / 10);
	vehicle_attitude(0, 0, 0);
	pass(SECOND * 9 / 10);
	assert_near(-90000, 26565);
}

ZTEST(mavlink_gimbal_vehicle, test_the_beam_stays_on_the_place_while_the_vehicle_moves)
{
	vehicle_at(470000000, 80000000, 500000);
	zassert_equal(ORDER(205, 0, 0, 0, 500, (float)470089832, (float)80131718, 4),
	              MAV_RESULT_ACCEPTED);
	pass(SECOND / 2);
	vehicle_at(470000000, 80131718, 1500000); /* south of it, 1000 m higher */
	pass(SECOND * 9 / 10);
	assert_near(0, -45000);
	zassert_equal(ORDER(205, 0, 0, 10, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	vehicle_at(470000000, 80000000, 500000);
	pass(SECOND / 2);
	assert_near(10000, 0); /* pointed otherwise, it stays there */
}

ZTEST(mavlink_gimbal_vehicle, test_another_source_ends_the_tracking)
{
	const struct gimbal_event neutral = {.kind = GIMBAL_EVENT_NEUTRAL};

	vehicle_at(470000000, 80000000, 500000);
	zassert_equal(ORDER(205, 0, 0, 0, 500, (float)470089832, (float)80131718, 4),
	              MAV_RESULT_ACCEPTED);
	pass(SECOND / 2);
	gimbal_step(gimbal, now_us, &neutral);
	arbiter_commit(gimbal_arbiter, now_us, ARBITER_SOURCE_SHELL);
	vehicle_at(470000000, 80000000, 500000);
	pass(SECOND);
	assert_near(0, 0);
}

ZTEST(mavlink_gimbal_vehicle, test_places_that_are_none)
{
	static const float bad[] = {NAN, INFINITY, -INFINITY, 1.9e9f};

	zassert_equal(ORDER(205, 0, 0, 0, 500, (float)470089832, (float)80131718, 4),
	              MAV_RESULT_FAILED, "where the vehicle is, is not known");
	vehicle_at(470000000, 80000000, 500000);
	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_equal(ORDER(205, 0, 0, 0, 500, bad[i], 8, 4), MAV_RESULT_DENIED);
		zassert_equal(ORDER(205, 0, 0, 0, 500, 47, bad[i], 4), MAV_RESULT_DENIED);
		zassert_equal(ORDER(205, 0, 0, 0, bad[i], 47, 8, 4), MAV_RESULT_DENIED);
	}
	zassert_equal(ORDER(205, 0, 0, 0, 500, 470000000, 80000000, 4), MAV_RESULT_FAILED,
	              "the vehicle's own place");
	zassert_equal(ORDER(205, 0, 0, 0, 500, -470000000, -80000000, 4), MAV_RESULT_FAILED,
	              "the other side of the earth");
	pass(SECOND);
	assert_near(0, 0);
	zassert_equal(ORDER(204, 4), MAV_RESULT_ACCEPTED);
}

/* At 180 degrees of longitude east goes on as west. */
ZTEST(mavlink_gimbal_vehicle, test_a_place_across_the_date_line)
{
	vehicle_at(0, 1799990000, 0);
	zassert_equal(ORDER(205, 0, 0, 0, 0, 0, (float)-1799990000, 4), MAV_RESULT_ACCEPTED);
	pass(SECOND * 9 / 10);
	vehicle_attitude(0, 0, 0);
	pass(SECOND / 2);
	assert_near(90000, 0);
}
