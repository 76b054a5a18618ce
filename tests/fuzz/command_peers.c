/* SPDX-License-Identifier: Apache-2.0 */
#include "command_peers.h"

#include <math.h>
#include <string.h>

#include "check.h"
#include "proto/dronecan/endpoint.h"
#include "proto/imc/codec.h"
#include "proto/mavlink/dialect.h"

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

uint8_t script_take(struct script *script)
{
	return script->at < script->end ? *script->at++ : 0;
}

void script_take_bytes(struct script *script, uint8_t *to, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		to[i] = script_take(script);
	}
}

/* --- MAVLink ---------------------------------------------------------------------------------- */

size_t peer_message(struct script *script, uint8_t bytes[MAVLINK_FRAME_MAX])
{
	static const uint16_t ids[32] = {0,   0,   4,   20,  20,  21,  23,  23,    23,  33,  30,
	                                 75,  76,  77,  80,  110, 110, 110, 111,   256, 283, 284,
	                                 284, 285, 286, 286, 300, 385, 440, 12900, 69,  1};
	const uint8_t choice = script_take(script);
	const struct mavlink_sender sender = {
		.version = choice & 0x80 ? 1 : 2,
		.system_id = choice & 0x40 ? 1 : 255,
		.component_id = choice & 0x20 ? 1 : 190,
	};
	struct mavlink_kind kind = {.id = ids[choice & 31]};
	uint8_t payload[MAVLINK_PAYLOAD_MAX] = {0};

	if (!mavlink_crc_extra(kind.id, &kind.crc_extra)) {
		return 0;
	}
	kind.length = script_take(script);
	kind.length = kind.length == 0 ? 1 : kind.length;
	kind.min_length = kind.length;
	script_take_bytes(script, payload, kind.length);
	return mavlink_frame_build(bytes, &sender, &kind, payload);
}

static float a_number(struct script *script)
{
	static const float usual[] = {0.0f, 1.0f, 2.0f, 0.5f, 300.0f, 440.0f, -1.0f, 1e9f};
	const uint8_t choice = script_take(script);

	return choice < COUNT(usual) ? usual[choice]
	                             : (choice == COUNT(usual) ? NAN : (float)choice);
}

static mavlink_command_long_t a_command(struct script *script)
{
	static const uint16_t ids[] = {405, 406, 405, 406,  512,  511,   246,
	                               310, 520, 205, 1000, 1001, 31010, 519};
	const uint8_t choice = script_take(script);

	return (mavlink_command_long_t){
		.command = ids[(choice & 15) % COUNT(ids)],
		.target_system = choice & 0x40 ? 0 : 1,
		.target_component = choice & 0x10 ? 154 : (choice & 0x20 ? 0 : 243),
		.param1 = a_number(script),
		.param2 = a_number(script),
		.param3 = a_number(script),
		.param4 = a_number(script),
		.param5 = a_number(script),
		.param7 = a_number(script),
	};
}

static size_t build_command(struct script *script, bool is_signed, uint8_t bytes[MAVLINK_FRAME_MAX])
{
	const mavlink_command_long_t wire = a_command(script);
	const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const struct mavlink_sender sender = {
		.version = 2, .system_id = 255, .component_id = 190, .has_signature = is_signed};

	return mavlink_frame_build(bytes, &sender, &kind, &wire);
}

size_t peer_command(struct script *script, uint8_t bytes[MAVLINK_FRAME_MAX])
{
	return build_command(script, false, bytes);
}

size_t peer_signed_command(struct script *script, int64_t now_us, const struct mavlink_signing *own,
                           uint8_t bytes[MAVLINK_FRAME_MAX], bool *is_right)
{
	size_t length = build_command(script, true, bytes);
	struct mavlink_signing_record record = own->now;
	struct mavlink_signing signer;

	if (!own->on) {
		return 0;
	}
	record.timestamp = mavlink_signing_timestamp(own, now_us) + 1;
	mavlink_signing_init(&signer, now_us, &record);
	length += mavlink_signing_sign(&signer, now_us, bytes, length, script_take(script) & 31);

	const uint8_t at = script_take(script);
	const uint8_t change = at < length ? script_take(script) : 0;

	bytes[at < length ? at : 0] ^= change;
	*is_right = change == 0;
	return length;
}

