/* SPDX-License-Identifier: Apache-2.0 */
/* The tunnel. Spec: uavcan.tunnel.Targetted; dronecan.md, "Tunnel". */
#include "device.h"

static struct dronecan_transfer heard;

static void before(void *fixture)
{
	ARG_UNUSED(fixture);
	device_start(NODE, false);
}

ZTEST_SUITE(dronecan_tunnel, NULL, NULL, before, NULL, NULL);

static void give(int64_t now_us, struct dronecan_frame frame, bool fd)
{
	frame.fd = fd;
	dronecan_endpoint_receive(&device, now_us, &frame, &device_out);
}

/* An asker's Targetted to our node, from any node, classic. */
static void ask(int64_t now_us, uint8_t node, int8_t serial_id, const uint8_t *bytes, uint8_t count)
{
	struct dronecan_tunnel_targetted message = {
		.protocol.protocol = DRONECAN_TUNNEL_PROTOCOL_MAVLINK2,
		.target_node = NODE,
		.serial_id = serial_id,
		.baudrate = 57600,
		.buffer_len = count,
	};
	struct dronecan_transport asker;
	uint8_t data[DRONECAN_TUNNEL_TARGETTED_MAX_SIZE];
	struct bus bus;
	size_t size;

	for (uint8_t i = 0; i < count; i++) {
		message.buffer[i] = bytes[i];
	}
	zassert_true(dronecan_tunnel_targetted_encode(&message, true, data, sizeof(data), &size));
	dronecan_transport_init(&asker, NULL, 0, node, false, 1);
	/* A fresh one each time: an id that was not the last. */
	asker.counters[0] = (struct dronecan_counter){&dronecan_tunnel_targetted_type, 0,
	                                              (uint8_t)((now_us / 1000 * 7) % 32)};
	bus_send(&bus, &asker, now_us, &dronecan_tunnel_targetted_type, DRONECAN_MESSAGE, 0, data,
	         size);
	for (size_t i = 0; i < bus.count; i++) {
		dronecan_endpoint_receive(&device, now_us, &bus.frames[i], &device_out);
	}
}

static bool write_bytes(int64_t now_us, uint8_t channel, size_t count)
{
	uint8_t bytes[DRONECAN_TUNNEL_BUFFER + 1];

	for (size_t i = 0; i < sizeof(bytes); i++) {
		bytes[i] = (uint8_t)i;
	}
	return dronecan_tunnel_write(&device.tunnel, now_us, channel, bytes, count);
}

ZTEST(dronecan_tunnel, test_golden_frames_of_an_asker)
{
	static const uint8_t bytes[] = {0xFD, 0x01, 0x02, 0x03};

	/* Targetted keepalive 10 -> 68, then FD010203 (dronecan.md, "Golden frames"). */
	give(0, FRAME(0x100BB90A, 0x01, 0x88, 0x01, 0x00, 0xE1, 0x00, 0xC0), false);
	zassert_true(device_out.tunnel_received);
	zassert_true(device_out.tunnel.opened);
	zassert_equal(device_out.tunnel.size, 0);
	const struct dronecan_tunnel_channel *channel =
		&device.tunnel.channels[device_out.tunnel.channel];

	zassert_equal(channel->node, 10);
	zassert_equal(channel->serial_id, 0);
	zassert_equal(channel->protocol, DRONECAN_TUNNEL_PROTOCOL_MAVLINK2);
	zassert_equal(channel->baudrate, 57600);
	zassert_true(channel->locked);

	give(1, FRAME(0x100BB90A, 0xD4, 0x55, 0x01, 0x88, 0x01, 0x00, 0xE1, 0x81), false);
	zassert_false(device_out.tunnel_received);
	give(1, FRAME(0x100BB90A, 0x00, 0xFD, 0x01, 0x02, 0x03, 0x61), false);
	zassert_true(device_out.tunnel_received);
	zassert_false(device_out.tunnel.opened);
	zassert_equal(device_out.tunnel.size, sizeof(bytes));
	zassert_mem_equal(device_out.tunnel.data, bytes, sizeof(bytes));
}

