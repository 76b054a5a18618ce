/* SPDX-License-Identifier: Apache-2.0 */
/* The transport's rules. Spec: DroneCAN, "CAN bus transport layer". */
#include "bus.h"

#include "vectors/dronecan_vectors.h"

#define NODE   68
#define SECOND ((int64_t)US_PER_S)

static struct dronecan_transport transport;
static struct dronecan_transport peer;
static struct bus bus;
static struct dronecan_transfer transfer;
static uint8_t pattern[DRONECAN_TX_PAYLOAD_MAX];

static const struct dronecan_subscription subscriptions[] = {
	{.type = &dronecan_node_status_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_debug_log_message_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_tunnel_targetted_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_dynamic_node_id_allocation_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_get_node_info_type, .kind = DRONECAN_REQUEST},
	{.type = &dronecan_file_read_type, .kind = DRONECAN_RESPONSE},
	{.type = &dronecan_file_begin_firmware_update_type, .kind = DRONECAN_REQUEST},
};

static void before(void *fixture)
{
	ARG_UNUSED(fixture);
	dronecan_transport_init(&transport, subscriptions, ARRAY_SIZE(subscriptions), NODE, true,
	                        1);
	dronecan_transport_init(&peer, NULL, 0, 10, false, 1);
	for (size_t i = 0; i < sizeof(pattern); i++) {
		pattern[i] = (uint8_t)(i * 37u + 1u);
	}
}

ZTEST_SUITE(dronecan_transport, NULL, NULL, before, NULL, NULL);

static bool give(int64_t now_us, struct dronecan_frame frame)
{
	static struct dronecan_frame last; /* a transfer in one frame points into it */

	last = frame;
	return dronecan_transport_receive(&transport, now_us, &last, &transfer);
}

/* Transfers that the frames first…last-1 of the bus complete. */
static int give_bus(int64_t now_us, size_t first, size_t last)
{
	int whole = 0;

	for (size_t i = first; i < last; i++) {
		whole += give(now_us, bus.frames[i]) ? 1 : 0;
	}
	return whole;
}

/* A log message of size bytes from the peer, as frames on the bus. */
static void log_of(size_t size)
{
	bus_send(&bus, &peer, 0, &dronecan_debug_log_message_type, DRONECAN_MESSAGE, 0, pattern,
	         size);
}

/* --- frames as the reference and the other implementation have them ------------------------- */

ZTEST(dronecan_transport, test_golden_frames_are_received)
{
	/* Targetted FD010203 10 -> 68 (dronecan.md, "Golden frames"). */
	static const uint8_t payload[] = {0x01, 0x88, 0x01, 0x00, 0xE1,
	                                  0x00, 0xFD, 0x01, 0x02, 0x03};

	zassert_false(give(0, FRAME(0x100BB90A, 0xD4, 0x55, 0x01, 0x88, 0x01, 0x00, 0xE1, 0x80)));
	zassert_true(give(0, FRAME(0x100BB90A, 0x00, 0xFD, 0x01, 0x02, 0x03, 0x60)));
	zassert_equal(transfer.type, &dronecan_tunnel_targetted_type);
	zassert_equal(transfer.source, 10);
	zassert_equal(transfer.priority, 16);
	zassert_equal(transfer.id, 0);
	zassert_equal(transfer.size, sizeof(payload));
	zassert_mem_equal(transfer.data, payload, sizeof(payload));

	/* NodeStatus of another node 69; GetNodeInfo 10 -> 68, transfer id 3. */
	zassert_true(give(0, FRAME(0x18015545, 0x01, 0, 0, 0, 0, 0, 0, 0xC0)));
	zassert_equal(transfer.size, 7);
	zassert_true(give(0, FRAME(0x1401C48A, 0xC3)));
	zassert_equal(transfer.kind, DRONECAN_REQUEST);
	zassert_equal(transfer.id, 3);
	zassert_equal(transfer.priority, 20);
	zassert_equal(transfer.size, 0);
	zassert_equal(dronecan_transport_rx_errors(&transport), 0);
	zassert_equal(transport.stats.transfers_rx, 3);
	zassert_equal(transport.stats.frames_rx, 4);
}

