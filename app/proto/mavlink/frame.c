/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/frame.h"

#include <pharos_crc_extra.h>
#ifdef CONFIG_PHAROS_ROUTING
#include <pharos_targets.h>
#endif

#include <string.h>

#define MESSAGES (sizeof(pharos_crc_extra_ids) / sizeof(pharos_crc_extra_ids[0]))

/* Polynomial 0x1021, reflected: a row's value is its index, shifted through the register. */
static const uint16_t checksum_table[256] = {
	0x0000, 0x1189, 0x2312, 0x329B, 0x4624, 0x57AD, 0x6536, 0x74BF, 0x8C48, 0x9DC1, 0xAF5A,
	0xBED3, 0xCA6C, 0xDBE5, 0xE97E, 0xF8F7, 0x1081, 0x0108, 0x3393, 0x221A, 0x56A5, 0x472C,
	0x75B7, 0x643E, 0x9CC9, 0x8D40, 0xBFDB, 0xAE52, 0xDAED, 0xCB64, 0xF9FF, 0xE876, 0x2102,
	0x308B, 0x0210, 0x1399, 0x6726, 0x76AF, 0x4434, 0x55BD, 0xAD4A, 0xBCC3, 0x8E58, 0x9FD1,
	0xEB6E, 0xFAE7, 0xC87C, 0xD9F5, 0x3183, 0x200A, 0x1291, 0x0318, 0x77A7, 0x662E, 0x54B5,
	0x453C, 0xBDCB, 0xAC42, 0x9ED9, 0x8F50, 0xFBEF, 0xEA66, 0xD8FD, 0xC974, 0x4204, 0x538D,
	0x6116, 0x709F, 0x0420, 0x15A9, 0x2732, 0x36BB, 0xCE4C, 0xDFC5, 0xED5E, 0xFCD7, 0x8868,
	0x99E1, 0xAB7A, 0xBAF3, 0x5285, 0x430C, 0x7197, 0x601E, 0x14A1, 0x0528, 0x37B3, 0x263A,
	0xDECD, 0xCF44, 0xFDDF, 0xEC56, 0x98E9, 0x8960, 0xBBFB, 0xAA72, 0x6306, 0x728F, 0x4014,
	0x519D, 0x2522, 0x34AB, 0x0630, 0x17B9, 0xEF4E, 0xFEC7, 0xCC5C, 0xDDD5, 0xA96A, 0xB8E3,
	0x8A78, 0x9BF1, 0x7387, 0x620E, 0x5095, 0x411C, 0x35A3, 0x242A, 0x16B1, 0x0738, 0xFFCF,
	0xEE46, 0xDCDD, 0xCD54, 0xB9EB, 0xA862, 0x9AF9, 0x8B70, 0x8408, 0x9581, 0xA71A, 0xB693,
	0xC22C, 0xD3A5, 0xE13E, 0xF0B7, 0x0840, 0x19C9, 0x2B52, 0x3ADB, 0x4E64, 0x5FED, 0x6D76,
	0x7CFF, 0x9489, 0x8500, 0xB79B, 0xA612, 0xD2AD, 0xC324, 0xF1BF, 0xE036, 0x18C1, 0x0948,
	0x3BD3, 0x2A5A, 0x5EE5, 0x4F6C, 0x7DF7, 0x6C7E, 0xA50A, 0xB483, 0x8618, 0x9791, 0xE32E,
	0xF2A7, 0xC03C, 0xD1B5, 0x2942, 0x38CB, 0x0A50, 0x1BD9, 0x6F66, 0x7EEF, 0x4C74, 0x5DFD,
	0xB58B, 0xA402, 0x9699, 0x8710, 0xF3AF, 0xE226, 0xD0BD, 0xC134, 0x39C3, 0x284A, 0x1AD1,
	0x0B58, 0x7FE7, 0x6E6E, 0x5CF5, 0x4D7C, 0xC60C, 0xD785, 0xE51E, 0xF497, 0x8028, 0x91A1,
	0xA33A, 0xB2B3, 0x4A44, 0x5BCD, 0x6956, 0x78DF, 0x0C60, 0x1DE9, 0x2F72, 0x3EFB, 0xD68D,
	0xC704, 0xF59F, 0xE416, 0x90A9, 0x8120, 0xB3BB, 0xA232, 0x5AC5, 0x4B4C, 0x79D7, 0x685E,
	0x1CE1, 0x0D68, 0x3FF3, 0x2E7A, 0xE70E, 0xF687, 0xC41C, 0xD595, 0xA12A, 0xB0A3, 0x8238,
	0x93B1, 0x6B46, 0x7ACF, 0x4854, 0x59DD, 0x2D62, 0x3CEB, 0x0E70, 0x1FF9, 0xF78F, 0xE606,
	0xD49D, 0xC514, 0xB1AB, 0xA022, 0x92B9, 0x8330, 0x7BC7, 0x6A4E, 0x58D5, 0x495C, 0x3DE3,
	0x2C6A, 0x1EF1, 0x0F78,
};

uint16_t mavlink_checksum(const uint8_t *bytes, size_t length, uint16_t crc)
{
	uint32_t sum = crc;

	for (size_t i = 0; i < length; i++) {
		sum = (sum >> 8) ^ checksum_table[(bytes[i] ^ sum) & 0xFFu];
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
	struct mavlink_target target = {0};

	if (index < MESSAGES) {
		/* an offset behind every payload stands for no such field */
		target.system_id = mavlink_frame_byte(frame, pharos_target_system[index]);
		target.component_id = mavlink_frame_byte(frame, pharos_target_component[index]);
	}
	return target;
}
#endif
