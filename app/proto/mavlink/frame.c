/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/frame.h"

#include <pharos_crc_extra.h>
#ifdef CONFIG_PHAROS_ROUTING
#include <pharos_targets.h>
#endif

#include <string.h>

#include "core/byte_table.h"

#define MESSAGES (sizeof(pharos_crc_extra_ids) / sizeof(pharos_crc_extra_ids[0]))

/* Polynomial 0x1021, reflected: a byte, shifted through the register. */
#define MIXED(byte)   (((byte) ^ (byte) << 4) & 0xFFu)
#define SPREAD(mixed) ((mixed) << 8 ^ (mixed) << 3 ^ (mixed) >> 4)
#define SHIFTED(byte) SPREAD(MIXED(byte))

static uint32_t shifted(uint32_t byte)
{
#ifdef CONFIG_PHAROS_CHECKSUM_TABLES
	static const uint16_t table[256] = {BYTE_TABLE(SHIFTED)};

	return table[byte];
#else
	return SHIFTED(byte);
#endif
}

uint16_t mavlink_checksum(const uint8_t *bytes, size_t length, uint16_t crc)
{
	uint32_t sum = crc;

	for (size_t i = 0; i < length; i++) {
		sum = sum >> 8 ^ shifted((bytes[i] ^ sum) & 0xFFu);
	}
	return (uint16_t)sum;
}

static void view_v1(const uint8_t *bytes, struct mavlink_frame *frame)
{
	frame->version = 1;
	frame->payload_length = bytes[1];
	frame->sequence = bytes[2];
	frame->system_id = bytes[3];
	frame->component_id = bytes[4];
	frame->message_id = bytes[5];
	frame->payload = bytes + MAVLINK_V1_HEADER;
	frame->has_signature = false;
}

static void view_v2(const uint8_t *bytes, struct mavlink_frame *frame)
{
	frame->version = 2;
	frame->payload_length = bytes[1];
	frame->sequence = bytes[4];
	frame->system_id = bytes[5];
	frame->component_id = bytes[6];
	frame->message_id = bytes[7] | (uint32_t)bytes[8] << 8 | (uint32_t)bytes[9] << 16;
	frame->payload = bytes + MAVLINK_V2_HEADER;
	frame->has_signature = (bytes[2] & MAVLINK_INCOMPAT_SIGNED) != 0;
}

bool mavlink_frame_view(const uint8_t *bytes, size_t length, struct mavlink_frame *frame)
{
	if (length >= MAVLINK_V1_FRAME_MIN && bytes[0] == MAVLINK_MAGIC_V1) {
		if (length != MAVLINK_V1_FRAME_MIN + (size_t)bytes[1]) {
			return false;
		}
		view_v1(bytes, frame);
	} else if (length >= MAVLINK_V2_FRAME_MIN && bytes[0] == MAVLINK_MAGIC_V2) {
		const size_t signature =
			(bytes[2] & MAVLINK_INCOMPAT_SIGNED) != 0 ? MAVLINK_SIGNATURE_BYTES : 0;

		if ((bytes[2] & ~MAVLINK_INCOMPAT_SIGNED) != 0 ||
		    length != MAVLINK_V2_FRAME_MIN + bytes[1] + signature) {
			return false;
		}
		view_v2(bytes, frame);
	} else {
		return false;
	}
	frame->bytes = bytes;
	frame->length = (uint16_t)length;
	return true;
}

void mavlink_frame_payload(const struct mavlink_frame *frame, void *payload, size_t size)
{
	const size_t known = frame->payload_length < size ? frame->payload_length : size;

	memcpy(payload, frame->payload, known);
	memset((uint8_t *)payload + known, 0, size - known);
}

uint8_t mavlink_frame_byte(const struct mavlink_frame *frame, uint8_t offset)
{
	return offset < frame->payload_length ? frame->payload[offset] : 0;
}

/* Version 2 never sends trailing zeros, but always a first byte. */
static uint8_t trimmed_length(const uint8_t *payload, uint8_t length)
{
	while (length > 1 && payload[length - 1] == 0) {
		length--;
	}
	return length;
}

size_t mavlink_frame_build(uint8_t *bytes, const struct mavlink_sender *sender,
                           const struct mavlink_kind *kind, const void *payload)
{
	uint8_t *at = bytes;
	uint8_t length = kind->min_length;

	if (sender->version == 1) {
		if (kind->id > MAVLINK_V1_MESSAGE_MAX) {
			return 0;
		}
		*at++ = MAVLINK_MAGIC_V1;
		*at++ = length;
	} else {
		length = trimmed_length(payload, kind->length);
		*at++ = MAVLINK_MAGIC_V2;
		*at++ = length;
		*at++ = sender->has_signature ? MAVLINK_INCOMPAT_SIGNED : 0;
		*at++ = 0;
	}
	*at++ = sender->sequence;
	*at++ = sender->system_id;
	*at++ = sender->component_id;
	*at++ = (uint8_t)kind->id;
	if (sender->version != 1) {
		*at++ = (uint8_t)(kind->id >> 8);
		*at++ = (uint8_t)(kind->id >> 16);
	}
	memcpy(at, payload, length);
	at += length;

	uint16_t crc =
		mavlink_checksum(bytes + 1, (size_t)(at - bytes) - 1, MAVLINK_CHECKSUM_INITIAL);

	crc = mavlink_checksum(&kind->crc_extra, 1, crc);
	*at++ = (uint8_t)crc;
	*at++ = (uint8_t)(crc >> 8);
	return (size_t)(at - bytes);
}

/* Index in the generated tables; MESSAGES: no dialect has that id. */
static size_t message_index(uint32_t message_id)
{
	size_t low = 0;
	size_t high = MESSAGES;

	while (low < high) {
		const size_t middle = (low + high) / 2;

		if (pharos_crc_extra_ids[middle] < message_id) {
			low = middle + 1;
		} else {
			high = middle;
		}
	}
	return low < MESSAGES && pharos_crc_extra_ids[low] == message_id ? low : MESSAGES;
}

bool mavlink_crc_extra(uint32_t message_id, uint8_t *crc_extra)
{
	const size_t index = message_index(message_id);

	if (index == MESSAGES) {
		return false;
	}
	*crc_extra = pharos_crc_extra[index];
	return true;
}

#ifdef CONFIG_PHAROS_ROUTING
struct mavlink_target mavlink_frame_target(const struct mavlink_frame *frame)
{
	const size_t index = message_index(frame->message_id);
	const uint8_t row = index < MESSAGES ? pharos_targets[index] : 0;
	const uint8_t component_at = row & PHAROS_TARGET_AT;
	struct mavlink_target target = {0};

	if (component_at > 0) {
		target.system_id = mavlink_frame_byte(frame, component_at - 1);
	}
	if ((row & PHAROS_TARGET_COMPONENT) != 0) {
		target.component_id = mavlink_frame_byte(frame, component_at);
	}
	return target;
}
#endif
