/* SPDX-License-Identifier: Apache-2.0 */
/* Who is answered, on which link, in which version, in which order. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

ZTEST_SUITE(mavlink_addressing, NULL, NULL, fixture_before, NULL, NULL);

ZTEST(mavlink_addressing, test_answer_equals_pymavlink_in_version_2)
{
	receive(0, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
	zassert_equal(out.count, 1);
	assert_sent(0, 0, ACK_ON_V2, sizeof(ACK_ON_V2));
	zassert_true(light.settings.enable);
}

ZTEST(mavlink_addressing, test_answer_equals_pymavlink_in_version_1)
{
	receive(1, COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
	zassert_equal(out.count, 1);
	assert_sent(0, 1, ACK_ON_V1, sizeof(ACK_ON_V1));
	zassert_true(light.settings.enable);
}

ZTEST(mavlink_addressing, test_targets)
{
	static const struct {
		uint8_t system;
		uint8_t component;
		bool answered;
	} table[] = {
		{1, 243, true},  {0, 0, true},    {1, 0, true},  {0, 243, true},  {1, 1, false},
		{1, 154, false}, {2, 243, false}, {2, 0, false}, {0, 154, false}, {255, 190, false},
	};

	for (size_t i = 0; i < ARRAY_SIZE(table); i++) {
		fixture_before(NULL);
		receive_long(0, table[i].system, table[i].component, 405,
		             (struct command_params){{1}});
		zassert_equal(out.count, table[i].answered ? 1 : 0, "%u/%u", table[i].system,
		              table[i].component);
		zassert_equal(light.settings.enable, table[i].answered);
	}
}

ZTEST(mavlink_addressing, test_unknown_command_to_another_meets_silence)
{
	receive_long(0, 1, 1, 400, (struct command_params){{1}});
	zassert_equal(out.count, 0);
}

ZTEST(mavlink_addressing, test_answer_goes_to_the_link_it_came_from)
{
	for (uint8_t link = 0; link < 2; link++) {
		receive_long(link, 1, 243, 512, (struct command_params){{396}});
		zassert_equal(out.count, 2);
		zassert_equal(out.frames[0].link, link);
		zassert_equal(out.frames[1].link, link);
	}
}

ZTEST(mavlink_addressing, test_version_1_until_a_version_2_frame_comes)
{
	receive(0, COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
	zassert_equal(sent(0).version, 1);
	/* Message 440 can't be sent in version 1: the stream is silent there, heartbeats are not.
	 */
	struct tally tally = run_until(3 * SECOND + 1);

	zassert_equal(tally.statuses[0], 0);
	zassert_equal(tally.heartbeats[0], 4);
	zassert_equal(tally.statuses[1], 4); /* the other link has heard nothing: version 2 */
	receive(0, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
	zassert_equal(sent(0).version, 2);
	receive(0, COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
	zassert_equal(sent(0).version, 2);
	tally = run_until(6 * SECOND + 1);
	zassert_equal(tally.statuses[0], 3);
}

ZTEST(mavlink_addressing, test_request_that_version_1_cannot_answer_fails)
{
	mavlink_command_ack_t ack;
	mavlink_command_long_t wire = {
		.param1 = 440, .command = 512, .target_system = 1, .target_component = 243};
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const struct mavlink_sender ground = {.version = 1, .system_id = 255, .component_id = 190};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(0, bytes, mavlink_frame_build(bytes, &ground, &kind, &wire));
	zassert_equal(out.count, 1);
	sent_payload(0, 77, &ack, sizeof(ack));
	zassert_equal(ack.result, MAV_RESULT_FAILED);
}

ZTEST(mavlink_addressing, test_each_link_has_its_own_sequence)
{
	for (int i = 0; i < 300; i++) {
		receive_long(0, 1, 243, 405, (struct command_params){{1}});
		zassert_equal(sent(0).sequence, i % 256);
	}
	receive_long(1, 1, 243, 405, (struct command_params){{1}});
	zassert_equal(sent(0).sequence, 0);
}

ZTEST(mavlink_addressing, test_own_frames_coming_back_are_left)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const mavlink_command_long_t wire = {.param1 = 1, .command = 405};
	const struct mavlink_sender self = {.version = 2, .system_id = 1, .component_id = 243};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(0, bytes, mavlink_frame_build(bytes, &self, &kind, &wire));
	zassert_equal(out.count, 0);
	zassert_false(light.settings.enable);
	zassert_equal(endpoint.links[0].stats.rx_echoes, 1);
}