ZTEST(dronecan_transport, test_frames_are_those_of_the_reference_implementation)
{
	for (size_t i = 0; i < ARRAY_SIZE(dronecan_vectors); i++) {
		const struct dronecan_vector *vector = &dronecan_vectors[i];
		struct dronecan_transfer out = {
			.type = vector->type,
			.kind = vector->kind,
			.priority = DRONECAN_VECTOR_PRIORITY,
			.id = DRONECAN_VECTOR_TRANSFER_ID,
			.fd = vector->fd,
			.data = vector->payload,
			.size = vector->size,
		};
		size_t at = 0;

		if (vector->size > DRONECAN_TX_PAYLOAD_MAX || vector->frames_size == 0) {
			continue;
		}
		out.target = (out.kind == DRONECAN_MESSAGE) ? 0 : DRONECAN_VECTOR_TARGET;
		dronecan_transport_init(&peer, NULL, 0, DRONECAN_VECTOR_SOURCE, true, 1);
		peer.counters[0] = (struct dronecan_counter){out.type, out.target, out.id};
		bus.count = 0;
		zassert_true(dronecan_transport_send(&peer, 0, &out));
		bus_take(&bus, &peer, 0);
		for (size_t f = 0; f < bus.count; f++) {
			zassert_equal(bus.frames[f].id, vector->frame_id, "vector %zu", i);
			zassert_equal(bus.frames[f].fd, vector->fd);
			zassert_equal(bus.frames[f].size, vector->frames[at],
			              "vector %zu frame %zu", i, f);
			zassert_mem_equal(bus.frames[f].data, &vector->frames[at + 1],
			                  bus.frames[f].size, "vector %zu frame %zu", i, f);
			at += 1u + bus.frames[f].size;
		}
		zassert_equal(at, vector->frames_size, "vector %zu", i);
	}
}

ZTEST(dronecan_transport, test_transfers_of_the_reference_implementation_are_received)
{
	for (size_t i = 0; i < ARRAY_SIZE(dronecan_vectors); i++) {
		const struct dronecan_vector *vector = &dronecan_vectors[i];
		const struct dronecan_subscription only[] = {
			{.type = vector->type, .kind = vector->kind}};
		bool whole = false;

		if (vector->type->max_size > DRONECAN_RX_PAYLOAD_MAX ||
		    vector->type->max_response_size > DRONECAN_RX_PAYLOAD_MAX) {
			continue;
		}
		dronecan_transport_init(&transport, only, 1, DRONECAN_VECTOR_TARGET, true, 1);
		for (size_t at = 0; at < vector->frames_size; at += 1u + vector->frames[at]) {
			struct dronecan_frame frame = bus_frame(
				vector->frame_id, &vector->frames[at + 1], vector->frames[at]);

			frame.fd = vector->fd;
			zassert_false(whole, "vector %zu", i);
			whole = give(0, frame);
		}
		if (vector->frames_size == 0) {
			continue;
		}
		zassert_true(whole, "vector %zu", i);
		zassert_equal(transfer.id, DRONECAN_VECTOR_TRANSFER_ID);
		/* FD pads with zeros. */
		zassert_true(transfer.size >= vector->size, "vector %zu", i);
		zassert_mem_equal(transfer.data, vector->payload, vector->size, "vector %zu", i);
		zassert_true(vector->fd || transfer.size == vector->size, "vector %zu", i);
	}
}

ZTEST(dronecan_transport, test_crc_check_value)
{
	/* CRC-16/CCITT-FALSE of "123456789". */
	zassert_equal(dronecan_crc(0xFFFF, (const uint8_t *)"123456789", 9), 0x29B1);
}

/* The frames' lengths are FD's own, and the padding is under the CRC, for every payload length. */
ZTEST(dronecan_transport, test_fd_of_every_length)
{
	static const uint8_t lengths[] = {1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};

	for (size_t size = 0; size <= 122; size++) {
		dronecan_transport_init(&peer, NULL, 0, 10, true, 1);
		dronecan_transport_init(&transport, subscriptions, ARRAY_SIZE(subscriptions), NODE,
		                        true, 1);
		log_of(size);
		for (size_t i = 0; i < bus.count; i++) {
			zassert_not_null(memchr(lengths, bus.frames[i].size, sizeof(lengths)),
			                 "%zu bytes: frame of %u", size, bus.frames[i].size);
		}
		zassert_equal(bus.count, size <= 63 ? 1 : (size + 2 + 62) / 63, "%zu bytes", size);
		zassert_equal(give_bus(0, 0, bus.count), 1, "%zu bytes", size);
		zassert_mem_equal(transfer.data, pattern, size);
		for (size_t i = size; i < transfer.size; i++) {
			zassert_equal(transfer.data[i], 0);
		}
	}
}

