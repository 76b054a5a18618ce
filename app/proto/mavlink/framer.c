/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The window, and why nothing is thrown away early.
 *
 *   window  [ given out | signature? | candidate ........ | free ]
 *                       ^head-behind ^head               ^tail
 *
 * At head stands a magic byte, and what its header claims. The candidate is a frame, may become
 * one (INCOMPLETE), or is a false start. After a false start head moves on by one byte, not by the
 * claimed length: with a wrong length byte a good frame lies within what was claimed.
 *
 *   bytes    fd ff 00 .. | fd 09 00 .. good .. | noise
 *            ^ claims 267 bytes: a wait for them would lose the good frame until they came
 *
 * So a candidate that waits for bytes keeps them all, and three things can end its wait: the bytes
 * come, and its checksum decides; the line falls silent, and mavlink_framer_idle() looks behind it;
 * or the window is full, which it can't be while a frame is incomplete (its size is the largest
 * frame and the largest write).
 *
 * The signature is not under the checksum. A frame with one is given out when its thirteen bytes
 * are there, but they stay in the window (behind) until the next candidate is a frame: if it is
 * none, the signature was cut short, and the search goes back to where it began.
 *
 * Cost: each byte is looked at as a start at most once, plus once for each candidate that it is a
 * checksummed part of: at worst a window full of magic bytes, MAVLINK_FRAMER_WINDOW checksums.
 * Before a change: tests/proto/mavlink and fuzz_mavlink compare chunked with whole input, and every
 * good frame behind every kind of bad one must come out.
 */
#include "proto/mavlink/framer.h"

#include "core/assert.h"

#include <string.h>

#define V2_FLAGS_END 3u /* a header's bytes up to the incompatibility flags */

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
	self->behind = 0;
	self->skipping = false;
	self->opaque = false;
}

size_t mavlink_framer_write(struct mavlink_framer *self, const uint8_t *bytes, size_t count)
{
	const uint16_t from = (uint16_t)(self->head - self->behind);

	if (MAVLINK_FRAMER_WINDOW - self->tail < MAVLINK_FRAME_MAX && from > 0) {
		memmove(self->window, self->window + from, (size_t)(self->tail - from));
		self->tail = (uint16_t)(self->tail - from);
		self->head = self->behind;
	}

	const size_t room = (size_t)(MAVLINK_FRAMER_WINDOW - self->tail);
	const size_t taken = count < room ? count : room;

	memcpy(self->window + self->tail, bytes, taken);
	self->tail = (uint16_t)(self->tail + taken);
	return taken;
}

static bool is_magic(uint8_t byte)
{
	return byte == MAVLINK_MAGIC_V2 || byte == MAVLINK_MAGIC_V1;
}

/* The length that a header claims; it is all there. */
static size_t claimed_length(const uint8_t *bytes)
{
	if (bytes[0] == MAVLINK_MAGIC_V1) {
		return MAVLINK_V1_FRAME_MIN + (size_t)bytes[1];
	}
	return MAVLINK_V2_FRAME_MIN + (size_t)bytes[1] +
	       ((bytes[2] & MAVLINK_INCOMPAT_SIGNED) != 0 ? MAVLINK_SIGNATURE_BYTES : 0);
}

static size_t header_length(const uint8_t *bytes)
{
	return bytes[0] == MAVLINK_MAGIC_V2 ? MAVLINK_V2_HEADER : MAVLINK_V1_HEADER;
}

/* With how many bytes inspect() can say more than that it is incomplete with those available. */
static size_t decides_at(const uint8_t *bytes, size_t available)
{
	if (bytes[0] == MAVLINK_MAGIC_V2 && available < V2_FLAGS_END) {
		return V2_FLAGS_END;
	}
	return available < header_length(bytes) ? header_length(bytes) : claimed_length(bytes);
}

/* What begins at bytes, which has a magic byte first. Decides as early as the bytes allow. */
static enum verdict inspect(const uint8_t *bytes, size_t available, struct mavlink_frame *frame)
{
	const bool v2 = bytes[0] == MAVLINK_MAGIC_V2;
	const size_t header = header_length(bytes);