ZTEST(dronecan_tunnel, test_golden_frames_of_an_asker_on_fd)
{
	static const uint8_t bytes[] = {0xFD, 0x01, 0x02, 0x03};

	device_start(NODE, true);
	give(0, FRAME(0x100BB90A, 0x01, 0x88, 0x01, 0x00, 0xE1, 0x00, 0x00, 0xC0), true);
	zassert_true(device_out.tunnel_received);
	zassert_equal(device_out.tunnel.size, 0);
	give(1,
	     FRAME(0x100BB90A, 0x01, 0x88, 0x01, 0x00, 0xE1, 0x00, 0x09, 0xFA, 0x02, 0x04, 0x06,
	           0xC1),
	     true);
	zassert_true(device_out.tunnel_received);
	zassert_equal(device_out.tunnel.size, sizeof(bytes));
	zassert_mem_equal(device_out.tunnel.data, bytes, sizeof(bytes));
}

ZTEST(dronecan_tunnel, test_answers_name_the_asker_and_its_serial_id)
{
	struct dronecan_tunnel_targetted message;

	ask(0, TOOL, -1, NULL, 0);
	zassert_true(write_bytes(0, device_out.tunnel.channel, 5));
	device_step(0);
	zassert_true(tool_hears(0, &dronecan_tunnel_targetted_type, &heard));
	zassert_equal(heard.priority, 16);
	zassert_equal(heard.source, NODE);
	zassert_true(dronecan_tunnel_targetted_decode(&message, true, heard.data, heard.size));
	zassert_equal(message.target_node, TOOL);
	zassert_equal(message.serial_id, -1);
	zassert_equal(message.protocol.protocol, DRONECAN_TUNNEL_PROTOCOL_MAVLINK2);
	zassert_equal(message.baudrate, 57600);
	zassert_equal(message.buffer_len, 5);
	zassert_mem_equal(message.buffer, ((const uint8_t[]){0, 1, 2, 3, 4}), 5);
}

ZTEST(dronecan_tunnel, test_silence_before_the_first_targetted)
{
	zassert_false(write_bytes(0, 0, 1));
	device_step(0);
	zassert_false(tool_hears(0, &dronecan_tunnel_targetted_type, &heard));
	zassert_equal(device.tunnel.stats.tx_no_room, 1);
}

ZTEST(dronecan_tunnel, test_silence_three_seconds_after_the_last)
{
	ask(0, TOOL, 0, NULL, 0);
	const uint8_t channel = device_out.tunnel.channel;

	zassert_equal(dronecan_tunnel_deadline_us(&device.tunnel), 3 * SECOND);
	zassert_true(write_bytes(3 * SECOND - 1, channel, 1));
	zassert_false(write_bytes(3 * SECOND, channel, 1));
	/* What waited is dropped too. */
	device_step(3 * SECOND);
	zassert_false(tool_hears(3 * SECOND, &dronecan_tunnel_targetted_type, &heard));
	zassert_equal(device.tunnel.stats.closed, 1);
	zassert_equal(dronecan_tunnel_deadline_us(&device.tunnel), TIME_NEVER_US);

	ask(4 * SECOND, TOOL, 0, NULL, 0);
	zassert_true(device_out.tunnel.opened, "a new asker to whoever parses its bytes");
}

ZTEST(dronecan_tunnel, test_a_keepalive_prolongs)
{
	ask(0, TOOL, 0, NULL, 0);
	ask(2 * SECOND, TOOL, 0, NULL, 0);
	zassert_true(
		dronecan_tunnel_is_open(&device.tunnel, 4 * SECOND, device_out.tunnel.channel));
	zassert_false(
		dronecan_tunnel_is_open(&device.tunnel, 5 * SECOND, device_out.tunnel.channel));
}

ZTEST(dronecan_tunnel, test_a_targetted_for_another_node_is_not_ours)
{
	give(0, FRAME(0x100BB90A, 0x01, 0x8A, 0x01, 0x00, 0xE1, 0x00, 0xC0), false); /* to 69 */
	zassert_false(device_out.tunnel_received);
	zassert_equal(device.tunnel.stats.opened, 0);
	zassert_equal(dronecan_transport_rx_errors(&device.transport), 0);
}

/* Ten nodes tunnel to others at once, in several frames each: they take no buffer from us. */
ZTEST(dronecan_tunnel, test_others_tunnels_take_nothing)
{
	for (uint32_t node = 20; node < 60; node++) {
		give(0, FRAME(0x100BB900u | node, 0xD4, 0x55, 0x01, 0x8A, 0x01, 0x00, 0xE1, 0x80),
		     false);
		give(0, FRAME(0x100BB900u | node, 0, 1, 2, 3, 4, 5, 6, 0x20), false);
	}
	for (size_t i = 0; i < DRONECAN_RX_BUFFERS; i++) {
		zassert_false(device.transport.buffer_taken[i]);
	}
	zassert_equal(dronecan_transport_rx_errors(&device.transport), 0);
}

