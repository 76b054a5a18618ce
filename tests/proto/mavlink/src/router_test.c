/* SPDX-License-Identifier: Apache-2.0 */
/* Routing: who hears what on which link, and what never goes on. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

#define LINKS 0x0F /* four are up */

static void before(void *unused)
{
	fixture_before(unused);
	for (uint8_t link = 2; link < 4; link++) {
		mavlink_endpoint_link_up(&endpoint, now_us, link);
	}
	mavlink_endpoint_set_routing(&endpoint, true);
}

ZTEST_SUITE(mavlink_router, NULL, NULL, before, NULL, NULL);

static const struct mavlink_kind heartbeat_kind = MAVLINK_KIND(HEARTBEAT);
static const struct mavlink_kind command_kind = MAVLINK_KIND(COMMAND_LONG);

/* A frame from that sender arrives; the links that it is to go on to. */
static uint8_t pass(uint8_t link, uint8_t system, uint8_t component,
                    const struct mavlink_kind *kind, const void *payload)
{
	const struct mavlink_sender sender = {
		.version = 2, .system_id = system, .component_id = component};
	uint8_t bytes[MAVLINK_FRAME_MAX];

	receive(link, bytes, mavlink_frame_build(bytes, &sender, kind, payload));
	return out.forward;
}

static uint8_t heartbeat(uint8_t link, uint8_t system, uint8_t component)
{
	const mavlink_heartbeat_t wire = {.type = MAV_TYPE_GCS, .autopilot = 8};

	return pass(link, system, component, &heartbeat_kind, &wire);
}

/* A command from 255/190 on link 0. */
static uint8_t command_to(uint8_t system, uint8_t component)
{
	const mavlink_command_long_t wire = {
		.command = 405, .target_system = system, .target_component = component};

	return pass(0, 255, 190, &command_kind, &wire);
}

ZTEST(mavlink_router, test_nothing_goes_on_by_default)
{
	mavlink_endpoint_set_routing(&endpoint, false);
	zassert_equal(heartbeat(1, 1, 1), 0);
	zassert_equal(heartbeat(0, 255, 190), 0);
	zassert_equal(endpoint.router.count, 0);
}

ZTEST(mavlink_router, test_a_broadcast_goes_to_every_other_link)
{
	zassert_equal(heartbeat(0, 255, 190), LINKS & ~1);
	zassert_equal(heartbeat(2, 1, 1), LINKS & ~4);
	zassert_equal(command_to(0, 0), LINKS & ~1);
	zassert_equal(command_to(0, 154), LINKS & ~1);
	zassert_equal(endpoint.router.stats.forwarded, 4);
}

ZTEST(mavlink_router, test_links_that_are_down_get_nothing)
{
	mavlink_endpoint_link_down(&endpoint, 3);
	zassert_equal(heartbeat(0, 255, 190), 0x06);
}

ZTEST(mavlink_router, test_an_addressed_frame_goes_only_where_its_target_was_heard)
{
	zassert_equal(command_to(1, 1), 0);
	zassert_equal(endpoint.router.stats.unreachable, 1);
	heartbeat(2, 1, 1);
	zassert_equal(command_to(1, 1), 0x04);
	zassert_equal(command_to(1, 154), 0, "of the system another component");
	zassert_equal(command_to(2, 1), 0);
}

ZTEST(mavlink_router, test_all_components_of_a_system_are_where_any_of_it_was_heard)
{
	heartbeat(1, 7, 1);
	heartbeat(2, 7, 154);
	zassert_equal(command_to(7, 0), 0x06);
}

ZTEST(mavlink_router, test_what_is_for_us_alone_goes_nowhere_and_is_answered)
{
	heartbeat(1, 1, 1);
	zassert_equal(command_to(1, 243), 0);
	zassert_equal(out.command, 405);
	/* For all components of our system: answered, and passed on to where the others are. */
	zassert_equal(command_to(1, 0), 0x02);
	zassert_equal(out.command, 405);
}

ZTEST(mavlink_router, test_a_target_on_the_same_link_is_not_sent_back)
{
	heartbeat(0, 1, 1);
	zassert_equal(command_to(1, 1), 0);
}

ZTEST(mavlink_router, test_a_truncated_target_is_zero_which_is_everyone)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_ACK);
	mavlink_command_ack_t ack = {.command = 400, .target_system = 9, .target_component = 9};

	zassert_equal(pass(1, 1, 1, &kind, &ack), 0);
	ack.target_system = 0;
	ack.target_component = 0;
	zassert_equal(pass(1, 1, 1, &kind, &ack), LINKS & ~2);
}

