/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One MAVLink frame: read in place, or built. Versions 1 and 2. Any context, no state.
 *
 * Spec: mavlink.io/en/guide/serialization.html.
 */
#ifndef PHAROS_PROTO_MAVLINK_FRAME_H
#define PHAROS_PROTO_MAVLINK_FRAME_H

#include "proto/mavlink/limits.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MAVLINK_MAGIC_V1         0xFEu
#define MAVLINK_MAGIC_V2         0xFDu
#define MAVLINK_INCOMPAT_SIGNED  0x01u
#define MAVLINK_CHECKSUM_INITIAL 0xFFFFu

/* A frame in somebody's bytes: valid as long as those are. */
struct mavlink_frame {
	const uint8_t *bytes;
	const uint8_t *payload;
	uint32_t message_id;
	uint16_t length;
	uint8_t payload_length;
	uint8_t version; /* 1 or 2 */
	uint8_t sequence;
	uint8_t system_id;
	uint8_t component_id;
	bool has_signature;
};

/* What a message is on the wire. min_length: without extensions, which version 1 can't carry. */
struct mavlink_kind {
	uint32_t id;
	uint8_t crc_extra;
	uint8_t min_length;
	uint8_t length;
};

/* The kind of a message of the dialect, by its name. */
#define MAVLINK_KIND(NAME)                                                                         \
	{                                                                                          \
		.id = MAVLINK_MSG_ID_##NAME, .crc_extra = MAVLINK_MSG_ID_##NAME##_CRC,             \
		.min_length = MAVLINK_MSG_ID_##NAME##_MIN_LEN,                                     \
		.length = MAVLINK_MSG_ID_##NAME##_LEN,                                             \
	}

struct mavlink_sender {
	uint8_t version; /* 1 or 2 */
	uint8_t sequence;
	uint8_t system_id;
	uint8_t component_id;
	bool has_signature; /* it will be appended; version 2 */
};

/* To whom a message is addressed; 0: to everyone. */
struct mavlink_target {
	uint8_t system_id;
	uint8_t component_id;
};

/* CRC-16/MCRF4XX over length bytes, from crc on (MAVLINK_CHECKSUM_INITIAL). */
uint16_t mavlink_checksum(const uint8_t *bytes, size_t length, uint16_t crc);

/*
 * Reads the header. false: not exactly one whole frame by its length, or an incompatibility flag
 * that isn't known; *frame is then unchanged. The checksum is the framer's business.
 */
bool mavlink_frame_view(const uint8_t *bytes, size_t length, struct mavlink_frame *frame);

/*
 * Copies the payload into a generated struct of size bytes. What was truncated is 0; what is
 * longer than we know is left out.
 */
void mavlink_frame_payload(const struct mavlink_frame *frame, void *payload, size_t size);

/* Byte of the payload at offset; 0 when it was truncated. */
uint8_t mavlink_frame_byte(const struct mavlink_frame *frame, uint8_t offset);

/*
 * Builds a frame up to its checksum. bytes: room for MAVLINK_FRAME_MAX. payload: kind->length bytes
 * in wire order. Version 2 leaves out trailing zeros (one byte stays), version 1 the extensions.
 * Returns the length; 0: version 1 can't carry that message.
 */
size_t mavlink_frame_build(uint8_t *bytes, const struct mavlink_sender *sender,
                           const struct mavlink_kind *kind, const void *payload);

/* Looks up CRC_EXTRA of any message that pymavlink's dialects know. false: unknown id. */
bool mavlink_crc_extra(uint32_t message_id, uint8_t *crc_extra);

/* The target of any message that pymavlink's dialects know; without target, or unknown: all. */
struct mavlink_target mavlink_frame_target(const struct mavlink_frame *frame);

#endif