ZTEST(mavlink_addressing, test_what_is_no_frame_is_counted)
{
	receive(0, COMMAND_ON_V2, sizeof(COMMAND_ON_V2) - 1);
	zassert_equal(out.count, 0);
	zassert_equal(endpoint.links[0].stats.rx_malformed, 1);
	receive(0, COMMAND_ON_V2, 0);
	zassert_equal(endpoint.links[0].stats.rx_malformed, 2);
}

/* Another component of the same device, which knows no command. */
static uint8_t active(const void *unused)
{
	(void)unused;
	return MAV_STATE_ACTIVE;
}

ZTEST(mavlink_addressing, test_two_components_answer_for_themselves)
{
	struct mavlink_profile gimbal = mavlink_illuminator_profile;

	gimbal.type = 26; /* MAV_TYPE_GIMBAL */
	gimbal.command_count = 0;
	gimbal.message_count = 1;
	gimbal.system_status = active;
	gimbal.observe = NULL;
	mavlink_endpoint_add(&endpoint, now_us, 154, &gimbal, &service);

	receive_long(0, 1, 154, 405, (struct command_params){{1}});
	zassert_equal(out.count, 1);
	zassert_equal(sent(0).component_id, 154);
	zassert_false(light.settings.enable);

	receive_long(0, 1, 154, 31999, (struct command_params){{1}});
	zassert_equal(sent(0).sequence, 1); /* a sequence of its own */
}

/* A command to all has one answer of each component that knows it, and no other. */
ZTEST(mavlink_addressing, test_command_to_all_is_for_those_that_know_it)
{
	struct mavlink_profile gimbal = mavlink_illuminator_profile;
	mavlink_command_ack_t ack;

	gimbal.message_count = 1; /* HEARTBEAT */
	gimbal.command_count = 3; /* those about messages */
	gimbal.observe = NULL;
	mavlink_endpoint_add(&endpoint, now_us, 154, &gimbal, &service);

	receive_long(0, 0, 0, 405, (struct command_params){{1}});
	zassert_equal(out.count, 1);
	sent_payload(0, 77, &ack, sizeof(ack));
	zassert_equal(ack.result, MAV_RESULT_ACCEPTED);
	zassert_true(light.settings.enable);
	receive_long(0, 0, 0, 512, (struct command_params){{440}});
	zassert_equal(out.count, 2, "an answer and the message");
	receive_long(0, 0, 0, 512, (struct command_params){{0}});
	zassert_equal(out.count, 4, "both have a heartbeat");
	zassert_equal(sent(2).component_id, 154);
	receive_long(0, 0, 0, 31999, (struct command_params){{0}});
	zassert_equal(out.count, 1);
	sent_payload(0, 77, &ack, sizeof(ack));
	zassert_equal(ack.result, MAV_RESULT_UNSUPPORTED);
	receive_long(0, 0, 0, 512, (struct command_params){{31999}});
	zassert_equal(out.count, 1);
	sent_payload(0, 77, &ack, sizeof(ack));
	zassert_equal(ack.result, MAV_RESULT_DENIED);
}

ZTEST(mavlink_addressing, test_ping_to_all_is_answered_to_the_asker)
{
	receive(0, PING_QUESTION, sizeof(PING_QUESTION));
	zassert_equal(out.count, 1);
	assert_sent(0, 0, PING_ANSWER, sizeof(PING_ANSWER));
}

ZTEST(mavlink_addressing, test_ping_answer_is_not_answered)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(PING);
	const mavlink_ping_t answer = {.seq = 1, .target_system = 1, .target_component = 243};

	receive_message(0, &kind, &answer);
	zassert_equal(out.count, 0);
}

ZTEST(mavlink_addressing, test_timesync_mirrors_and_adds_our_clock)
{
	mavlink_timesync_t sync;

	now_us = 42000001;
	receive(1, TIMESYNC_QUESTION, sizeof(TIMESYNC_QUESTION));
	zassert_equal(out.count, 1);
	zassert_equal(out.frames[0].link, 1);
	sent_payload(0, 111, &sync, sizeof(sync));
	zassert_equal(sync.tc1, INT64_C(42000001000)); /* ns */
	zassert_equal(sync.ts1, INT64_C(555666777888));
	/* Extension fields target_system, target_component: bytes 16 and 17. */
	const struct mavlink_frame frame = sent(0);

	zassert_equal(mavlink_frame_byte(&frame, 16), 255);
	zassert_equal(mavlink_frame_byte(&frame, 17), 190);
}

ZTEST(mavlink_addressing, test_timesync_answer_is_not_answered)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(TIMESYNC);
	const mavlink_timesync_t answer = {.tc1 = 1, .ts1 = 2};

	receive_message(0, &kind, &answer);
	zassert_equal(out.count, 0);
}