ZTEST(mavlink_router, test_version_1_goes_on_as_well)
{
	receive(0, COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
	zassert_equal(out.forward, 0, "for us");
	heartbeat(1, 1, 1);

	uint8_t bytes[sizeof(COMMAND_ON_V1)];

	/* Byte 31 of COMMAND_LONG is target_component: to the autopilot. */
	memcpy(bytes, COMMAND_ON_V1, sizeof(bytes));
	bytes[6 + 31] = 1;
	receive(0, bytes, sizeof(bytes));
	zassert_equal(out.forward, 0x02);
}

ZTEST(mavlink_router, test_an_unknown_message_is_for_everyone)
{
	const struct mavlink_kind unknown = {.id = 0xABCDEF, .min_length = 8, .length = 8};
	const uint8_t payload[8] = {1, 1, 1, 1, 1, 1, 1, 1};

	zassert_equal(pass(1, 1, 1, &unknown, payload), LINKS & ~2);
	zassert_equal(endpoint.router.stats.opaque, 1);
	zassert_equal(out.count, 0);
}

ZTEST(mavlink_router, test_setup_signing_never_goes_on)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(SETUP_SIGNING);
	static const uint8_t targets[][2] = {{0, 0}, {1, 1}, {1, 0}, {1, 243}, {7, 7}};

	heartbeat(1, 1, 1);
	heartbeat(1, 7, 7);
	for (size_t i = 0; i < ARRAY_SIZE(targets); i++) {
		const mavlink_setup_signing_t setup = {.secret_key = {1, 2, 3},
		                                       .target_system = targets[i][0],
		                                       .target_component = targets[i][1]};

		zassert_equal(pass(0, 255, 190, &kind, &setup), 0);
	}
}

ZTEST(mavlink_router, test_what_goes_in_a_circle_ends_here)
{
	zassert_equal(heartbeat(0, 255, 190), LINKS & ~1);
	/* A neighbour echoes it, or another router brings it round. */
	zassert_equal(heartbeat(1, 255, 190), 0);
	zassert_equal(heartbeat(2, 255, 190), 0);
	zassert_equal(endpoint.router.stats.circled, 2);
	/* The way to the sender has not changed by that. */
	const mavlink_command_long_t wire = {
		.command = 405, .target_system = 255, .target_component = 190};

	zassert_equal(pass(3, 1, 1, &command_kind, &wire), 0x01);
}

ZTEST(mavlink_router, test_our_own_frames_that_come_back_go_nowhere)
{
	zassert_equal(heartbeat(1, 1, 243), 0);
	zassert_equal(endpoint.router.count, 0);
	zassert_equal(endpoint.links[1].stats.rx_echoes, 1);
}

ZTEST(mavlink_router, test_a_sender_may_move_once_it_has_been_silent)
{
	heartbeat(0, 255, 190);
	now_us = 5 * SECOND - 1;
	zassert_equal(heartbeat(1, 255, 190), 0);
	now_us = 5 * SECOND;
	zassert_equal(heartbeat(1, 255, 190), LINKS & ~2);
	zassert_equal(heartbeat(0, 255, 190), 0, "it is there now");
}

ZTEST(mavlink_router, test_whoever_was_on_a_link_that_goes_is_forgotten)
{
	heartbeat(1, 1, 1);
	heartbeat(2, 2, 1);
	mavlink_endpoint_link_down(&endpoint, 1);
	zassert_equal(command_to(1, 1), 0);
	zassert_equal(command_to(2, 1), 0x04);
	now_us += SECOND / 4; /* the same bytes, for a new heartbeat */
	zassert_equal(heartbeat(3, 1, 1), LINKS & ~8 & ~2, "it may appear elsewhere at once");
}

ZTEST(mavlink_router, test_a_full_table_keeps_who_speaks)
{
	for (uint8_t i = 0; i < MAVLINK_ROUTES_MAX; i++) {
		heartbeat(1, 10, (uint8_t)(i + 1));
	}
	now_us = 4 * SECOND;
	for (uint8_t i = 1; i < MAVLINK_ROUTES_MAX; i++) {
		heartbeat(1, 10, (uint8_t)(i + 1));
	}
	zassert_equal(heartbeat(2, 11, 1), 0);
	zassert_equal(endpoint.router.stats.no_room, 1);
	/* 10/1 has been silent for 5 s. */
	now_us = 5 * SECOND;
	zassert_equal(heartbeat(2, 11, 1), LINKS & ~4);
	zassert_equal(command_to(10, 1), 0);
	zassert_equal(endpoint.router.stats.no_room, 2, "the ground station found no place now");
}

