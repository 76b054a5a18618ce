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
	zassert_true(light->settings.enable);
}

ZTEST(mavlink_addressing, test_answer_equals_pymavlink_in_version_1)
{
	receive(1, COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
	zassert_equal(out.count, 1);
	assert_sent(0, 1, ACK_ON_V1, sizeof(ACK_ON_V1));
	zassert_true(light->settings.enable);
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
		zassert_equal(light->settings.enable, table[i].answered);
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

/* A message from anyone in any version. */
static void receive_from(uint8_t link, const struct mavlink_sender *who,
                         const struct mavlink_kind *kind, const void *payload)
{
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(link, bytes, mavlink_frame_build(bytes, who, kind, payload));
}

static const struct mavlink_sender old_ground = {
	.version = 1, .system_id = 255, .component_id = 190};

static void ask_in_version_1(uint16_t id, float first, float second)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const mavlink_command_long_t wire = {.param1 = first,
	                                     .param2 = second,
	                                     .command = id,
	                                     .target_system = 1,
	                                     .target_component = 243};

	receive_from(0, &old_ground, &kind, &wire);
}

/* The handshake of mavlink.io/en/guide/mavlink_version.html, by ArduPilot's own bytes. */
ZTEST(mavlink_addressing, test_version_1_handshake_is_answered_in_version_2)
{
	static const uint8_t heartbeat[] = {0xFE, 0x09, 0x00, 0xFF, 0xBE, 0x00, 0x00, 0x00, 0x00,
	                                    0x00, 0x06, 0x08, 0x00, 0x04, 0x03, 0x49, 0x21};
	/* REQUEST_MESSAGE, param1 300, to 1/243 */
	static const uint8_t question[] = {
		0xFE, 0x21, 0x01, 0xFF, 0xBE, 0x4C, 0x00, 0x00, 0x96, 0x43, 0x00, 0x00, 0x00, 0x00,
		0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
		0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x01, 0xF3, 0x00, 0x28, 0x39};
	mavlink_protocol_version_t version;
	mavlink_command_ack_t ack;

	receive(0, heartbeat, sizeof(heartbeat));
	receive(0, question, sizeof(question));
	zassert_equal(out.count, 2);
	sent_payload(0, 77, &ack, sizeof(ack));
	zassert_equal(ack.result, MAV_RESULT_ACCEPTED);
	zassert_equal(sent(0).version, 1);
	sent_payload(1, 300, &version, sizeof(version));
	zassert_equal(sent(1).version, 2);
	zassert_equal(version.version, 100, "the link still is one of version 1");
	zassert_equal(version.max_version, 200);
}

ZTEST(mavlink_addressing, test_what_only_version_2_carries_comes_when_asked_for)
{
	static const uint16_t messages[] = {300, 396, 397, 440};

	for (size_t i = 0; i < ARRAY_SIZE(messages); i++) {
		ask_in_version_1(512, messages[i], 0.0f);
		zassert_equal(out.count, 2, "message %u", messages[i]);
		zassert_equal(sent(1).message_id, messages[i]);
		zassert_equal(sent(1).version, 2);
	}
	ask_in_version_1(512, 148, 0.0f); /* AUTOPILOT_VERSION fits version 1 */
	zassert_equal(out.count, 2);
	zassert_equal(sent(1).version, 1);
}

ZTEST(mavlink_addressing, test_stream_that_version_1_asked_for_comes_in_version_2)
{
	struct tally tally;

	ask_in_version_1(511, 440.0f, 500000.0f);
	zassert_equal(out.count, 1);
	tally = run_until(2 * SECOND + 1);
	zassert_equal(tally.statuses[0], 4);
	zassert_equal(tally.heartbeats[0], 3);

	/* whoever comes after a link was down has not asked */
	mavlink_endpoint_link_down(&endpoint, 0);
	mavlink_endpoint_link_up(&endpoint, now_us, 0);
	ask_in_version_1(405, 1.0f, 0.0f);
	tally = run_until(4 * SECOND + 1);
	zassert_equal(tally.statuses[0], 0);
	zassert_equal(tally.heartbeats[0], 3);
}

ZTEST(mavlink_addressing, test_message_for_all_links_keeps_to_their_versions)
{
	const mavlink_command_long_t wire = {.param1 = 440,
	                                     .param7 = 2,
	                                     .command = 512,
	                                     .target_system = 1,
	                                     .target_component = 243};
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	static const struct mavlink_kind heartbeat_kind = MAVLINK_KIND(HEARTBEAT);
	const mavlink_heartbeat_t heartbeat = {.type = MAV_TYPE_GCS};

	receive_from(1, &old_ground, &heartbeat_kind, &heartbeat);
	receive_from(0, &old_ground, &kind, &wire);
	zassert_equal(out.count, 2, "nobody on link 1 asked for it");
	zassert_equal(out.frames[1].link, 0);
	zassert_equal(sent(1).version, 2);
}

/* What relays say about themselves, in whichever version, is not what their peers speak. */
ZTEST(mavlink_addressing, test_relays_have_no_say_in_the_version)
{
	static const struct mavlink_kind radio_status = MAVLINK_KIND(RADIO_STATUS);
	static const struct mavlink_kind radio = {
		.id = 166, .crc_extra = 21, .min_length = 9, .length = 9}; /* ardupilotmega.xml */
	static const struct mavlink_kind heartbeat = MAVLINK_KIND(HEARTBEAT);
	static const struct {
		const struct mavlink_kind *kind;
		uint8_t component;
		bool is_peer;
	} table[] = {
		{&radio_status, 68, false}, /* SiK: system '3', component 'D' */
		{&radio_status, 1, false},  /* a modem with the vehicle's ids */
		{&radio, 68, false},        /* older firmware */
		{&heartbeat, 68, false},    /* mLRS */
		{&heartbeat, 240, false},   /* MAVLink bridges of ESP8266 and ESP32 */
		{&heartbeat, 241, false},   {&heartbeat, 242, false},
		{&heartbeat, 191, false}, /* mavp2p: 125/191, a ground station, version 1 */
		{&heartbeat, 194, false},   {&heartbeat, 195, true},
		{&heartbeat, 190, true},    {&heartbeat, 1, true},
	};
	const mavlink_heartbeat_t payload = {.type = MAV_TYPE_GCS};

	for (size_t i = 0; i < ARRAY_SIZE(table); i++) {
		for (uint8_t version = 1; version <= 2; version++) {
			const struct mavlink_sender who = {.version = version,
			                                   .system_id = 51,
			                                   .component_id = table[i].component};

			fixture_before(NULL);
			receive_from(0, &who, table[i].kind, &payload);
			zassert_equal(endpoint.links[0].version, table[i].is_peer ? version : 0,
			              "row %zu, version %u", i, version);
			zassert_equal(endpoint.links[0].stats.rx_frames, 1);
		}
	}
}

/* An onboard computer that commands the light is a peer. */
ZTEST(mavlink_addressing, test_onboard_computer_that_commands_decides_the_version)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const mavlink_command_long_t wire = {
		.param1 = 1, .command = 405, .target_system = 1, .target_component = 243};
	const struct mavlink_sender who = {.version = 1, .system_id = 1, .component_id = 191};

	receive_from(0, &who, &kind, &wire);
	zassert_equal(out.count, 1);
	zassert_equal(sent(0).version, 1);
}