ZTEST(dronecan_transport, test_120_bytes_of_tunnel_are_19_classic_or_3_fd_frames)
{
	bus_send(&bus, &peer, 0, &dronecan_tunnel_targetted_type, DRONECAN_MESSAGE, 0, pattern,
	         126);
	zassert_equal(bus.count, 19); /* dronecan.md, "Tunnel" */
	dronecan_transport_init(&peer, NULL, 0, 10, true, 1);
	bus_send(&bus, &peer, 0, &dronecan_tunnel_targetted_type, DRONECAN_MESSAGE, 0, pattern,
	         127);
	zassert_equal(bus.count, 3);
}

/* --- what the wire does wrong -------------------------------------------------------------------
 */

ZTEST(dronecan_transport, test_every_single_lost_frame_loses_that_transfer_only)
{
	for (size_t lost = 0; lost < 8; lost++) {
		before(NULL);
		log_of(50); /* 52 bytes with the CRC: 8 frames */
		zassert_equal(bus.count, 8);
		zassert_equal(give_bus(0, 0, lost) + give_bus(0, lost + 1, 8), 0, "%zu", lost);
		zassert_true(dronecan_transport_rx_errors(&transport) > 0 || lost == 7);
		log_of(50);
		zassert_equal(give_bus(1, 0, 8), 1, "lost %zu", lost);
		zassert_mem_equal(transfer.data, pattern, 50);
	}
}

ZTEST(dronecan_transport, test_every_repeated_frame_is_refused_and_counted)
{
	for (size_t twice = 0; twice < 8; twice++) {
		before(NULL);
		log_of(50);
		zassert_equal(give_bus(0, 0, twice + 1) + give_bus(0, twice, 8), 1, "%zu", twice);
		zassert_equal(dronecan_transport_rx_errors(&transport), 1);
	}
}

ZTEST(dronecan_transport, test_swapped_frames_lose_that_transfer_only)
{
	for (size_t i = 0; i < 7; i++) {
		before(NULL);
		log_of(50);
		const struct dronecan_frame first = bus.frames[i];

		bus.frames[i] = bus.frames[i + 1];
		bus.frames[i + 1] = first;
		zassert_equal(give_bus(0, 0, 8), 0, "%zu", i);
		zassert_true(dronecan_transport_rx_errors(&transport) > 0);
		log_of(50);
		zassert_equal(give_bus(1, 0, 8), 1, "%zu", i);
	}
}

ZTEST(dronecan_transport, test_a_repeated_transfer_is_refused_for_two_seconds)
{
	log_of(5);
	zassert_equal(give_bus(0, 0, 1), 1);
	zassert_equal(give_bus(2 * SECOND, 0, 1), 0);
	zassert_equal(transport.stats.rx_repeated, 1);
	zassert_equal(give_bus(2 * SECOND + 1, 0, 1), 1);
}

/* Neither the expected id nor the last one: transfers were lost, or the node began anew. */
ZTEST(dronecan_transport, test_any_other_id_starts_anew)
{
	struct dronecan_frame frame = FRAME(0x18015545, 0, 0, 0, 0, 0, 0, 0, 0xC5);

	zassert_true(give(0, frame)); /* 6 is expected */
	for (uint8_t id = 0; id < 32; id++) {
		before(NULL);
		zassert_true(give(0, frame));
		frame.data[7] = 0xC0 | id;
		zassert_equal(give(1, frame), id != 5, "id %u", id);
		frame.data[7] = 0xC5;
	}
}

ZTEST(dronecan_transport, test_a_transfer_times_out_after_two_seconds)
{
	log_of(50);
	zassert_equal(give_bus(0, 0, 4), 0);
	zassert_equal(give_bus(2 * SECOND, 4, 8), 1, "in time");
	log_of(50);
	zassert_equal(give_bus(10 * SECOND, 0, 4), 0);
	zassert_equal(give_bus(12 * SECOND + 1, 4, 8), 0, "too late");
	zassert_equal(transport.stats.rx_incomplete, 1);
}

ZTEST(dronecan_transport, test_a_flipped_bit_fails_the_crc)
{
	for (size_t bit = 0; bit < 56; bit++) {
		before(NULL);
		log_of(50);
		bus.frames[3].data[bit / 8] ^= (uint8_t)(1u << (bit % 8));
		zassert_equal(give_bus(0, 0, 8), 0, "bit %zu", bit);
		zassert_equal(transport.stats.rx_wrong_crc, 1);
	}
}

ZTEST(dronecan_transport, test_the_crc_covers_the_signature)
{
	log_of(50);
	for (size_t i = 0; i < bus.count; i++) {
		/* The same bytes under another type's id. */
		bus.frames[i].id = (bus.frames[i].id & 0xFF0000FFu) | (3001u << 8);
	}
	zassert_equal(give_bus(0, 0, 8), 0);
	zassert_equal(transport.stats.rx_wrong_crc, 1);
}

