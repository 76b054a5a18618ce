/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libFuzzer: frames of any kind into the whole DroneCAN endpoint.
 *
 * Input: a byte of options (bit 0: FD, bit 1: anonymous), then records: a byte that picks a whole
 * transfer of a type (its frames and CRC are made right), a frame with a known id, or any frame;
 * what it holds; time to pass. Invariants: nothing is read or written out of bounds (sanitizers),
 * no assertion, frames that leave are well formed, deadlines lie ahead after a step, memory is
 * given back.
 */
#include "proto/dronecan/endpoint.h"

#include "check.h"

#include <string.h>

/* Ids with everything but the source: priority 20, to node 68 where it is a service. */
static const uint32_t known_ids[] = {
	0x1401C480, 0x1404C480, 0x1405C480, 0x140AC480, 0x140BC480, 0x14000100, 0x14043900,
	0x14042E00, 0x1403F200, 0x100BB900, 0x1428C480, 0x14015500, 0x14304480,
};

static const struct {
	const struct dronecan_type *type;
	enum dronecan_kind kind;
} known_types[] = {
	{&dronecan_get_node_info_type, DRONECAN_REQUEST},
	{&dronecan_get_transport_stats_type, DRONECAN_REQUEST},
	{&dronecan_restart_node_type, DRONECAN_REQUEST},
	{&dronecan_param_execute_opcode_type, DRONECAN_REQUEST},
	{&dronecan_param_get_set_type, DRONECAN_REQUEST},
	{&dronecan_file_begin_firmware_update_type, DRONECAN_REQUEST},
	{&dronecan_file_read_type, DRONECAN_RESPONSE},
	{&dronecan_dynamic_node_id_allocation_type, DRONECAN_MESSAGE},
	{&dronecan_indication_lights_command_type, DRONECAN_MESSAGE},
	{&dronecan_actuator_array_command_type, DRONECAN_MESSAGE},
	{&dronecan_tunnel_targetted_type, DRONECAN_MESSAGE},
};

#define TYPES_COUNT (sizeof(known_types) / sizeof(known_types[0]))
#define KNOWN_COUNT (sizeof(known_ids) / sizeof(known_ids[0]))
#define NODE        68u
#define PEER        10u
/* Kinds of record: below, whole transfers; from here on frames, the last ones with any id. */
#define KIND_FRAMES 0x60u
#define KIND_ANY_ID 0xF0u

static struct pharos_device device;

struct input {
	const uint8_t *data;
	size_t size;
};

static uint8_t take(struct input *input)
{
	if (input->size == 0) {
		return 0;
	}
	input->size--;
	return *input->data++;
}

/* A whole transfer to our node, queued at the peer. */
static void transfer_of(struct input *input, uint8_t kind, struct dronecan_transport *peer,
                        int64_t now_us)
{
	uint8_t data[DRONECAN_TX_PAYLOAD_MAX];
	struct dronecan_transfer transfer = {
		.type = known_types[kind % TYPES_COUNT].type,
		.kind = known_types[kind % TYPES_COUNT].kind,
		.priority = 20,
		.fd = peer->fd,
		.data = data,
		.size = take(input) % sizeof(data),
	};

	transfer.target = (transfer.kind == DRONECAN_MESSAGE) ? 0 : NODE;
	transfer.id = transfer.kind == DRONECAN_RESPONSE ? take(input) & 31u : 0;
	for (size_t i = 0; i < transfer.size; i++) {
		data[i] = take(input);
	}
	(void)dronecan_transport_send(peer, now_us, &transfer);
}

static void frame_of(struct input *input, uint8_t kind, struct dronecan_frame *frame)
{
	const uint8_t length = take(input);

	memset(frame, 0, sizeof(*frame));
	if (kind < KIND_ANY_ID) {
		frame->id = known_ids[kind % KNOWN_COUNT] | (take(input) & 0x7Fu);
	} else {
		for (int i = 0; i < 4; i++) {
			frame->id = frame->id << 8 | take(input);
		}
	}
	frame->fd = (length & 0x80u) != 0;
	frame->size = (length & 0x7Fu) % 65u;
	if (!frame->fd && (length & 0x40u) == 0) {
		frame->size %= 9u;
	}
	for (size_t i = 0; i < frame->size; i++) {
		frame->data[i] = take(input);
	}
}

static void drain(struct dronecan_endpoint *endpoint, int64_t now_us)
{
	struct dronecan_frame frame;

	for (int i = 0; dronecan_endpoint_next_frame(endpoint, now_us, &frame); i++) {
		CHECK(i < 4000);
		CHECK(frame.size >= 1 && frame.size <= (frame.fd ? 64 : 8));
		CHECK(frame.id <= 0x1FFFFFFF);
		CHECK((frame.id & 0x7F) == endpoint->transport.node_id);
		CHECK(!frame.fd || endpoint->transport.fd);
		dronecan_endpoint_frame_sent(endpoint);
	}
}

