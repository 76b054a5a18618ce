/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/framer.h"

#include "core/assert.h"

#include <string.h>

enum verdict {
	VERDICT_FRAME,
	VERDICT_INCOMPLETE,
	VERDICT_NO_HEADER,
	VERDICT_UNKNOWN_ID,
	VERDICT_BAD_CHECKSUM,
};

void mavlink_framer_init(struct mavlink_framer *self)
{
	self->stats = (struct mavlink_framer_stats){0};
	self->head = 0;
	self->tail = 0;
	self->skipping = false;
}

uint8_t *mavlink_framer_reserve(struct mavlink_framer *self, size_t *room)
{
	if (MAVLINK_FRAMER_WINDOW - self->tail < MAVLINK_FRAME_MAX && self->head > 0) {
		memmove(self->window, self->window + self->head, (size_t)(self->tail - self->head));
		self->tail = (uint16_t)(self->tail - self->head);
		self->head = 0;
	}
	*room = (size_t)(MAVLINK_FRAMER_WINDOW - self->tail);
	return self->window + self->tail;
}

void mavlink_framer_commit(struct mavlink_framer *self, size_t count)
{
	PHAROS_ASSERT(count <= (size_t)(MAVLINK_FRAMER_WINDOW - self->tail));
	self->tail = (uint16_t)(self->tail + count);
}

size_t mavlink_framer_write(struct mavlink_framer *self, const uint8_t *bytes, size_t count)
{
	size_t room;
	uint8_t *at = mavlink_framer_reserve(self, &room);
	const size_t taken = count < room ? count : room;

	memcpy(at, bytes, taken);
	mavlink_framer_commit(self, taken);
	return taken;
}

static bool is_magic(uint8_t byte)
{
	return byte == MAVLINK_MAGIC_V2 || byte == MAVLINK_MAGIC_V1;
}

/* What begins at bytes, which has a magic byte first. Decides as early as the bytes allow. */
static enum verdict inspect(const uint8_t *bytes, size_t available, struct mavlink_frame *frame)
{
	const bool v2 = bytes[0] == MAVLINK_MAGIC_V2;
	const size_t header = v2 ? MAVLINK_V2_HEADER : MAVLINK_V1_HEADER;

	if (v2 && available > 2 && (bytes[2] & ~MAVLINK_INCOMPAT_SIGNED) != 0) {
		return VERDICT_NO_HEADER;
	}
	if (available < header) {
		return VERDICT_INCOMPLETE;
	}

	uint32_t id = bytes[5];

	if (v2) {
		id = bytes[7] | (uint32_t)bytes[8] << 8 | (uint32_t)bytes[9] << 16;
	}

	uint8_t crc_extra;

	if (!mavlink_crc_extra(id, &crc_extra)) {
		return VERDICT_UNKNOWN_ID;
	}

	const size_t body = header + bytes[1];
	size_t length = body + MAVLINK_CHECKSUM_BYTES;

	if (v2 && (bytes[2] & MAVLINK_INCOMPAT_SIGNED) != 0) {
		length += MAVLINK_SIGNATURE_BYTES;
	}
	if (available < length) {
		return VERDICT_INCOMPLETE;
	}

	uint16_t crc = mavlink_checksum(bytes + 1, body - 1, MAVLINK_CHECKSUM_INITIAL);

	crc = mavlink_checksum(&crc_extra, 1, crc);
	if (bytes[body] != (uint8_t)crc || bytes[body + 1] != (uint8_t)(crc >> 8)) {
		return VERDICT_BAD_CHECKSUM;
	}
	/* The header was checked above, so this always succeeds. */
	return mavlink_frame_view(bytes, length, frame) ? VERDICT_FRAME : VERDICT_NO_HEADER;
}

static void skip(struct mavlink_framer *self, size_t count)
{
	self->head = (uint16_t)(self->head + count);
	self->stats.skipped_bytes += (uint32_t)count;
	self->skipping = true;
}

static void take(struct mavlink_framer *self, uint16_t length)
{
	self->head = (uint16_t)(self->head + length);
	self->stats.frames++;
	if (self->skipping) {
		self->stats.resyncs++;
		self->skipping = false;
	}
}

bool mavlink_framer_next(struct mavlink_framer *self, struct mavlink_frame *frame)
{
	while (self->head < self->tail) {
		const uint8_t *const bytes = self->window + self->head;

		if (!is_magic(bytes[0])) {
			skip(self, 1);
			continue;
		}
		switch (inspect(bytes, (size_t)(self->tail - self->head), frame)) {
		case VERDICT_FRAME:
			take(self, frame->length);
			return true;
		case VERDICT_INCOMPLETE:
			return false;
		case VERDICT_NO_HEADER:
			break;
		case VERDICT_UNKNOWN_ID:
			self->stats.unknown_ids++;
			break;
		case VERDICT_BAD_CHECKSUM:
			self->stats.crc_errors++;
			break;
		}
		skip(self, 1);
	}
	return false;
}

bool mavlink_framer_pending(const struct mavlink_framer *self)
{
	return self->head < self->tail;
}

bool mavlink_framer_idle(struct mavlink_framer *self, struct mavlink_frame *frame)
{
	for (size_t at = (size_t)self->head + 1; at < self->tail; at++) {
		const uint8_t *const bytes = self->window + at;

		if (is_magic(bytes[0]) && inspect(bytes, self->tail - at, frame) == VERDICT_FRAME) {
			skip(self, at - self->head);
			take(self, frame->length);
			return true;
		}
	}
	return false;
}
