/* SPDX-License-Identifier: Apache-2.0 */
/* The gimbal's messages and commands. */
#include "gimbal_fixture.h"

ZTEST_SUITE(mavlink_gimbal, NULL, NULL, gimbal_fixture_before, NULL, NULL);

/* --- presence --------------------------------------------------------------------------------- */

/* common.xml, mid 2026: what the project's numbers mean. */
ZTEST(mavlink_gimbal, test_wire_ids)
{
	zassert_equal(MAVLINK_MSG_ID_GIMBAL_DEVICE_INFORMATION, 283);
	zassert_equal(MAVLINK_MSG_ID_GIMBAL_DEVICE_SET_ATTITUDE, 284);
	zassert_equal(MAVLINK_MSG_ID_GIMBAL_DEVICE_ATTITUDE_STATUS, 285);
	zassert_equal(MAVLINK_MSG_ID_AUTOPILOT_STATE_FOR_GIMBAL_DEVICE, 286);
	zassert_equal(MAV_CMD_DO_MOUNT_CONFIGURE, 204);
	zassert_equal(MAV_CMD_DO_MOUNT_CONTROL, 205);
}

ZTEST(mavlink_gimbal, test_heartbeat_is_a_gimbals)
{
	mavlink_heartbeat_t heartbeat;

	asked(0, &heartbeat, sizeof(heartbeat));
	zassert_equal(heartbeat.type, 26);         /* MAV_TYPE_GIMBAL */
	zassert_equal(heartbeat.autopilot, 8);     /* MAV_AUTOPILOT_INVALID */
	zassert_equal(heartbeat.system_status, 4); /* MAV_STATE_ACTIVE */
	gimbal->fault = true;
	asked(0, &heartbeat, sizeof(heartbeat));
	zassert_equal(heartbeat.system_status, 5); /* MAV_STATE_CRITICAL */
}

ZTEST(mavlink_gimbal, test_streams_heartbeat_and_attitude_on_every_link)
{
	const struct sums sums = idle(10 * SECOND);

	for (uint8_t link = 0; link < 2; link++) {
		zassert_equal(sums.heartbeats[link], 10);
		zassert_equal(sums.attitudes[link], 50, "younger than a second, always");
	}
}

ZTEST(mavlink_gimbal, test_information_has_real_limits)
{
	struct gimbal_event event = {.kind = GIMBAL_EVENT_CONFIG, .config = gimbal->config};
	mavlink_gimbal_device_information_t info;

	event.config.axes[GIMBAL_PAN].min_mdeg = -45000;
	event.config.axes[GIMBAL_TILT].max_mdeg = 30000;
	gimbal_step(gimbal, now_us, &event);
	asked(283, &info, sizeof(info));
	zassert_within(info.yaw_min, -0.785398f, 1e-5f);
	zassert_within(info.yaw_max, 1.570796f, 1e-5f);
	zassert_within(info.pitch_min, -1.570796f, 1e-5f);
	zassert_within(info.pitch_max, 0.523599f, 1e-5f);
	zassert_equal(info.roll_min, 0.0f);
	zassert_equal(info.roll_max, 0.0f);
	/* retract 1, neutral 2, pitch axis 32 follow 64 lock 128, yaw 256 512 1024, north 4096 */
	zassert_equal(info.cap_flags, 6115);
	zassert_equal(info.cap_flags2, 6115);
	zassert_equal(info.firmware_version, 0x00030201); /* 1.2.3, the major number lowest */
	zassert_true(info.uid == UINT64_C(0x0123456789abcdef));
	zassert_mem_equal(info.vendor_name, "Pharos", 7);
	zassert_equal(info.gimbal_device_id, 0);
}