/* A router that goes on, while the ground station behind it has gone, is no sign of life. */
ZTEST(mavlink_addressing, test_relays_heartbeat_is_no_commanders)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(HEARTBEAT);
	const mavlink_heartbeat_t payload = {.type = MAV_TYPE_GCS};
	const struct arbiter_config config = {.loss_us = SECOND,
	                                      .fallback = ILLUMINATOR_FALLBACK_OFF,
	                                      .priority = ARBITER_SOURCE_NONE};
	struct mavlink_sender who = {.version = 2, .system_id = 125, .component_id = 191};

	arbiter_configure(arbiter, &config);
	zassert_equal(COMMAND(405, 1), MAV_RESULT_ACCEPTED);
	now_us = SECOND / 2;
	receive_from(0, &who, &kind, &payload);
	zassert_equal(arbiter_deadline_us(arbiter), SECOND);
	who.component_id = 190;
	receive_from(0, &who, &kind, &payload);
	zassert_equal(arbiter_deadline_us(arbiter), SECOND * 3 / 2);
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
	zassert_false(light->settings.enable);
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
	gimbal.tell = NULL;
	mavlink_endpoint_add(&endpoint, now_us, 154, &gimbal, &service);

	receive_long(0, 1, 154, 405, (struct command_params){{1}});
	zassert_equal(out.count, 1);
	zassert_equal(sent(0).component_id, 154);
	zassert_false(light->settings.enable);

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
	gimbal.tell = NULL;
	mavlink_endpoint_add(&endpoint, now_us, 154, &gimbal, &service);

	receive_long(0, 0, 0, 405, (struct command_params){{1}});
	zassert_equal(out.count, 1);
	sent_payload(0, 77, &ack, sizeof(ack));
	zassert_equal(ack.result, MAV_RESULT_ACCEPTED);
	zassert_true(light->settings.enable);
	receive_long(0, 0, 0, 512, (struct command_params){{440}});
	zassert_equal(out.count, 2, "an answer and the message");
	receive_long(0, 0, 0, 512, (struct command_params){{0}});
	zassert_equal(out.count, 4, "both have a heartbeat");
	zassert_equal(sent(2).component_id, 154);
}

