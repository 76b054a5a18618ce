/* SPDX-License-Identifier: Apache-2.0 */
/* The command protocol: one answer to each command, and what it says. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

ZTEST_SUITE(mavlink_command, NULL, NULL, fixture_before, NULL, NULL);

ZTEST(mavlink_command, test_unknown_command_is_unsupported)
{
	/* 400 COMPONENT_ARM_DISARM, 80 COMMAND_CANCEL, one that nobody has defined. */
	zassert_equal(COMMAND(400, 1), MAV_RESULT_UNSUPPORTED);
	zassert_equal(COMMAND(80, 405), MAV_RESULT_UNSUPPORTED);
	zassert_equal(COMMAND(65535, 0), MAV_RESULT_UNSUPPORTED);
	zassert_equal(out.count, 1);
}

ZTEST(mavlink_command, test_command_int_is_accepted_too)
{
	mavlink_command_ack_t ack;

	receive(0, COMMAND_INT_ON, sizeof(COMMAND_INT_ON));
	zassert_equal(out.count, 1);
	sent_payload(0, 77, &ack, sizeof(ack));
	zassert_equal(ack.command, 405);
	zassert_equal(ack.result, MAV_RESULT_ACCEPTED);
	zassert_true(light->settings.enable);
}

ZTEST(mavlink_command, test_command_int_takes_param7_from_z)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_INT);
	mavlink_command_int_t wire = {
		.param1 = 440, .command = 512, .z = 2, .target_system = 1, .target_component = 243};

	receive_message(0, &kind, &wire);
	zassert_equal(out.count, 3); /* acknowledgement, then the message on both links */
	wire.z = 3;
	receive_message(0, &kind, &wire);
	zassert_equal(out.count, 1);
}

ZTEST(mavlink_command, test_repeated_command_is_done_once_and_acknowledged_each_time)
{
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);

	const uint32_t revision = light->revision;

	for (int i = 0; i < 3; i++) {
		zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
		zassert_equal(out.count, 1);
		zassert_false(effects.lights || effects.statuses);
	}
	zassert_equal(light->revision, revision);
}

ZTEST(mavlink_command, test_confirmation_does_not_matter)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);

	for (uint8_t confirmation = 0; confirmation < 3; confirmation++) {
		const mavlink_command_long_t wire = {.param1 = 1,
		                                     .command = 405,
		                                     .target_system = 1,
		                                     .target_component = 243,
		                                     .confirmation = confirmation};

		receive_message(0, &kind, &wire);
		zassert_equal(out.count, 1);
	}
	zassert_equal(light->stats.accepted, 3);
	zassert_equal(light->revision, 1);
}

ZTEST(mavlink_command, test_state_is_in_the_effects_with_its_acknowledgement)
{
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	zassert_equal(effects.lights, 1);
	zassert_true(light->plan.on);
	zassert_equal(out.count, 1);
}

/* --- REQUEST_MESSAGE 512 -----------------------------------------------------------------------
 */

ZTEST(mavlink_command, test_request_each_message_comes_after_the_acknowledgement)
{
	/* HEARTBEAT, ILLUMINATOR_STATUS, COMPONENT_INFORMATION_BASIC, AUTOPILOT_VERSION,
	 * PROTOCOL_VERSION */
	static const uint32_t ids[] = {0, 440, 396, 148, 300};

	for (size_t i = 0; i < ARRAY_SIZE(ids); i++) {
		zassert_equal(COMMAND(512, (float)ids[i]), MAV_RESULT_ACCEPTED);
		zassert_equal(out.count, 2);
		zassert_equal(sent(1).message_id, ids[i]);
	}
}

ZTEST(mavlink_command, test_request_of_a_message_we_do_not_have_is_denied)
{
	/* 280 GIMBAL_MANAGER_INFORMATION (QGroundControl asks everyone), 395, 253 STATUSTEXT, 77 */
	static const float ids[] = {280, 395,    253, 77,       16777215,  16777216,
	                            -1,  440.5f, NAN, INFINITY, -INFINITY, 1e30f};

	for (size_t i = 0; i < ARRAY_SIZE(ids); i++) {
		zassert_equal(COMMAND(512, ids[i]), MAV_RESULT_DENIED);
		zassert_equal(out.count, 1);
	}
}

