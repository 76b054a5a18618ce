/* SPDX-License-Identifier: Apache-2.0 */
/* What the transport sends, and in which order. Spec: DroneCAN, "CAN bus transport layer". */
#include "bus.h"

#define SECOND ((int64_t)US_PER_S)

static struct dronecan_transport peer;
static struct bus bus;
static uint8_t pattern[DRONECAN_TX_PAYLOAD_MAX];

static void before(void *fixture)
{
	ARG_UNUSED(fixture);
	dronecan_transport_init(&peer, NULL, 0, 10, false, 1);
	for (size_t i = 0; i < sizeof(pattern); i++) {
		pattern[i] = (uint8_t)(i * 37u + 1u);
	}
}

ZTEST_SUITE(dronecan_transport_tx, NULL, NULL, before, NULL, NULL);

static bool queue(uint8_t priority, const struct dronecan_type *type, size_t size, int64_t now_us)
{
	const struct dronecan_transfer out = {
		.type = type, .priority = priority, .data = pattern, .size = size};

	return dronecan_transport_send(&peer, now_us, &out);
}

ZTEST(dronecan_transport_tx, test_frames_leave_by_priority_then_in_order)
{
	zassert_true(queue(24, &dronecan_node_status_type, 7, 0));
	zassert_true(queue(16, &dronecan_tunnel_targetted_type, 6, 0));
	zassert_true(queue(16, &dronecan_debug_log_message_type, 5, 0));
	bus.count = 0;
	bus_take(&bus, &peer, 0);
	zassert_equal(bus.count, 3);
	zassert_equal(bus.frames[0].id, 0x100BB90A);
	zassert_equal(bus.frames[1].id, 0x103FFF0A);
	zassert_equal(bus.frames[2].id, 0x1801550A);
}

ZTEST(dronecan_transport_tx, test_an_urgent_transfer_overtakes_but_not_within_its_own_stream)
{
	struct dronecan_frame frame;

	zassert_true(queue(24, &dronecan_debug_log_message_type, 50, 0));
	zassert_true(dronecan_transport_next_frame(&peer, 0, &frame));
	dronecan_transport_frame_sent(&peer);
	zassert_true(queue(2, &dronecan_debug_log_message_type, 5, 0));
	zassert_true(queue(8, &dronecan_node_status_type, 7, 0));
	bus.count = 0;
	bus_take(&bus, &peer, 0);
	/* The rest of the long one (the same type), the urgent log, then the status. */
	zassert_equal(bus.count, 9);
	for (size_t i = 0; i < 7; i++) {
		zassert_equal(bus.frames[i].id, 0x183FFF0A, "%zu", i);
	}
	zassert_equal(bus.frames[7].id, 0x023FFF0A);
	zassert_equal(bus.frames[8].id, 0x0801550A);
}

ZTEST(dronecan_transport_tx, test_a_frame_shown_stays_until_it_was_sent)
{
	struct dronecan_frame first;
	struct dronecan_frame again;

	zassert_true(queue(24, &dronecan_debug_log_message_type, 50, 0));
	zassert_true(dronecan_transport_next_frame(&peer, 0, &first));
	zassert_true(dronecan_transport_next_frame(&peer, 0, &again));
	zassert_mem_equal(&first, &again, sizeof(first));
	zassert_equal(peer.stats.frames_tx, 0);
}

ZTEST(dronecan_transport_tx, test_transfer_ids_count_per_type_and_target)
{
	for (uint8_t i = 0; i < 40; i++) {
		zassert_true(queue(24, &dronecan_node_status_type, 7, 0));
		zassert_true(i % 2 == 0 || queue(24, &dronecan_hardpoint_status_type, 7, 0));
		bus.count = 0;
		bus_take(&bus, &peer, 0);
		zassert_equal(bus.frames[0].data[7], 0xC0u | (i % 32u));
		zassert_true(i % 2 == 0 || bus.frames[1].data[7] == (0xC0u | (i / 2u)));
	}
}

