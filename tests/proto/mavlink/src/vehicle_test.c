/* SPDX-License-Identifier: Apache-2.0 */
/* The system id: which heartbeats count, one vehicle and several, and what is said about it. */
#include "fixture.h"

static void before(void *unused)
{
	const struct mavlink_endpoint_config config = {
		.system_id = 1, .adopt = true, .links = 0x03};

	fixture_before(unused);
	mavlink_endpoint_init(&endpoint, &config);
	mavlink_endpoint_add(&endpoint, 0, 243, &mavlink_illuminator_profile, &service);
	run_until(0);
}

ZTEST_SUITE(mavlink_vehicle, NULL, NULL, before, NULL, NULL);

static void heartbeat(uint8_t link, uint8_t system, uint8_t component, uint8_t type,
                      uint8_t autopilot)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(HEARTBEAT);
	const struct mavlink_sender sender = {
		.version = 2, .system_id = system, .component_id = component};
	const mavlink_heartbeat_t wire = {
		.type = type, .autopilot = autopilot, .mavlink_version = 3};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(link, bytes, mavlink_frame_build(bytes, &sender, &kind, &wire));
}

/* MAV_TYPE_QUADROTOR 2, MAV_AUTOPILOT_ARDUPILOTMEGA 3 */
static void autopilot(uint8_t link, uint8_t system)
{
	heartbeat(link, system, 1, 2, 3);
}

/* The last text so far, on link 0. */
static const char *text_until(int64_t until_us)
{
	static char text[51];
	struct tally tally = {0};

	/* frames come from the id that is in force, which the fixture's tally does not expect */
	while (mavlink_endpoint_deadline_us(&endpoint) <= until_us) {
		now_us = mavlink_endpoint_deadline_us(&endpoint);
		mavlink_endpoint_step(&endpoint, now_us, &out);
		for (uint16_t i = 0; i < out.count; i++) {
			const struct mavlink_frame frame = sent(i);

			if (frame.message_id == 253 && out.frames[i].link == 0) {
				mavlink_frame_payload(&frame, &tally.last_text,
				                      sizeof(tally.last_text));
			}
			zassert_equal(frame.system_id, endpoint.config.system_id);
		}
	}
	now_us = until_us;
	memcpy(text, tally.last_text.text, 50);
	return text;
}

ZTEST(mavlink_vehicle, test_the_only_autopilot_within_3_s_is_followed)
{
	autopilot(0, 42);
	zassert_equal(endpoint.vehicle.state, MAVLINK_VEHICLE_DECIDING);
	text_until(3 * SECOND - 1);
	zassert_equal(endpoint.config.system_id, 1);
	zassert_equal(strcmp(text_until(3 * SECOND), "System id is now the vehicle's: 42"), 0);
	zassert_equal(endpoint.config.system_id, 42);
	zassert_equal(endpoint.vehicle.state, MAVLINK_VEHICLE_ADOPTED);
	/* addressed as 42 it answers, as 1 no longer */
	receive_long(0, 42, 243, 405, (struct command_params){{1}});
	zassert_equal(out.count, 1);
	receive_long(0, 1, 243, 405, (struct command_params){{1}});
	zassert_equal(out.count, 0);
}

ZTEST(mavlink_vehicle, test_the_time_begins_with_the_first_autopilot)
{
	text_until(100 * SECOND);
	zassert_equal(endpoint.vehicle.state, MAVLINK_VEHICLE_LISTENING);
	autopilot(0, 255);
	text_until(103 * SECOND - 1);
	zassert_equal(endpoint.config.system_id, 1);
	zassert_equal(strcmp(text_until(103 * SECOND), "System id is now the vehicle's: 255"), 0);
}

ZTEST(mavlink_vehicle, test_one_autopilot_on_several_links_is_one)
{
	autopilot(0, 7);
	autopilot(1, 7);
	text_until(2 * SECOND);
	autopilot(1, 7);
	text_until(3 * SECOND);
	zassert_equal(endpoint.config.system_id, 7);
}

ZTEST(mavlink_vehicle, test_several_leave_what_is_configured_and_are_told)
{
	autopilot(0, 7);
	text_until(3 * SECOND - 1);
	autopilot(1, 8); /* 1 us before the time is over */
	zassert_equal(strcmp(text_until(3 * SECOND), "Several vehicles heard, system id stays 1"),
	              0);
	zassert_equal(endpoint.config.system_id, 1);
	zassert_equal(endpoint.vehicle.state, MAVLINK_VEHICLE_SEVERAL);
	autopilot(0, 7);
	text_until(60 * SECOND);
	zassert_equal(endpoint.config.system_id, 1);
}

ZTEST(mavlink_vehicle, test_a_vehicle_that_comes_later_does_not_get_the_light)
{
	autopilot(0, 7);
	text_until(3 * SECOND);
	autopilot(0, 8);
	text_until(60 * SECOND);
	zassert_equal(endpoint.config.system_id, 7);
	zassert_equal(mavlink_endpoint_deadline_us(&endpoint), 61 * SECOND);
}

ZTEST(mavlink_vehicle, test_a_vehicle_with_the_configured_id_is_no_news)
{
	autopilot(0, 1);
	zassert_equal(text_until(10 * SECOND)[0], '\0');
	zassert_equal(endpoint.vehicle.state, MAVLINK_VEHICLE_ADOPTED);
}

ZTEST(mavlink_vehicle, test_who_is_no_autopilot_does_not_count)
{
	heartbeat(0, 255, 190, 6, 8); /* a ground station */
	heartbeat(0, 9, 1, 6, 8);     /* one with component 1 */
	heartbeat(0, 9, 1, 6, 3);     /* one that claims an autopilot */
	heartbeat(0, 9, 154, 26, 8);  /* a gimbal */
	heartbeat(0, 9, 1, 26, 8);    /* one with component 1 */
	heartbeat(0, 9, 191, 18, 8);  /* a companion computer */
	heartbeat(0, 9, 1, 18, 3);    /* the same as component 1 */
	heartbeat(0, 9, 2, 2, 3);     /* an autopilot's other component */
	heartbeat(0, 9, 1, 5, 3);     /* an antenna tracker */
	heartbeat(0, 0, 1, 2, 3);     /* nobody's id */
	zassert_equal(endpoint.vehicle.state, MAVLINK_VEHICLE_LISTENING);
	text_until(10 * SECOND);
	zassert_equal(endpoint.config.system_id, 1);
}

ZTEST(mavlink_vehicle, test_every_kind_of_vehicle_counts)
{
	/* MAV_TYPE: generic, fixed wing, quadrotor, helicopter, rover, boat, submarine, VTOL */
	static const uint8_t types[] = {0, 1, 2, 4, 10, 11, 12, 22};

	for (size_t i = 0; i < sizeof(types); i++) {
		const struct mavlink_vehicle_heartbeat said = {
			.system = 1, .component = 1, .type = types[i], .autopilot = 12 /* PX4 */};

		zassert_true(mavlink_vehicle_is_autopilot(&said), "%u", types[i]);
	}
}

ZTEST(mavlink_vehicle, test_a_configured_id_is_kept)
{
	fixture_before(NULL); /* id 1, adopt false */
	run_until(0);
	autopilot(0, 42);
	text_until(60 * SECOND);
	zassert_equal(endpoint.config.system_id, 1);
	zassert_equal(endpoint.vehicle.state, MAVLINK_VEHICLE_FIXED);
}