/* Transfer ids of an asker run on over its transfers to others; 31 of them come round to ours. */
ZTEST(dronecan_tunnel, test_an_askers_transfers_to_others_do_not_confuse_its_ids)
{
	struct dronecan_frame frame =
		FRAME(0x100BB90A, 0x01, 0x88, 0x01, 0x00, 0xE1, 0x00, 0x55, 0xC0);

	give(0, frame, false);
	zassert_true(device_out.tunnel_received);
	for (uint8_t id = 1; id < 32; id++) {
		struct dronecan_frame other = frame;

		other.data[1] = 0x8A;
		other.data[7] = 0xC0 | id;
		give(id, other, false);
		zassert_false(device_out.tunnel_received);
	}
	give(100, frame, false); /* id 0 again, the thirty-third transfer */
	zassert_true(device_out.tunnel_received);
}

ZTEST(dronecan_tunnel, test_several_askers_have_channels_of_their_own)
{
	static const struct {
		uint8_t node;
		int8_t serial_id;
	} askers[] = {{10, 0}, {10, 1}, {11, 0}, {12, -16}};
	struct dronecan_tunnel_targetted message;

	for (uint8_t i = 0; i < ARRAY_SIZE(askers); i++) {
		ask((i + 1) * MS, askers[i].node, askers[i].serial_id, &i, 1);
		zassert_true(device_out.tunnel_received);
		zassert_true(device_out.tunnel.opened);
		zassert_equal(device_out.tunnel.channel, i);
		zassert_equal(device_out.tunnel.data[0], i);
	}
	/* One more is refused; those that are there go on. */
	ask(5 * MS, 13, 0, NULL, 0);
	zassert_false(device_out.tunnel_received);
	zassert_equal(device.tunnel.stats.refused, 1);
	for (uint8_t i = 0; i < ARRAY_SIZE(askers); i++) {
		zassert_true(write_bytes(10 * MS, i, 3));
		device_step(10 * MS);
		zassert_true(tool_hears(10 * MS, &dronecan_tunnel_targetted_type, &heard));
		zassert_true(
			dronecan_tunnel_targetted_decode(&message, true, heard.data, heard.size));
		zassert_equal(message.target_node, askers[i].node);
		zassert_equal(message.serial_id, askers[i].serial_id);
	}
	ask(4 * SECOND, 13, 0, NULL, 0);
	zassert_true(device_out.tunnel_received, "a place that timed out");
}

ZTEST(dronecan_tunnel, test_chunks_of_at_most_120_bytes)
{
	static const uint8_t sizes[] = {120, 120, 60};
	struct dronecan_tunnel_targetted message;
	size_t chunks = 0;
	uint8_t next = 0;

	ask(0, TOOL, 0, NULL, 0);
	zassert_true(write_bytes(0, device_out.tunnel.channel, 300));
	device_frames(0);
	zassert_equal(device_bus.count, 19 + 19 + 10);
	for (size_t i = 0; i < device_bus.count; i++) {
		if (!dronecan_transport_receive(&tool, 0, &device_bus.frames[i], &heard) ||
		    heard.type != &dronecan_tunnel_targetted_type) {
			continue;
		}
		zassert_true(
			dronecan_tunnel_targetted_decode(&message, true, heard.data, heard.size));
		zassert_equal(message.buffer_len, sizes[chunks]);
		for (uint8_t b = 0; b < message.buffer_len; b++) {
			zassert_equal(message.buffer[b], next++);
		}
		chunks++;
	}
	zassert_equal(chunks, 3);
}

ZTEST(dronecan_tunnel, test_a_write_is_taken_whole_or_not_at_all)
{
	ask(0, TOOL, 0, NULL, 0);
	const uint8_t channel = device_out.tunnel.channel;

	zassert_true(write_bytes(0, channel, DRONECAN_TUNNEL_BUFFER - 10));
	zassert_false(write_bytes(0, channel, 11));
	zassert_equal(device.tunnel.channels[channel].count, DRONECAN_TUNNEL_BUFFER - 10);
	zassert_true(write_bytes(0, channel, 10));
	zassert_equal(device.tunnel.stats.tx_no_room, 1);
}

