/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Framer: bytes in, in any chunks; verified frames out, pointing into the framer's window.
 *
 *   while (size > 0) {
 *           size_t taken = mavlink_framer_write(&framer, bytes, size);
 *           bytes += taken, size -= taken;
 *           while (mavlink_framer_next(&framer, &frame)) { … }
 *   }
 *
 * A frame is verified: its checksum is right, including CRC_EXTRA, for any message of pymavlink's
 * dialects. An id not known can't be verified and is taken for a false start.
 * A router sets opaque: then such a frame comes out as well, by the length that it claims, unless
 * a verified one begins within it. As long as one may, it waits; so no verified frame is lost.
 * After a false start (bad checksum, unknown id, unknown incompatibility flag) the search goes on
 * with the very next byte, so no good frame is lost behind a wrong length byte.
 * Such a length byte may claim bytes that never come: once the line has been silent for some
 * MAVLINK_FRAMER_IDLE_US, mavlink_framer_idle() finds the good frames behind it.
 * Signed frames are carried through whole; the signature is checked elsewhere. It is not under the
 * checksum: when what follows it is no frame, the search goes back to where the signature began,
 * so that a signature which was cut short costs no frame behind it.
 *
 * Context: one thread per framer. Spec: mavlink.io/en/guide/serialization.html.
 */
#ifndef PHAROS_PROTO_MAVLINK_FRAMER_H
#define PHAROS_PROTO_MAVLINK_FRAMER_H

#include "proto/mavlink/frame.h"

/* Silence after which a byte that should follow will not: longer than a USB adapter's latency. */
#define MAVLINK_FRAMER_IDLE_US 50000

struct mavlink_framer_stats {
	uint32_t frames;
	uint32_t opaque_frames; /* of these, those that could not be verified */
	uint32_t crc_errors;    /* candidates with a wrong checksum */
	uint32_t unknown_ids;   /* candidates with an id that no dialect has */
	uint32_t resyncs;       /* times that a frame was found after bytes had been skipped */
	uint32_t skipped_bytes; /* in search of a frame */
};

struct mavlink_framer {
	struct mavlink_framer_stats stats;
	uint16_t head;
	uint16_t tail;
	uint8_t behind; /* bytes before head that were taken for a signature */
	bool skipping;
	bool opaque; /* to be set by the owner at any time */
	uint8_t window[MAVLINK_FRAMER_WINDOW];
};

void mavlink_framer_init(struct mavlink_framer *self);

/*
 * Copies as many bytes as have room, and returns how many. Once mavlink_framer_next has returned
 * false there is room for MAVLINK_FRAME_MAX, with opaque for one. Frames handed out before are no
 * longer valid.
 */
size_t mavlink_framer_write(struct mavlink_framer *self, const uint8_t *bytes, size_t count);

/* The next verified frame, valid until bytes are written. false: more bytes are needed. */
bool mavlink_framer_next(struct mavlink_framer *self, struct mavlink_frame *frame);

/* Is an unfinished frame waiting for more bytes? */
bool mavlink_framer_pending(const struct mavlink_framer *self);

/*
 * How many bytes must come before mavlink_framer_next, which has returned false, can say more:
 * 1…MAVLINK_FRAME_MAX. With fewer it need not be asked.
 */
size_t mavlink_framer_wanted(const struct mavlink_framer *self);

/*
 * The line is silent: looks for a whole frame behind the unfinished one. true: found, and the
 * unfinished one given up; go on with mavlink_framer_next. false: nothing changed.
 */
bool mavlink_framer_idle(struct mavlink_framer *self, struct mavlink_frame *frame);

#endif