	if (v2 && available >= V2_FLAGS_END && (bytes[2] & ~MAVLINK_INCOMPAT_SIGNED) != 0) {
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
	const size_t length = claimed_length(bytes);

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

/*
 * A frame with an unknown id at the head, by what begins within it: FRAME: nothing, it may pass.
 * UNKNOWN_ID: a verified one, so this is none. INCOMPLETE: that shows later. On a silent line what
 * is not there does not come.
 */
static enum verdict inspect_unknown(const uint8_t *bytes, size_t available, bool silent,
                                    struct mavlink_frame *frame)
{
	const size_t length = claimed_length(bytes);
	bool pending = false;

	for (size_t at = 1; at < length && at < available; at++) {
		if (!is_magic(bytes[at])) {
			continue;
		}

		const enum verdict within = inspect(bytes + at, available - at, frame);

		if (within == VERDICT_FRAME) {
			return VERDICT_UNKNOWN_ID;
		}
		pending = pending || within == VERDICT_INCOMPLETE;
	}
	if (available < length || (pending && !silent)) {
		return VERDICT_INCOMPLETE;
	}
	return mavlink_frame_view(bytes, length, frame) ? VERDICT_FRAME : VERDICT_UNKNOWN_ID;
}

/* What is at the head is no frame: the search goes on behind it, or in the last signature. */
static void skip(struct mavlink_framer *self, size_t count)
{
	if (self->behind > 0) {
		self->head = (uint16_t)(self->head - self->behind);
		self->behind = 0;
		return;
	}
	self->head = (uint16_t)(self->head + count);
	self->stats.skipped_bytes += (uint32_t)count;
	self->skipping = true;
}

static void take(struct mavlink_framer *self, const struct mavlink_frame *frame, bool opaque)
{
	self->head = (uint16_t)(self->head + frame->length);
	self->behind = frame->has_signature ? MAVLINK_SIGNATURE_BYTES : 0;
	self->stats.frames++;
	self->stats.opaque_frames += opaque;
	if (self->skipping) {
		self->stats.resyncs++;
		self->skipping = false;
	}
}

bool mavlink_framer_next(struct mavlink_framer *self, struct mavlink_frame *frame)
{
	while (self->head < self->tail) {
		const uint8_t *const bytes = self->window + self->head;
		const size_t available = (size_t)(self->tail - self->head);

		if (!is_magic(bytes[0])) {
			skip(self, 1);
			continue;
		}

		enum verdict verdict = inspect(bytes, available, frame);
		const bool opaque = self->opaque && verdict == VERDICT_UNKNOWN_ID;

		if (opaque) {
			verdict = inspect_unknown(bytes, available, false, frame);
		}
		switch (verdict) {
		case VERDICT_FRAME:
			take(self, frame, opaque);
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

size_t mavlink_framer_wanted(const struct mavlink_framer *self)
{
	const uint8_t *const head = self->window + self->head;
	const size_t available = (size_t)(self->tail - self->head);
	struct mavlink_frame frame;

	if (available == 0) {
		/* what was taken for a signature is none if this byte begins no frame */
		return self->behind > 0 ? 1 : MAVLINK_V1_FRAME_MIN;
	}
	if (inspect(head, available, &frame) != VERDICT_INCOMPLETE) {
		return 1; /* opaque: a frame that begins within it may end anywhere */
	}
	return decides_at(head, available) - available;
}

bool mavlink_framer_idle(struct mavlink_framer *self, struct mavlink_frame *frame)
{
	const uint8_t *const head = self->window + self->head;
	const size_t available = (size_t)(self->tail - self->head);

	if (self->opaque && available > 0 && is_magic(head[0]) &&
	    inspect(head, available, frame) == VERDICT_UNKNOWN_ID &&
	    inspect_unknown(head, available, true, frame) == VERDICT_FRAME) {
		take(self, frame, true);
		return true;
	}
	for (size_t at = 1; at < available; at++) {
		if (is_magic(head[at]) &&
		    inspect(head + at, available - at, frame) == VERDICT_FRAME) {
			self->behind = 0;
			skip(self, at);
			take(self, frame, false);
			return true;
		}
	}
	return false;
}