ZTEST(mavlink_router, test_noise_taken_for_unknown_messages_drives_nobody_out)
{
	const struct mavlink_kind unknown = {.id = 0xABCDEF, .min_length = 1, .length = 1};
	const uint8_t payload = 1;

	heartbeat(1, 1, 1);
	for (unsigned int i = 0; i < 200; i++) {
		now_us++;
		pass(2, (uint8_t)(20 + i), 99, &unknown, &payload);
	}
	zassert_equal(command_to(1, 1), 0x02, "the ground station has found a place as well");
}

/* An unverified sender does not drive another out, however many there are. */
ZTEST(mavlink_router, test_unverified_senders_have_no_room_beyond_the_table)
{
	const struct mavlink_kind unknown = {.id = 0xABCDEF, .min_length = 1, .length = 1};
	const uint8_t payload = 1;

	for (uint8_t i = 0; i < MAVLINK_ROUTES_MAX; i++) {
		zassert_equal(pass(1, (uint8_t)(20 + i), 99, &unknown, &payload), LINKS & ~2);
	}
	zassert_equal(pass(1, 19, 99, &unknown, &payload), 0);
	zassert_equal(endpoint.router.stats.no_room, 1);
	now_us = 5 * SECOND;
	zassert_equal(pass(1, 19, 99, &unknown, &payload), LINKS & ~2, "20/99 has been silent");
}

/* Strangers, verified or not, never take the place of who has commanded the light. */
ZTEST(mavlink_router, test_strangers_drive_no_commander_out)
{
	const mavlink_command_long_t wire = {
		.command = 405, .target_system = 255, .target_component = 190};

	zassert_equal(command_to(1, 243), 0);
	for (unsigned int i = 0; i < 200; i++) {
		now_us += SECOND / 4;
		(void)heartbeat(2, (uint8_t)(20 + i), 1);
	}
	zassert_equal(pass(3, 1, 1, &command_kind, &wire), 0x01, "it is still known");
	/* a minute of silence, and it is a sender like any other */
	now_us += 60 * SECOND;
	for (unsigned int i = 0; i <= MAVLINK_ROUTES_MAX; i++) {
		(void)heartbeat(2, (uint8_t)(20 + i), 2);
	}
	zassert_equal(pass(3, 1, 1, &command_kind, &wire), 0);
}

ZTEST(mavlink_router, test_the_same_bytes_go_on_once)
{
	zassert_equal(heartbeat(0, 255, 190), LINKS & ~1);
	zassert_equal(heartbeat(0, 255, 190), 0, "on the same link as well");
	zassert_equal(endpoint.router.stats.circled, 1);
	now_us = 250000 - 1;
	zassert_equal(heartbeat(0, 255, 190), 0);
	now_us = 250000;
	zassert_equal(heartbeat(0, 255, 190), LINKS & ~1);
	/* long after, when the bits of the time have come round */
	now_us += INT64_C(65536) * 1000 + 1000;
	zassert_equal(heartbeat(0, 255, 190), LINKS & ~1);
}

/* One link's flood leaves the others room. */
ZTEST(mavlink_router, test_how_much_is_forwarded_has_an_end)
{
	const struct mavlink_kind unknown = {.id = 0xABCDEF, .min_length = 4, .length = 4};
	uint32_t forwarded[3] = {0};

	for (uint8_t link = 0; link < 3; link++) {
		for (uint32_t i = 1; i <= MAVLINK_SEEN_MAX; i++) {
			forwarded[link] += pass(link, (uint8_t)(20 + link), 99, &unknown, &i) != 0;
		}
	}
	zassert_equal(forwarded[0], MAVLINK_SEEN_MAX / 2);
	zassert_equal(forwarded[1], MAVLINK_SEEN_MAX / 2);
	zassert_equal(forwarded[2], 0, "that is all");
	zassert_equal(endpoint.router.stats.flooded, 2 * MAVLINK_SEEN_MAX);
	now_us = 250000;
	zassert_equal(heartbeat(3, 255, 190), LINKS & ~8);
}