/* The tunnel leaves room in the queue, so that services are answered while it is busy. */
ZTEST(dronecan_tunnel, test_a_busy_tunnel_leaves_room_for_answers)
{
	for (uint8_t i = 0; i < DRONECAN_TUNNEL_CHANNELS; i++) {
		ask((i + 1) * MS, 10, (int8_t)i, NULL, 0);
		zassert_true(write_bytes(10 * MS, i, DRONECAN_TUNNEL_BUFFER));
	}
	dronecan_tunnel_step(&device.tunnel, 10 * MS, &device.transport);
	zassert_equal(dronecan_transport_room(&device.transport), DRONECAN_TUNNEL_TX_RESERVE);
	/* The rest follows as frames leave. */
	for (size_t i = 0; i < 100; i++) {
		device_frames(10 * MS);
	}
	zassert_equal(device.tunnel.stats.bytes_tx,
	              DRONECAN_TUNNEL_CHANNELS * DRONECAN_TUNNEL_BUFFER);
}

ZTEST(dronecan_tunnel, test_answers_are_fd_when_the_asker_is)
{
	device_start(NODE, true);
	ask(0, TOOL, 0, NULL, 0); /* classic */
	zassert_true(write_bytes(0, device_out.tunnel.channel, 50));
	dronecan_tunnel_step(&device.tunnel, 0, &device.transport);
	device_frames(0);
	zassert_false(device_bus.frames[0].fd);

	give(MS, FRAME(0x100BB90A, 0x01, 0x88, 0x01, 0x00, 0xE1, 0x00, 0x00, 0xC9), true);
	zassert_true(write_bytes(MS, device_out.tunnel.channel, 50));
	device_frames(MS);
	zassert_equal(device_bus.count, 1);
	zassert_true(device_bus.frames[0].fd);
}

/* ArduPilot up to 4.5 always says 255; what says GPS, or anything else, is not ours to parse. */
ZTEST(dronecan_tunnel, test_what_says_that_it_is_mavlink_is_answered)
{
	struct dronecan_tunnel_targetted message;
	uint32_t foreign = 0;

	for (uint32_t protocol = 0; protocol <= 255; protocol++) {
		const bool is_mavlink = protocol == 0 || protocol == 1 || protocol == 255;
		const int64_t now_us = protocol * 4 * SECOND;

		give(now_us,
		     FRAME(0x100BB90A, (uint8_t)protocol, 0x88, 0x01, 0x00, 0xE1, 0x00,
		           (uint8_t)(0xC0 | protocol % 32)),
		     false);
		zassert_equal(device_out.tunnel_received, is_mavlink, "protocol %u", protocol);
		foreign += !is_mavlink;
		zassert_equal(device.tunnel.stats.foreign, foreign);
		zassert_equal(write_bytes(now_us, 0, 5), is_mavlink);
		device_step(now_us);
		zassert_equal(tool_hears(now_us, &dronecan_tunnel_targetted_type, &heard),
		              is_mavlink);
		if (is_mavlink) {
			zassert_true(dronecan_tunnel_targetted_decode(&message, true, heard.data,
			                                              heard.size));
			zassert_equal(message.protocol.protocol, protocol);
		}
	}
}

/* Nor does it keep a tunnel open, or change what that is answered with. */
ZTEST(dronecan_tunnel, test_what_is_not_mavlink_leaves_the_askers_tunnel)
{
	ask(0, TOOL, 0, NULL, 0);
	const uint8_t channel = device_out.tunnel.channel;
	struct dronecan_frame gps =
		FRAME(0x100BB900u | TOOL, 2, 0x88, 0x01, 0x00, 0xE1, 0x00, 0xDF);

	give(2 * SECOND, gps, false);
	zassert_equal(device.tunnel.stats.foreign, 1);
	zassert_equal(device.tunnel.channels[channel].protocol, DRONECAN_TUNNEL_PROTOCOL_MAVLINK2);
	zassert_true(dronecan_tunnel_is_open(&device.tunnel, 3 * SECOND - 1, channel));
	zassert_false(dronecan_tunnel_is_open(&device.tunnel, 3 * SECOND, channel));
}

ZTEST(dronecan_tunnel, test_a_malformed_targetted_is_counted)
{
	give(0, FRAME(0x100BB90A, 0x01, 0x88, 0x01, 0xC0), false);
	zassert_false(device_out.tunnel_received);
	zassert_equal(device.tunnel.stats.malformed, 1);
}