ZTEST(dronecan_transport, test_a_new_start_gives_up_the_incomplete_transfer)
{
	log_of(50);
	zassert_equal(give_bus(0, 0, 4), 0);
	log_of(50);
	zassert_equal(give_bus(0, 0, 8), 1);
	zassert_equal(transport.stats.rx_incomplete, 1);
}

ZTEST(dronecan_transport, test_a_frame_with_another_transfers_id_is_refused)
{
	log_of(50);
	zassert_equal(give_bus(0, 0, 4), 0);
	bus.frames[4].data[7] ^= 0x10;
	zassert_false(give(0, bus.frames[4]));
	zassert_equal(transport.stats.rx_wrong_id, 1);
	bus.frames[4].data[7] ^= 0x10;
	zassert_equal(give_bus(0, 4, 8), 1, "the right one still continues it");
}

ZTEST(dronecan_transport, test_classic_and_fd_do_not_mix_in_a_transfer)
{
	log_of(50);
	bus.frames[4].fd = true;
	zassert_equal(give_bus(0, 0, 8), 0);
	zassert_true(transport.stats.rx_wrong_toggle > 0);
}

ZTEST(dronecan_transport, test_malformed_frames_are_counted)
{
	zassert_false(give(0, bus_frame(0x18015545, pattern, 0)));            /* no tail */
	zassert_false(give(0, FRAME(0x18015545, 0xE0)));                      /* toggle at start */
	zassert_false(give(0, FRAME(0x18015545, 1, 2, 0x80)));                /* only a CRC */
	zassert_false(give(0, FRAME(0x18015545, 0x00)));                      /* empty middle */
	zassert_false(give(0, FRAME(0x1401C480, 0xC3)));                      /* service from 0 */
	zassert_false(give(0, FRAME(0x1401808A, 0xC3)));                      /* service to 0 */
	zassert_false(give(0, FRAME(0x38015545, 0xC0)));                      /* 30 bits of id */
	zassert_false(give(0, bus_frame(0x18015545, pattern, 9)));            /* classic of 9 */
	zassert_false(give(0, FRAME(0x18040100, 1, 2, 3, 4, 5, 6, 7, 0x80))); /* anonymous start */
	zassert_equal(transport.stats.rx_malformed, 9);
	zassert_equal(dronecan_transport_rx_errors(&transport), 9);
}

ZTEST(dronecan_transport, test_another_node_with_our_id_is_counted)
{
	zassert_false(give(0, FRAME(0x18015544, 1, 0, 0, 0, 0, 0, 0, 0xC0)));
	zassert_equal(transport.stats.rx_own_id, 1);
}

ZTEST(dronecan_transport, test_anonymous_messages_take_no_session)
{
	const struct dronecan_frame frame = FRAME(0x18ABC100, 1, 2, 3, 4, 5, 6, 7, 0xC0);

	zassert_true(give(0, frame));
	zassert_equal(transfer.source, 0);
	zassert_equal(transfer.type, &dronecan_dynamic_node_id_allocation_type);
	zassert_true(give(0, frame), "nothing tells a repetition from two nodes");
	for (size_t i = 0; i < DRONECAN_RX_SESSIONS; i++) {
		zassert_false(transport.sessions[i].used);
	}
}

ZTEST(dronecan_transport, test_others_services_and_types_take_nothing)
{
	zassert_false(give(0, FRAME(0x1401C58A, 0xC3)));                   /* to node 69 */
	zassert_false(give(0, FRAME(0x1404390A, 0xFE, 0xFF, 0xFF, 0xC0))); /* not subscribed */
	zassert_equal(dronecan_transport_rx_errors(&transport), 0);
	for (size_t i = 0; i < DRONECAN_RX_SESSIONS; i++) {
		zassert_false(transport.sessions[i].used);
	}
}

ZTEST(dronecan_transport, test_a_classic_payload_longer_than_its_type_is_refused)
{
	const struct dronecan_transfer too_long = {
		.type = &dronecan_debug_log_message_type,
		.priority = 20,
		.data = pattern,
		.size = DRONECAN_DEBUG_LOG_MESSAGE_MAX_SIZE + 1,
	};

	bus.count = 0;
	zassert_true(dronecan_transport_send(&peer, 0, &too_long));
	bus_take(&bus, &peer, 0);
	zassert_equal(give_bus(0, 0, bus.count), 0);
	zassert_equal(transport.stats.rx_too_long, 1);
}