static void perform(struct dronecan_endpoint *endpoint, int64_t now_us,
                    const struct dronecan_outbox *out)
{
	const struct illuminator_settings *const lamp = &device.lamps[0].illuminator.settings;
	struct device_effects effects;

	CHECK(out->node.count <= DRONECAN_NODE_OUTBOX_MAX);
	(void)pharos_device_take(&device, &effects);
	CHECK(lamp->brightness_ppm <= PPM_ONE);
	CHECK(lamp->strobe_period_us == 0 && lamp->mode == ILLUMINATOR_MODE_INTERNAL);
	if (out->firmware.event == DRONECAN_FIRMWARE_BEGIN ||
	    out->firmware.event == DRONECAN_FIRMWARE_BLOCK) {
		CHECK(out->firmware.event == DRONECAN_FIRMWARE_BEGIN ||
		      (out->firmware.size <= 256 &&
		       out->firmware.is_last == (out->firmware.size < 256)));
		dronecan_firmware_next(&endpoint->firmware, now_us);
	}
	if (out->tunnel_received) {
		CHECK(out->tunnel.channel < DRONECAN_TUNNEL_CHANNELS);
		CHECK(out->tunnel.size <= DRONECAN_TUNNEL_CHUNK);
		/* An echo, so that the way back is exercised too. */
		(void)dronecan_tunnel_write(&endpoint->tunnel, now_us, out->tunnel.channel,
		                            out->tunnel.data, out->tunnel.size);
	}
}

static void receive(struct dronecan_endpoint *endpoint, int64_t now_us,
                    const struct dronecan_frame *frame)
{
	struct dronecan_outbox out;

	dronecan_endpoint_receive(endpoint, now_us, frame, &out);
	perform(endpoint, now_us, &out);
}

/* After every transfer has timed out, nothing may be held. */
static void check_given_back(struct dronecan_endpoint *endpoint, int64_t now_us)
{
	/* The start of a transfer makes the transport look for what has expired. */
	const struct dronecan_frame start = {
		.id = 0x14043900 | 127u, .size = 8, .data = {0, 0, 1, 2, 3, 4, 5, 0x8F}};
	struct dronecan_outbox out;
	size_t taken = 0;

	dronecan_endpoint_receive(endpoint, now_us, &start, &out);
	for (size_t i = 0; i < DRONECAN_RX_BUFFERS; i++) {
		taken += endpoint->transport.buffer_taken[i] ? 1u : 0u;
	}
	CHECK(taken <= 1);
	CHECK(dronecan_transport_room(&endpoint->transport) == DRONECAN_TX_TRANSFERS);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	static struct dronecan_endpoint endpoint;
	static struct dronecan_transport peer;
	static struct dronecan_endpoint_config config = {
		.node = {.unique_id = {1, 2, 3, 4, 5, 6, 7, 8, 9}, .name = "org.pharos.light"},
		.lights = {.light_id = 254,
	                   .brightness_actuator_id = 9,
	                   .pan_actuator_id = 10,
	                   .tilt_actuator_id = 11},
		.seed = 1,
	};
	struct input input = {data, size};
	struct dronecan_outbox out;
	struct dronecan_frame frame;
	const uint8_t options = take(&input);
	int64_t now_us = 0;

	config.fd = (options & 1u) != 0;
	config.node_id = (options & 2u) ? 0 : NODE;
	params_init(&device.params);
	pharos_device_init(&device, now_us, &(struct device_config){.gimbal = true});
	dronecan_endpoint_init(&endpoint, now_us, &config, &device);
	dronecan_transport_init(&peer, NULL, 0, PEER, config.fd, 1);
	while (input.size > 0) {
		const uint8_t kind = take(&input);

		if (kind < KIND_FRAMES) {
			transfer_of(&input, kind, &peer, now_us);
			while (dronecan_transport_next_frame(&peer, now_us, &frame)) {
				dronecan_transport_frame_sent(&peer);
				receive(&endpoint, now_us, &frame);
			}
		} else {
			frame_of(&input, kind, &frame);
			receive(&endpoint, now_us, &frame);
		}
		now_us += (int64_t)take(&input) * take(&input) * 100;
		dronecan_endpoint_step(&endpoint, now_us, &out);
		perform(&endpoint, now_us, &out);
		CHECK(dronecan_endpoint_deadline_us(&endpoint) > now_us);
		drain(&endpoint, now_us);
	}
	check_given_back(&endpoint, now_us + 3 * DRONECAN_TRANSFER_TIMEOUT_US);
	return 0;
}