/* To all, the answer to what is unknown here is for those that know it to give. */
ZTEST(mavlink_addressing, test_unknown_command_to_all_meets_silence)
{
	/* COMPONENT_ARM_DISARM to 1/0, as MAVSDK sends it */
	static const uint8_t arm[] = {0xFD, 0x21, 0x00, 0x00, 0x01, 0xFF, 0xBE, 0x4C, 0x00,
	                              0x00, 0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0x00,
	                              0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
	                              0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
	                              0x00, 0x00, 0x90, 0x01, 0x01, 0x00, 0x00, 0xC7, 0x89};
	static const struct {
		uint16_t id;
		float p[4];
		uint8_t by_name; /* the answer when the light is addressed */
	} table[] = {
		{31999, {0}, MAV_RESULT_UNSUPPORTED},
		{512, {31999}, MAV_RESULT_DENIED},
		{511, {30, 100000}, MAV_RESULT_DENIED},   /* ATTITUDE */
		{510, {30}, MAV_RESULT_ACCEPTED},         /* "not available" */
		{246, {1, 0, 0, 0}, MAV_RESULT_DENIED},   /* reboots the autopilot */
		{246, {0, 0, 1, 100}, MAV_RESULT_DENIED}, /* reboots a camera */
		{245, {3}, MAV_RESULT_DENIED},            /* resets the sensors' parameters */
		{31010, {7}, MAV_RESULT_DENIED},          /* another maker's USER_1 */
	};

	receive(0, arm, sizeof(arm));
	zassert_equal(out.count, 0);
	for (size_t i = 0; i < ARRAY_SIZE(table); i++) {
		struct command_params params = {0};

		memcpy(params.p, table[i].p, sizeof(table[i].p));
		receive_long(0, 0, 0, table[i].id, params);
		zassert_equal(out.count, 0, "row %zu", i);
		receive_long(0, 1, 0, table[i].id, params);
		zassert_equal(out.count, 0, "row %zu", i);
		zassert_equal(command(table[i].id, params), table[i].by_name, "row %zu", i);
	}
	zassert_equal(endpoint.links[0].stats.rx_commands, ARRAY_SIZE(table));
	/* what is refused for its value is the light's to refuse */
	receive_long(0, 0, 0, 405, (struct command_params){{2}});
	zassert_equal(out.count, 1);
}

/* A self-test runs: another maker's USER_1 is still not this device's. */
ZTEST(mavlink_addressing, test_anothers_user_1_during_a_self_test_gets_silence)
{
	thermal_report(THERMAL_STATE_NORMAL, THERMAL_FAULT_NONE, 25000);
	zassert_equal(command(31010, (struct command_params){{1}}), MAV_RESULT_IN_PROGRESS);
	receive_long(0, 0, 0, 31010, (struct command_params){{7}});
	zassert_equal(out.count, 0);
	zassert_equal(command(31010, (struct command_params){{7}}), MAV_RESULT_DENIED);
	/* its own, from whoever, is */
	receive_long(0, 0, 0, 31010, (struct command_params){{1, 50}});
	zassert_equal(out.count, 1);
	receive_long(0, 0, 0, 31010, (struct command_params){{1}});
	zassert_equal(out.count, 1);
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