/* --- DroneCAN --------------------------------------------------------------------------------- */

static const struct {
	const struct dronecan_type *type;
	enum dronecan_kind kind;
} types[] = {
	{&dronecan_get_node_info_type, DRONECAN_REQUEST},
	{&dronecan_restart_node_type, DRONECAN_REQUEST},
	{&dronecan_param_execute_opcode_type, DRONECAN_REQUEST},
	{&dronecan_param_get_set_type, DRONECAN_REQUEST},
	{&dronecan_file_begin_firmware_update_type, DRONECAN_REQUEST},
	{&dronecan_file_read_type, DRONECAN_RESPONSE},
	{&dronecan_indication_lights_command_type, DRONECAN_MESSAGE},
	{&dronecan_hardpoint_command_type, DRONECAN_MESSAGE},
	{&dronecan_actuator_array_command_type, DRONECAN_MESSAGE},
	{&dronecan_tunnel_targetted_type, DRONECAN_MESSAGE},
};

bool peer_transfer(struct script *script, int64_t now_us, struct dronecan_transport *peer,
                   uint8_t node)
{
	const size_t choice = script_take(script) % COUNT(types);
	uint8_t data[DRONECAN_TX_PAYLOAD_MAX];
	struct dronecan_transfer transfer = {
		.type = types[choice].type,
		.kind = types[choice].kind,
		.priority = 20,
		.data = data,
		.size = script_take(script) % sizeof(data),
	};

	transfer.target = transfer.kind == DRONECAN_MESSAGE ? 0 : node;
	transfer.id = transfer.kind == DRONECAN_RESPONSE ? script_take(script) & 31u : 0;
	script_take_bytes(script, data, transfer.size);
	return dronecan_transport_send(peer, now_us, &transfer);
}

void peer_can_frame(struct script *script, struct dronecan_frame *frame)
{
	uint8_t id[4];

	script_take_bytes(script, id, sizeof(id));
	memset(frame, 0, sizeof(*frame));
	frame->id = ((uint32_t)id[0] << 24 | (uint32_t)id[1] << 16 | (uint32_t)id[2] << 8 | id[3]) &
	            0x1FFFFFFF;
	frame->size = script_take(script) % 9u;
	script_take_bytes(script, frame->data, frame->size);
}

/* --- IMC -------------------------------------------------------------------------------------- */

static void put_u16(uint8_t *at, uint16_t value)
{
	at[0] = (uint8_t)value;
	at[1] = (uint8_t)(value >> 8);
}

void peer_packet(struct script *script, uint16_t id, uint8_t uart, uint8_t datagrams,
                 struct imc_frame *frame)
{
	const struct imc_type *const type = &imc_types[script_take(script) % imc_types_count];
	const uint8_t choice = script_take(script);
	const uint8_t size = script_take(script);
	uint8_t *const bytes = frame->bytes;

	memset(bytes, 0, IMC_HEADER_SIZE);
	put_u16(&bytes[0], 0xFE54);
	put_u16(&bytes[2], type->id);
	put_u16(&bytes[4], size);
	put_u16(&bytes[14], 0x4000 + (choice & 7));
	put_u16(&bytes[17], choice & 0x40 ? UINT16_MAX : id);
	bytes[19] = choice & 0x20 ? script_take(script) : UINT8_MAX;
	script_take_bytes(script, &bytes[IMC_HEADER_SIZE], size);
	put_u16(&bytes[IMC_HEADER_SIZE + size], imc_checksum(bytes, IMC_HEADER_SIZE + size));
	frame->length = (uint16_t)(IMC_HEADER_SIZE + size + IMC_FOOTER_SIZE);
	frame->route = choice & 0x80 ? (struct imc_route){.link = uart}
	                             : (struct imc_route){.link = datagrams,
	                                                  .port = 6000 + (choice & 15),
	                                                  .address = 0x7F000001};
}