ZTEST(mavlink_router, test_what_a_modem_says_stays_on_its_link)
{
	static const struct mavlink_kind status = MAVLINK_KIND(RADIO_STATUS);
	const struct mavlink_kind radio = {
		.id = 166, .crc_extra = 21, .min_length = 9, .length = 9};
	const mavlink_radio_status_t wire = {.rssi = 200};

	zassert_equal(pass(0, 51, 68, &status, &wire), 0);
	zassert_equal(pass(0, 51, 68, &radio, &wire), 0);
	zassert_equal(heartbeat(0, 51, 68), LINKS & ~1, "its heartbeat is everyone's");
}

/*
 * Two lights joined by two UARTs: links 1 and 2 of each. What comes in on link 0 of the first is
 * carried round, 2 ms a way, until nobody has anything to carry.
 */
static struct mavlink_endpoint ring[2];

struct carried {
	uint8_t to;
	uint8_t link;
	uint8_t length;
	uint8_t bytes[60];
};

static struct carried queue[4096];

static uint32_t enqueue(uint32_t count, uint8_t from, const uint8_t *bytes, uint8_t length)
{
	for (uint8_t link = 1; link <= 2; link++) {
		if ((out.forward & 1u << link) != 0) {
			zassert_true(count < ARRAY_SIZE(queue), "it goes round for ever");
			queue[count] = (struct carried){
				.to = (uint8_t)(1 - from), .link = link, .length = length};
			memcpy(queue[count].bytes, bytes, length);
			count++;
		}
	}
	return count;
}

ZTEST(mavlink_router, test_a_ring_of_two_lights_is_silent_after_a_round)
{
	const struct mavlink_endpoint_config config = {.system_id = 1, .links = 7, .routing = true};
	const struct mavlink_kind unknown = {.id = 0x7F1234, .min_length = 1, .length = 1};
	const uint8_t payload = 1;
	uint32_t count = 0;

	mavlink_endpoint_init(&ring[0], &config);
	mavlink_endpoint_init(&ring[1], &config);
	for (uint8_t system = 1; system <= 33; system++) {
		const struct mavlink_sender sender = {
			.version = 2, .system_id = system, .component_id = 1};
		uint8_t bytes[MAVLINK_FRAME_MAX];
		const size_t length = mavlink_frame_build(bytes, &sender, &unknown, &payload);

		mavlink_endpoint_receive(&ring[0], now_us, 0, bytes, length, &out);
		count = enqueue(count, 0, bytes, (uint8_t)length);
	}
	zassert_equal(count, 2 * 32, "as many as have room");
	for (uint32_t i = 0; i < count; i++) {
		const struct carried *const frame = &queue[i];

		now_us += 2000;
		mavlink_endpoint_receive(&ring[frame->to], now_us, frame->link, frame->bytes,
		                         frame->length, &out);
		count = enqueue(count, frame->to, frame->bytes, frame->length);
	}
	/* the first copy of each goes back on the other UART, and there it ends */
	zassert_equal(count, 2 * 32 + 32);
}

ZTEST(mavlink_router, test_signed_frames_of_others_go_on_whatever_their_key)
{
	receive(2, HEARTBEAT_SIGNED, sizeof(HEARTBEAT_SIGNED));
	zassert_equal(out.forward, LINKS & ~4);
}

ZTEST(mavlink_router, test_what_our_key_refuses_goes_on_to_others)
{
	const struct mavlink_signing_record record = {.timestamp = 1, .key = {1}};

	heartbeat(1, 1, 1);
	mavlink_endpoint_restore_key(&endpoint, now_us, &record);
	zassert_equal(command_to(1, 1), 0x02);
	zassert_equal(command_to(1, 0), 0x02);
	zassert_equal(out.command, 0, "not carried out here");
}

/* With a key, a stranger who says that he is the autopilot gets nothing of what is meant for it. */
ZTEST(mavlink_router, test_with_a_key_the_unsigned_makes_no_route)
{
	const struct mavlink_signing_record key = {.timestamp = 1000, .key = {1}};

	mavlink_endpoint_set_key(&endpoint, now_us, &key);
	zassert_equal(heartbeat(1, 1, 1), LINKS & ~0x02, "it goes on, for others to judge");
	zassert_equal(endpoint.router.count, 0);
	zassert_equal(command_to(1, 1), 0, "nobody was heard there");
	mavlink_endpoint_set_key(&endpoint, now_us, &(struct mavlink_signing_record){0});
	(void)heartbeat(1, 1, 1);
	zassert_equal(command_to(1, 1), 0x02);
}
