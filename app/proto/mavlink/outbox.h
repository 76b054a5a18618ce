/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the endpoint wants done: the frames in their order, then what is forwarded. First comes what
 * the device's effects say: so state is in force before its acknowledgement leaves, and others'
 * frames never stand before our own.
 */
#ifndef PHAROS_PROTO_MAVLINK_OUTBOX_H
#define PHAROS_PROTO_MAVLINK_OUTBOX_H

#include "proto/mavlink/limits.h"
#include "proto/mavlink/signing.h"

#include <stdbool.h>
#include <stdint.h>

struct mavlink_outbox_frame {
	uint16_t offset; /* into bytes */
	uint16_t length;
	uint8_t link;
};

/* What is to be done with the second image slot (upload.h): a block, or the last one. */
enum mavlink_outbox_upload {
	MAVLINK_OUTBOX_UPLOAD_NOTHING,
	MAVLINK_OUTBOX_UPLOAD_BEGIN,
	MAVLINK_OUTBOX_UPLOAD_BLOCK,
	MAVLINK_OUTBOX_UPLOAD_LAST,
	MAVLINK_OUTBOX_UPLOAD_ABORT,
};

struct mavlink_outbox {
	enum mavlink_outbox_upload upload;
	bool reboot;        /* once the frames are out */
	bool store_signing; /* signing is to be stored */
	uint8_t forward;    /* bit per link that the received frame goes on to, as it is */
	uint16_t command;   /* that was carried out and acknowledged; 0: none */
	uint16_t count;
	uint16_t used;
	struct mavlink_signing_record signing;
	struct mavlink_outbox_frame frames[MAVLINK_OUTBOX_FRAMES];
	uint8_t bytes[MAVLINK_OUTBOX_BYTES];
};

static inline void mavlink_outbox_clear(struct mavlink_outbox *self)
{
	self->upload = MAVLINK_OUTBOX_UPLOAD_NOTHING;
	self->reboot = false;
	self->store_signing = false;
	self->forward = 0;
	self->command = 0;
	self->count = 0;
	self->used = 0;
}

/* Does a frame of any length fit? */
static inline bool mavlink_outbox_has_room(const struct mavlink_outbox *self)
{
	return self->count < MAVLINK_OUTBOX_FRAMES &&
	       self->used + MAVLINK_FRAME_MAX <= MAVLINK_OUTBOX_BYTES;
}

/* Do so many? */
static inline bool mavlink_outbox_has_frames(const struct mavlink_outbox *self, uint32_t count)
{
	return self->count + count <= MAVLINK_OUTBOX_FRAMES &&
	       self->used + count * MAVLINK_FRAME_MAX <= MAVLINK_OUTBOX_BYTES;
}

#endif