ZTEST(mavlink_command, test_request_param7_says_who_gets_the_answer)
{
	/* 0 default, 1 requester, NaN not given: the requester. 2: everyone. */
	static const struct {
		float target;
		uint16_t frames;
	} table[] = {{0, 2}, {1, 2}, {NAN, 2}, {2, 3}, {3, 1}, {-1, 1}, {0.5f, 1}, {INFINITY, 1}};

	for (size_t i = 0; i < ARRAY_SIZE(table); i++) {
		const uint8_t result = COMMAND(512, 440, 0, 0, 0, 0, 0, table[i].target);

		zassert_equal(result,
		              table[i].frames == 1 ? MAV_RESULT_DENIED : MAV_RESULT_ACCEPTED);
		zassert_equal(out.count, table[i].frames);
	}
	zassert_equal(COMMAND(512, 440, 0, 0, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	zassert_equal(out.frames[1].link, 0);
	zassert_equal(out.frames[2].link, 1);
	zassert_equal(sent(2).message_id, 440);
}

ZTEST(mavlink_command, test_identity_equals_pymavlink)
{
	now_us = 2 * SECOND;
	zassert_equal(COMMAND(512, 396), MAV_RESULT_ACCEPTED);
	assert_sent(1, 0, BASIC, sizeof(BASIC));
}

ZTEST(mavlink_command, test_identity_strings_are_cut_to_fit_and_end_with_zero)
{
	static const struct mavlink_identity wide = {
		.vendor_name = "0123456789abcdef0123456789abcdefXYZ",
		.model_name = "0123456789abcdef0123456789abcde",
		.software_version = "0123456789abcdef01234567",
		.hardware_version = "",
		.serial_number = "",
	};
	mavlink_component_information_basic_t basic;

	service.identity = &wide;
	zassert_equal(COMMAND(512, 396), MAV_RESULT_ACCEPTED);
	sent_payload(1, 396, &basic, sizeof(basic));
	zassert_equal(strcmp(basic.vendor_name, "0123456789abcdef0123456789abcde"), 0);
	zassert_equal(strcmp(basic.model_name, "0123456789abcdef0123456789abcde"), 0);
	zassert_equal(strcmp(basic.software_version, "0123456789abcdef0123456"), 0);
	zassert_equal(basic.serial_number[0], 0);
	zassert_equal(basic.serial_number[31], 0);
}

ZTEST(mavlink_command, test_capabilities_are_those_that_are_real)
{
	/* MAVLINK2 8192, COMMAND_INT 8; no FTP, no parameters. */
	zassert_equal(COMMAND(512, 148), MAV_RESULT_ACCEPTED);
	assert_sent(1, 0, VERSION_1_2_3, sizeof(VERSION_1_2_3));
	endpoint.components[0].sequence[0] = 0;
	zassert_equal(COMMAND(512, 300), MAV_RESULT_ACCEPTED);
	assert_sent(1, 0, PROTOCOL, sizeof(PROTOCOL));
}

/* --- SET_MESSAGE_INTERVAL 511, GET_MESSAGE_INTERVAL 510, MESSAGE_INTERVAL 244 ------------------
 */

static int32_t interval_by(uint16_t id, float first, float second)
{
	mavlink_message_interval_t interval;

	zassert_equal(COMMAND(id, first, second), MAV_RESULT_ACCEPTED);
	zassert_equal(out.count, 2);
	sent_payload(1, 244, &interval, sizeof(interval));
	zassert_equal(interval.message_id, id == 510 ? first : second);
	return interval.interval_us;
}

ZTEST(mavlink_command, test_interval_message_equals_pymavlink)
{
	zassert_equal(COMMAND(510, 440), MAV_RESULT_ACCEPTED);
	assert_sent(1, 0, INTERVAL_OF_STATUS, sizeof(INTERVAL_OF_STATUS));
}

ZTEST(mavlink_command, test_interval_is_told_by_510_and_by_512_of_244)
{
	static const struct {
		float id;
		int32_t interval_us;
	} table[] = {
		{0, 1000000},   /* heartbeat, 1 Hz */
		{440, 1000000}, /* status, 1 Hz */
		{396, -1},      /* only on request */
		{280, 0},       /* not available */
		{65535, 0},
	};

	for (size_t i = 0; i < ARRAY_SIZE(table); i++) {
		zassert_equal(interval_by(510, table[i].id, 0), table[i].interval_us);
		zassert_equal(interval_by(512, 244, table[i].id), table[i].interval_us);
	}
}

ZTEST(mavlink_command, test_interval_of_an_id_that_no_answer_can_name_is_denied)
{
	static const float ids[] = {65536, -1, 0.5f, NAN, INFINITY};

	for (size_t i = 0; i < ARRAY_SIZE(ids); i++) {
		zassert_equal(COMMAND(510, ids[i]), MAV_RESULT_DENIED);
		zassert_equal(COMMAND(512, 244, ids[i]), MAV_RESULT_DENIED);
		zassert_equal(out.count, 1);
	}
}

ZTEST(mavlink_command, test_set_interval_takes_effect_and_is_told)
{
	zassert_equal(COMMAND(511, 440, 250000), MAV_RESULT_ACCEPTED);
	zassert_equal(out.count, 1);
	zassert_equal(interval_by(510, 440, 0), 250000);
	zassert_equal(COMMAND(511, 440, -1), MAV_RESULT_ACCEPTED);
	zassert_equal(interval_by(510, 440, 0), -1);
	zassert_equal(COMMAND(511, 440, 0), MAV_RESULT_ACCEPTED);
	zassert_equal(interval_by(510, 440, 0), 1000000);
}

ZTEST(mavlink_command, test_set_interval_refuses_and_changes_nothing)
{
	/* Other negatives, broken numbers, faster than 1 ms, longer than 31 bits of µs. */
	static const float bad[] = {-2, -0.5f, -1e9f, NAN, INFINITY, -INFINITY, 0.5f, 999, 3e9f};

	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_equal(COMMAND(511, 440, bad[i]), MAV_RESULT_DENIED);
	}
	zassert_equal(COMMAND(511, 280, 1000000), MAV_RESULT_DENIED);
	zassert_equal(COMMAND(511, NAN, 1000000), MAV_RESULT_DENIED);
	zassert_equal(COMMAND(511, 440, 500000, 0, 0, 0, 0, 3), MAV_RESULT_DENIED);
	zassert_equal(interval_by(510, 440, 0), 1000000);
}

ZTEST(mavlink_command, test_the_heartbeat_cannot_be_changed)
{
	zassert_equal(COMMAND(511, 0, -1), MAV_RESULT_DENIED);
	zassert_equal(COMMAND(511, 0, 100000), MAV_RESULT_DENIED);
	zassert_equal(COMMAND(511, 0, 0), MAV_RESULT_ACCEPTED);
	zassert_equal(COMMAND(511, 0, 1000000), MAV_RESULT_ACCEPTED);
	zassert_equal(interval_by(510, 0, 0), 1000000);
}

ZTEST(mavlink_command, test_set_interval_is_per_link_unless_broadcast)
{
	zassert_equal(COMMAND(511, 440, 250000), MAV_RESULT_ACCEPTED);
	zassert_equal(endpoint.components[0].streams[0][1].interval_us, 250000);
	zassert_equal(endpoint.components[0].streams[1][1].interval_us, 1000000);
	zassert_equal(COMMAND(511, 440, 125000, 0, 0, 0, 0, 2), MAV_RESULT_ACCEPTED);
	zassert_equal(endpoint.components[0].streams[0][1].interval_us, 125000);
	zassert_equal(endpoint.components[0].streams[1][1].interval_us, 125000);
}