/* A sender that never ends fills no more than a buffer. */
ZTEST(dronecan_transport, test_an_endless_transfer_is_cut_off)
{
	struct dronecan_frame frame = FRAME(0x1801000B | (3001u << 8), 0, 0, 1, 2, 3, 4, 5, 0x80);

	zassert_false(give(0, frame));
	for (size_t i = 0; i < 1000; i++) {
		frame.data[7] = (i % 2 == 0) ? 0x20 : 0x00;
		zassert_false(give(0, frame));
	}
	zassert_equal(transport.stats.rx_too_long, 1);
	for (size_t i = 0; i < DRONECAN_RX_BUFFERS; i++) {
		zassert_false(transport.buffer_taken[i]);
	}
}

/* --- several nodes, full pools -------------------------------------------------------------- */

static struct bus node_frames[DRONECAN_RX_BUFFERS + 2];

static void frames_of_nodes(size_t nodes, uint8_t priority)
{
	for (size_t n = 0; n < nodes; n++) {
		const struct dronecan_transfer out = {
			.type = &dronecan_debug_log_message_type,
			.priority = priority,
			.data = &pattern[n],
			.size = 50,
		};

		dronecan_transport_init(&peer, NULL, 0, (uint8_t)(100 + n), false, 1);
		node_frames[n].count = 0;
		zassert_true(dronecan_transport_send(&peer, 0, &out));
		bus_take(&node_frames[n], &peer, 0);
	}
}

ZTEST(dronecan_transport, test_interleaved_transfers_of_many_nodes)
{
	size_t whole = 0;

	frames_of_nodes(DRONECAN_RX_BUFFERS, 20);
	for (size_t f = 0; f < 8; f++) {
		for (size_t n = 0; n < DRONECAN_RX_BUFFERS; n++) {
			if (give(0, node_frames[n].frames[f])) {
				zassert_equal(transfer.source, 100 + n);
				zassert_mem_equal(transfer.data, &pattern[n], 50);
				whole++;
			}
		}
	}
	zassert_equal(whole, DRONECAN_RX_BUFFERS);
	zassert_equal(dronecan_transport_rx_errors(&transport), 0);
}

ZTEST(dronecan_transport, test_full_buffers_refuse_an_equal_and_yield_to_a_more_urgent_transfer)
{
	frames_of_nodes(DRONECAN_RX_BUFFERS + 1, 20);
	for (size_t n = 0; n < DRONECAN_RX_BUFFERS; n++) {
		zassert_false(give((int64_t)n, node_frames[n].frames[0]));
	}
	zassert_false(give(100, node_frames[DRONECAN_RX_BUFFERS].frames[0]));
	zassert_equal(transport.stats.rx_no_room, 1);
	zassert_equal(transport.stats.rx_evicted, 0);

	bus = node_frames[DRONECAN_RX_BUFFERS];
	for (size_t i = 0; i < bus.count; i++) {
		bus.frames[i].id = (bus.frames[i].id & 0x00FFFF00u) | (19u << 24) | 99u;
	}
	zassert_equal(give_bus(200, 0, 8), 1);
	zassert_equal(transport.stats.rx_evicted, 1);
	/* Node 100 began first, so it lost its place; the others end well. */
	bus = node_frames[0];
	zassert_equal(give_bus(300, 1, 8), 0);
	bus = node_frames[1];
	zassert_equal(give_bus(300, 1, 8), 1);
}

ZTEST(dronecan_transport, test_timed_out_transfers_give_their_buffers_back)
{
	frames_of_nodes(DRONECAN_RX_BUFFERS + 1, 20);
	for (size_t n = 0; n < DRONECAN_RX_BUFFERS; n++) {
		zassert_false(give(0, node_frames[n].frames[0]));
	}
	bus = node_frames[DRONECAN_RX_BUFFERS];
	zassert_equal(give_bus(2 * SECOND + 1, 0, 8), 1);
	zassert_equal(transport.stats.rx_incomplete, DRONECAN_RX_BUFFERS);
}

ZTEST(dronecan_transport, test_more_nodes_than_sessions_replace_the_one_idle_for_longest)
{
	for (uint32_t n = 1; n <= 120; n++) {
		if (n != NODE) {
			zassert_true(give(n, FRAME(0x18015500u | n, 1, 0, 0, 0, 0, 0, 0, 0xC7)),
			             "node %u", n);
		}
	}
	/* The last nodes are remembered, the first ones no more. */
	zassert_false(give(200, FRAME(0x18015500u | 120, 1, 0, 0, 0, 0, 0, 0, 0xC7)));
	zassert_true(give(200, FRAME(0x18015500u | 1, 1, 0, 0, 0, 0, 0, 0, 0xC7)));
}