ZTEST(mavlink_gimbal, test_general_messages_and_commands)
{
	mavlink_component_information_basic_t basic;
	mavlink_message_interval_t interval;

	asked(396, &basic, sizeof(basic));
	zassert_mem_equal(basic.vendor_name, "Pharos", 7);
	zassert_equal(ORDER(511, 285, 20000), MAV_RESULT_ACCEPTED);
	zassert_equal(ORDER(510, 285), MAV_RESULT_ACCEPTED);

	const struct mavlink_frame frame = sent(1);

	mavlink_frame_payload(&frame, &interval, sizeof(interval));
	zassert_equal(interval.interval_us, 20000);
	zassert_equal(ORDER(512, 440), MAV_RESULT_DENIED); /* the light's */
	zassert_equal(ORDER(405, 1), MAV_RESULT_UNSUPPORTED);
	zassert_equal(ORDER(1000, 0), MAV_RESULT_UNSUPPORTED, "for gimbal managers");
}

/* --- mount commands --------------------------------------------------------------------------- */

ZTEST(mavlink_gimbal, test_mount_control_points_in_degrees)
{
	zassert_equal(ORDER(205, -30, 0, 45, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	pass(SECOND);
	assert_at(45000, -30000);
	zassert_equal(ORDER(205, -30.5f, 12, -45.25f, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	pass(SECOND);
	assert_at(-45250, -30500); /* and the roll of 12 changes nothing */
}

/* ArduPilot's SToRM32 driver sends -pitch and -yaw. */
ZTEST(mavlink_gimbal, test_signs_of_mount_control_are_a_parameter)
{
	static const struct {
		int32_t sign, pan_mdeg, tilt_mdeg;
	} cases[] = {
		{0, 20000, 10000}, {1, 20000, -10000}, {2, -20000, 10000}, {3, -20000, -10000}};

	for (size_t i = 0; i < ARRAY_SIZE(cases); i++) {
		device_params->values[PARAM_GMB_MNT_SIGN] = cases[i].sign;
		zassert_equal(ORDER(205, 10, 0, 20, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
		pass(SECOND);
		assert_at(cases[i].pan_mdeg, cases[i].tilt_mdeg);
	}
}

ZTEST(mavlink_gimbal, test_mount_control_retracts_and_centres)
{
	zassert_equal(ORDER(205, NAN, NAN, NAN, 0, 0, 0, 0), MAV_RESULT_ACCEPTED);
	pass(SECOND);
	assert_at(0, -90000);
	zassert_equal(status().flags & 3, 1);
	zassert_equal(ORDER(205, NAN, NAN, NAN, 0, 0, 0, 1), MAV_RESULT_ACCEPTED);
	pass(SECOND);
	assert_at(0, 0);
	zassert_equal(status().flags & 3, 2);
}

ZTEST(mavlink_gimbal, test_mount_control_refuses_bad_numbers)
{
	static const float bad[] = {NAN, INFINITY, -INFINITY, 360.5f, -1e9f};

	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_equal(ORDER(205, bad[i], 0, 10, 0, 0, 0, 2), MAV_RESULT_DENIED);
		zassert_equal(ORDER(205, 10, bad[i], 10, 0, 0, 0, 2), MAV_RESULT_DENIED);
		zassert_equal(ORDER(205, 10, 0, bad[i], 0, 0, 0, 2), MAV_RESULT_DENIED);
		zassert_equal(ORDER(205, 10, 0, 10, 0, 0, 0, bad[i]), MAV_RESULT_DENIED);
	}
	zassert_equal(ORDER(205, 10, 0, 10, 0, 0, 0, 3), MAV_RESULT_DENIED, "RC_TARGETING");
	zassert_equal(ORDER(205, 10, 0, 10, 0, 0, 0, 1.5f), MAV_RESULT_DENIED);
	pass(SECOND);
	assert_at(0, 0);
	zassert_equal(gimbal_arbiter->commander, ARBITER_SOURCE_NONE);
}

ZTEST(mavlink_gimbal, test_mount_configure_chooses_what_the_inputs_are)
{
	vehicle_attitude(0, 0, 0);
	/* pitch a rate, yaw an angle of the earth */
	zassert_equal(ORDER(204, 2, 0, 0, 0, 0, 1, 2), MAV_RESULT_ACCEPTED);
	pass(SECOND / 10);
	assert_at(0, 0);
	vehicle_attitude(0, 0, 0.34906585f); /* 20 degrees to the right */
	zassert_equal(ORDER(205, -10, 0, 30, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	pass(SECOND / 2);
	assert_at(10000, -5000);
	/* both stabilized */
	zassert_equal(ORDER(204, 2, 1, 1, 1, 0, 0, 0), MAV_RESULT_ACCEPTED);
	vehicle_attitude(0, 0.17453293f, 0); /* 10 degrees up */
	zassert_equal(ORDER(205, 0, 0, 0, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	pass(SECOND / 2);
	assert_at(0, -10000);
}

ZTEST(mavlink_gimbal, test_mount_configure_retracts_and_refuses)
{
	zassert_equal(ORDER(204, 0), MAV_RESULT_ACCEPTED);
	pass(SECOND);
	assert_at(0, -90000);
	zassert_equal(ORDER(204, 1, NAN, NAN, NAN, NAN, NAN, NAN), MAV_RESULT_ACCEPTED);
	pass(SECOND);
	assert_at(0, 0);
	zassert_equal(ORDER(204, NAN), MAV_RESULT_DENIED);
	zassert_equal(ORDER(204, 3), MAV_RESULT_DENIED);
	zassert_equal(ORDER(204, 2, 2), MAV_RESULT_DENIED);
	zassert_equal(ORDER(204, 2, 0, 0.5f), MAV_RESULT_DENIED);
	zassert_equal(ORDER(204, 2, 0, 0, 0, 0, 3), MAV_RESULT_DENIED);
}

ZTEST(mavlink_gimbal, test_who_may_not_point_is_told)
{
	const struct arbiter_config config = {.priority = ARBITER_SOURCE_DRONECAN,
	                                      .hold_us = SECOND};

	device.security.excluded = ARBITER_SOURCE_BIT(ARBITER_SOURCE_MAVLINK);
	zassert_equal(ORDER(205, 10, 0, 10, 0, 0, 0, 2), MAV_RESULT_DENIED);
	set_attitude((struct setpoint){.q = {H, 0, 0, H}, .rates = NO_RATES});
	zassert_equal(its.stats.refused, 1);
	device.security.excluded = 0;
	arbiter_configure(gimbal_arbiter, &config);
	arbiter_commit(gimbal_arbiter, now_us, ARBITER_SOURCE_DRONECAN);
	zassert_equal(ORDER(205, 10, 0, 10, 0, 0, 0, 2), MAV_RESULT_TEMPORARILY_REJECTED);
	pass(SECOND);
	assert_at(0, 0);
	zassert_equal(ORDER(205, 10, 0, 10, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	zassert_equal(gimbal_arbiter->commander, ARBITER_SOURCE_MAVLINK);
}

/* --- GIMBAL_DEVICE_SET_ATTITUDE --------------------------------------------------------------- */

ZTEST(mavlink_gimbal, test_angle_by_quaternion)
{
	const float q[4] = {H * C, H * S, -H * S, H * C}; /* right 90, down 45 */

	set_attitude((struct setpoint){.q = {H * C, H * S, -H * S, H * C}, .rates = NO_RATES});
	pass(SECOND);
	assert_at(90000, -45000);

	const mavlink_gimbal_device_attitude_status_t is = status();

	assert_q(&is, q);
	zassert_equal(is.time_boot_ms, 1000);
	zassert_equal(is.flags, 32 | 128); /* yaw in the vehicle's frame; takes that of the earth */
	zassert_equal(is.failure_flags, 0);
	zassert_true(isnan(is.delta_yaw));
	zassert_equal(its.stats.set, 1);
}

ZTEST(mavlink_gimbal, test_its_own_frames_coming_back_are_left)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const mavlink_command_long_t wire = {.param1 = -30, .command = 205, .target_system = 1};

	say(1, 155, &kind, &wire); /* another gimbal of the vehicle's */
	zassert_equal(endpoint.links[1].stats.rx_echoes, 0);
	say(1, 154, &kind, &wire);
	zassert_equal(endpoint.links[1].stats.rx_echoes, 1);
	zassert_equal(out.count, 0);
}

ZTEST(mavlink_gimbal, test_rates_when_there_is_no_quaternion)
{
	for (int i = 0; i < 5; i++) { /* at 10 Hz: 0.1 and -0.2 rad/s for half a second */
		set_attitude((struct setpoint){.q = NO_Q, .rates = {0, -0.2f, 0.1f}});
		pass(SECOND / 10);
	}
	assert_at(2865, -5730);
	set_attitude((struct setpoint){.q = NO_Q, .rates = {NAN, NAN, 0.1f}});
	pass(SECOND / 10);
	assert_at(3438, -5730); /* an axis without a rate holds */
	const mavlink_gimbal_device_attitude_status_t is = status();

	zassert_within(is.angular_velocity_z, 0.1f, 1e-3f);
	zassert_within(is.angular_velocity_y, 0.0f, 1e-6f);
}

ZTEST(mavlink_gimbal, test_of_angle_and_rates_the_angle_counts)
{
	set_attitude((struct setpoint){.q = {H, 0, 0, H}, .rates = {0, 0.1f, -0.1f}});
	pass(SECOND);
	assert_at(90000, 0);
}

ZTEST(mavlink_gimbal, test_retract_goes_before_neutral_and_both_before_the_rest)
{
	set_attitude((struct setpoint){.flags = 1 | 2 | 28, .q = NO_Q, .rates = {0, 0, 0}});
	pass(SECOND);
	assert_at(0, -90000);
	set_attitude((struct setpoint){.flags = 2 | 28, .q = {H, 0, 0, H}, .rates = NO_RATES});
	pass(SECOND);
	assert_at(0, 0);
}

ZTEST(mavlink_gimbal, test_lock_bits_count_from_the_earth)
{
	/* the vehicle heads 30 degrees, nose up 10 */
	vehicle_attitude(0, 0.17453293f, 0.52359878f);
	set_attitude((struct setpoint){.flags = 28, .q = {1, 0, 0, 0}, .rates = NO_RATES});
	pass(SECOND / 2);
	/* north at the horizon, from there: 30 to the left; asin(cos 30 sin -10), -atan(tan 30 /
	 * cos 10)
	 */
	assert_at(-30382, -8649);

	const mavlink_gimbal_device_attitude_status_t is = status();

	zassert_equal(is.flags, 28 | 64 | 128);
	assert_q(&is, (const float[4]){1, 0, 0, 0});
	zassert_within(is.delta_yaw, 0.52359878f, 1e-4f);
	zassert_true(isnan(is.angular_velocity_z));
}

ZTEST(mavlink_gimbal, test_frame_flags_say_what_yaw_counts_from)
{
	static const struct {
		uint16_t flags;
		int32_t pan_mdeg; /* of yaw 45, the heading is 30 */
	} cases[] = {
		{0, 45000},  {16, 15000},      {32, 45000},
		{64, 15000}, {16 | 32, 45000}, {16 | 64, 15000},
	};

	for (size_t i = 0; i < ARRAY_SIZE(cases); i++) {
		vehicle_attitude(0, 0, 0.52359878f);
		set_attitude((struct setpoint){
			.flags = cases[i].flags, .q = {C, 0, 0, S}, .rates = NO_RATES});
		pass(SECOND * 9 / 10);
		assert_at(cases[i].pan_mdeg, 0);
		zassert_equal(status().flags & 16, cases[i].flags & 16);
	}
	/* held against north when the vehicle turns to 60 */
	set_attitude((struct setpoint){.flags = 16 | 32, .q = {C, 0, 0, S}, .rates = NO_RATES});
	vehicle_attitude(0, 0, 1.04719755f);
	pass(SECOND / 2);
	assert_at(15000, 0);
}

ZTEST(mavlink_gimbal, test_bad_numbers_are_refused_and_counted)
{
	static const struct setpoint bad[] = {
		{.q = {0, 0, 0, 0}, .rates = NO_RATES},
		{.q = {0.5f, 0, 0, 0}, .rates = NO_RATES},
		{.q = {2, 0, 0, 0}, .rates = NO_RATES},
		{.q = {NAN, 0, 0, 1}, .rates = NO_RATES},
		{.q = {1, 0, 0, NAN}, .rates = NO_RATES},
		{.q = {INFINITY, 0, 0, 0}, .rates = NO_RATES},
		{.q = NO_Q, .rates = {0, INFINITY, 0}},
		{.q = NO_Q, .rates = {0, 0, -INFINITY}},
		{.q = NO_Q, .rates = {INFINITY, 0, 0}},
		{.q = NO_Q, .rates = {0, 36, 0}},
		{.q = {1, 0, 0, 0}, .rates = {0, 0, 1e30f}},
		{.flags = 32 | 64, .q = {1, 0, 0, 0}, .rates = NO_RATES},
		{.flags = 64, .q = {1, 0, 0, 0}, .rates = NO_RATES}, /* heading not known */
	};

	ORDER(205, 10, 0, 20, 0, 0, 0, 2);
	pass(SECOND);
	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		set_attitude(bad[i]);
		zassert_equal(its.stats.bad, i + 1, "%u", (unsigned int)i);
	}
	pass(SECOND);
	assert_at(20000, 10000);
	zassert_equal(its.stats.set, 0);
}

ZTEST(mavlink_gimbal, test_limits_and_faults_show_in_failure_flags)
{
	set_attitude((struct setpoint){.q = {0, 0, 0, 1}, .rates = NO_RATES}); /* backwards */
	pass(SECOND);
	assert_at(90000, 0);
	zassert_equal(status().failure_flags, 4); /* AT_YAW_LIMIT */
	ORDER(205, 100, 0, 0, 0, 0, 0, 2);
	zassert_equal(status().failure_flags, 2); /* AT_PITCH_LIMIT */
	ORDER(205, 0, 0, 0, 0, 0, 0, 2);
	zassert_equal(status().failure_flags, 0);
	gimbal->fault = true;
	zassert_equal(status().failure_flags, 32); /* MOTOR_ERROR */
	gimbal->fault = false;
	set_attitude((struct setpoint){.flags = 28, .q = {1, 0, 0, 0}, .rates = NO_RATES});
	zassert_equal(status().failure_flags, 128); /* COMMS_ERROR: no attitude of the vehicle */
	zassert_equal(status().flags & 28, 0);
}

ZTEST(mavlink_gimbal, test_set_attitude_for_another_is_left)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(GIMBAL_DEVICE_SET_ATTITUDE);
	mavlink_gimbal_device_set_attitude_t wire = {
		.flags = 1, .target_system = 1, .target_component = 171};

	say(1, 1, &kind, &wire);
	wire.target_component = 154;
	wire.target_system = 2;
	say(1, 1, &kind, &wire);
	zassert_equal(gimbal->mode, GIMBAL_MODE_NEUTRAL);
	wire.target_system = 0;
	say(1, 1, &kind, &wire);
	zassert_equal(gimbal->mode, GIMBAL_MODE_RETRACTED);
}

ZTEST(mavlink_gimbal, test_mount_orientation_for_older_ground_stations)
{
	mavlink_mount_orientation_t mount;

	vehicle_attitude(0, 0, 0.52359878f);
	ORDER(205, -20, 0, 10, 0, 0, 0, 2);
	pass(SECOND / 2);
	asked(265, &mount, sizeof(mount));
	zassert_equal(mount.roll, 0.0f);
	zassert_within(mount.pitch, -20.0f, 0.01f);
	zassert_within(mount.yaw, 10.0f, 0.01f);
	zassert_within(mount.yaw_absolute, 40.0f, 0.01f);
}