ZTEST(dronecan_transport_tx, test_a_full_queue_refuses_an_equal_and_yields_to_a_more_urgent_one)
{
	for (size_t i = 0; i < DRONECAN_TX_TRANSFERS; i++) {
		zassert_equal(dronecan_transport_room(&peer), DRONECAN_TX_TRANSFERS - i);
		zassert_true(queue(24, &dronecan_node_status_type, 7, 0));
	}
	zassert_equal(dronecan_transport_room(&peer), 0);
	zassert_false(queue(24, &dronecan_node_status_type, 7, 0));
	zassert_equal(peer.stats.tx_no_room, 1);
	zassert_true(queue(23, &dronecan_debug_log_message_type, 5, 0));
	zassert_equal(peer.stats.tx_evicted, 1);
	bus.count = 0;
	bus_take(&bus, &peer, 0);
	zassert_equal(bus.count, DRONECAN_TX_TRANSFERS);
	zassert_equal(bus.frames[0].id, 0x173FFF0A);
	/* The newest was given up: ids 0 to 22 are left. */
	zassert_equal(bus.frames[DRONECAN_TX_TRANSFERS - 1].data[7], 0xC0u | 22u);
}

/* Its first frames are on the bus: giving it up would waste them. */
ZTEST(dronecan_transport_tx, test_a_started_transfer_does_not_yield)
{
	struct dronecan_frame frame;

	zassert_true(queue(24, &dronecan_debug_log_message_type, 50, 0));
	zassert_true(dronecan_transport_next_frame(&peer, 0, &frame));
	dronecan_transport_frame_sent(&peer);
	for (size_t i = 1; i < DRONECAN_TX_TRANSFERS; i++) {
		zassert_true(queue(8, &dronecan_node_status_type, 7, 0));
	}
	zassert_true(queue(2, &dronecan_node_status_type, 7, 0));
	zassert_true(peer.tx[0].used);
	zassert_equal(peer.tx[0].type, &dronecan_debug_log_message_type);
}

ZTEST(dronecan_transport_tx, test_what_waited_for_a_second_is_dropped)
{
	struct dronecan_frame frame;

	zassert_true(queue(24, &dronecan_node_status_type, 7, 0));
	zassert_true(dronecan_transport_next_frame(&peer, SECOND, &frame));
	zassert_false(dronecan_transport_next_frame(&peer, SECOND + 1, &frame));
	zassert_equal(peer.stats.tx_expired, 1);
}

ZTEST(dronecan_transport_tx, test_anonymous_sends_single_frames_with_a_discriminator)
{
	struct dronecan_frame first;
	struct dronecan_frame second;
	const struct dronecan_transfer request = {
		.type = &dronecan_get_node_info_type, .kind = DRONECAN_REQUEST, .target = 1};

	dronecan_transport_init(&peer, NULL, 0, 0, false, 1);
	zassert_false(queue(24, &dronecan_dynamic_node_id_allocation_type, 8, 0), "two frames");
	zassert_false(queue(24, &dronecan_node_status_type, 7, 0), "a type beyond two bits");
	zassert_false(dronecan_transport_send(&peer, 0, &request), "a service");
	zassert_true(queue(24, &dronecan_dynamic_node_id_allocation_type, 7, 0));
	zassert_true(dronecan_transport_next_frame(&peer, 0, &first));
	dronecan_transport_frame_sent(&peer);
	zassert_true(queue(24, &dronecan_dynamic_node_id_allocation_type, 7, 0));
	zassert_true(dronecan_transport_next_frame(&peer, 0, &second));
	/* Priority, type & 3, message, source 0; the rest is random. */
	zassert_equal(first.id & 0x1F0003FFu, 0x18000100u);
	zassert_not_equal(first.id, second.id);
}

ZTEST(dronecan_transport_tx, test_a_response_takes_the_requests_id)
{
	const struct dronecan_transfer response = {.type = &dronecan_get_node_info_type,
	                                           .kind = DRONECAN_RESPONSE,
	                                           .target = 10,
	                                           .priority = 20,
	                                           .id = 3,
	                                           .data = pattern,
	                                           .size = 1};
	struct dronecan_frame frame;

	dronecan_transport_init(&peer, NULL, 0, 68, false, 1);
	zassert_true(dronecan_transport_send(&peer, 0, &response));
	zassert_true(dronecan_transport_next_frame(&peer, 0, &frame));
	zassert_equal(frame.id, 0x14010AC4); /* 20, type 1, to 10, service, from 68 */
	zassert_equal(frame.data[1], 0xC3);
}
