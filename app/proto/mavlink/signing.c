/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/signing.h"

#include "core/assert.h"
#include "core/limits.h"
#include "core/sha256.h"
#include "proto/mavlink/dialect.h"

#include <string.h>

/* Where the fields lie in a signature. */
#define TIMESTAMP_AT    1
#define TIMESTAMP_BYTES 6
#define HASH_AT         (TIMESTAMP_AT + TIMESTAMP_BYTES)
#define HASH_BYTES      6

_Static_assert(HASH_AT + HASH_BYTES == MAVLINK_SIGNATURE_BYTES, "link id, timestamp, hash");

static uint64_t limited(uint64_t timestamp)
{
	return timestamp < MAVLINK_TIMESTAMP_MAX ? timestamp : MAVLINK_TIMESTAMP_MAX;
}

static bool is_zero(const uint8_t key[MAVLINK_SIGNING_KEY_BYTES])
{
	uint8_t any = 0;

	for (size_t i = 0; i < MAVLINK_SIGNING_KEY_BYTES; i++) {
		any |= key[i];
	}
	return any == 0;
}

static uint64_t timestamp_read(const uint8_t *bytes)
{
	uint64_t timestamp = 0;

	for (size_t i = TIMESTAMP_BYTES; i > 0; i--) {
		timestamp = timestamp << 8 | bytes[i - 1];
	}
	return timestamp;
}

static void timestamp_write(uint8_t *bytes, uint64_t timestamp)
{
	for (size_t i = 0; i < TIMESTAMP_BYTES; i++) {
		bytes[i] = (uint8_t)(timestamp >> 8 * i);
	}
}

uint64_t mavlink_signing_timestamp(const struct mavlink_signing *self, int64_t now_us)
{
	const uint64_t passed = (uint64_t)(now_us - self->at_us) / MAVLINK_TIMESTAMP_UNIT_US;

	return limited(self->now.timestamp + passed);
}

/* The local timestamp is this from now on. */
static void begin_at(struct mavlink_signing *self, int64_t now_us, uint64_t timestamp)
{
	self->now.timestamp = limited(timestamp);
	self->at_us = now_us;
}

void mavlink_signing_init(struct mavlink_signing *self, int64_t now_us,
                          const struct mavlink_signing_record *stored)
{
	memset(self, 0, sizeof(*self));
	self->now = *stored;
	self->locked = is_zero(stored->key) && stored->timestamp == MAVLINK_SIGNING_LOST;
	self->on = !is_zero(stored->key) || self->locked;
	begin_at(self, now_us, self->locked ? 0 : stored->timestamp);
	self->stored = self->now.timestamp;
}

void mavlink_signing_set_key(struct mavlink_signing *self, int64_t now_us,
                             const struct mavlink_signing_record *record)
{
	const bool on = !is_zero(record->key);

	if (on && memcmp(record->key, self->now.key, sizeof(self->now.key)) == 0) {
		const uint64_t now = mavlink_signing_timestamp(self, now_us);

		begin_at(self, now_us, record->timestamp > now ? record->timestamp : now);
		return;
	}
	self->now = *record;
	self->on = on;
	self->locked = false;
	self->to_store = true;
	self->stream_count = 0;
	begin_at(self, now_us, record->timestamp);
}

/* The hash over key, frame and the signature's first fields, which lie behind the frame. */
static void hash(const struct mavlink_signing *self, const uint8_t *bytes, size_t length,
                 uint8_t result[HASH_BYTES])
{
	struct sha256 sum;

	sha256_begin(&sum);
	sha256_add(&sum, self->now.key, sizeof(self->now.key));
	sha256_add(&sum, bytes, length + HASH_AT);
	memcpy(result, sha256_end(&sum), HASH_BYTES);
}

/* Takes as long whichever byte is wrong. */
static bool is_right(const struct mavlink_signing *self, const struct mavlink_frame *frame)
{
	const size_t length = (size_t)frame->length - MAVLINK_SIGNATURE_BYTES;
	const uint8_t *const theirs = frame->bytes + length + HASH_AT;
	uint8_t ours[HASH_BYTES];
	uint8_t differs = 0;

	hash(self, frame->bytes, length, ours);
	for (size_t i = 0; i < HASH_BYTES; i++) {
		differs |= ours[i] ^ theirs[i];
	}
	return differs == 0;
}

static struct mavlink_signing_stream *
stream_find(struct mavlink_signing *self, const struct mavlink_frame *frame, uint8_t link_id)
{
	for (uint8_t i = 0; i < self->stream_count; i++) {
		struct mavlink_signing_stream *const stream = &self->streams[i];

		if (stream->system_id == frame->system_id &&
		    stream->component_id == frame->component_id && stream->link_id == link_id) {
			return stream;
		}
	}
	return NULL;
}

static bool is_old(uint64_t timestamp, uint64_t now)
{
	return timestamp + MAVLINK_TIMESTAMP_MINUTE < now;
}

/* A free place, or that of a stream of which nothing could be repeated; NULL: none. */
static struct mavlink_signing_stream *stream_place(struct mavlink_signing *self, uint64_t now)
{
	if (self->stream_count < MAVLINK_SIGNING_STREAMS_MAX) {
		return &self->streams[self->stream_count++];
	}
	for (uint8_t i = 0; i < self->stream_count; i++) {
		if (is_old(self->streams[i].timestamp, now)) {
			return &self->streams[i];
		}
	}
	return NULL;
}

static enum mavlink_signing_verdict judge(struct mavlink_signing *self, int64_t now_us,
                                          const struct mavlink_frame *frame)
{
	if (!frame->has_signature) {
		return MAVLINK_SIGNING_UNSIGNED;
	}
	if (self->locked || !is_right(self, frame)) {
		return MAVLINK_SIGNING_BAD_SIGNATURE;
	}

	const uint8_t *const signature = frame->bytes + frame->length - MAVLINK_SIGNATURE_BYTES;
	const uint64_t timestamp = timestamp_read(signature + TIMESTAMP_AT);
	const uint64_t now = mavlink_signing_timestamp(self, now_us);
	struct mavlink_signing_stream *stream = stream_find(self, frame, signature[0]);

	if (stream != NULL && timestamp <= stream->timestamp) {
		return MAVLINK_SIGNING_REPLAYED;
	}
	if (is_old(timestamp, now)) {
		return MAVLINK_SIGNING_OLD;
	}
	if (stream == NULL) {
		stream = stream_place(self, now);
	}
	if (stream == NULL) {
		return MAVLINK_SIGNING_NO_ROOM;
	}
	*stream = (struct mavlink_signing_stream){
		.timestamp = timestamp,
		.system_id = frame->system_id,
		.component_id = frame->component_id,
		.link_id = signature[0],
	};
	if (timestamp > now) {
		begin_at(self, now_us, timestamp);
	}
	return MAVLINK_SIGNING_ACCEPTED;
}

enum mavlink_signing_verdict mavlink_signing_check(struct mavlink_signing *self, int64_t now_us,
                                                   const struct mavlink_frame *frame)
{
	if (!self->on) {
		return MAVLINK_SIGNING_ACCEPTED;
	}

	const enum mavlink_signing_verdict verdict = judge(self, now_us, frame);

	self->stats.verdicts[verdict]++;
	return verdict;
}

size_t mavlink_signing_sign(struct mavlink_signing *self, int64_t now_us, uint8_t *bytes,
                            size_t length, uint8_t link_id)
{
	uint8_t *const signature = bytes + length;

	PHAROS_ASSERT(self->on);
	begin_at(self, now_us, mavlink_signing_timestamp(self, now_us) + 1);
	signature[0] = link_id;
	timestamp_write(signature + TIMESTAMP_AT, self->now.timestamp);
	hash(self, bytes, length, signature + HASH_AT);
	self->stats.signed_frames++;
	return MAVLINK_SIGNATURE_BYTES;
}

int64_t mavlink_signing_deadline_us(const struct mavlink_signing *self)
{
	const uint64_t due = self->stored + MAVLINK_SIGNING_STORE_S * MAVLINK_TIMESTAMP_SECOND;

	if (self->to_store) {
		return self->at_us;
	}
	if (!self->on || self->locked || due > MAVLINK_TIMESTAMP_MAX) {
		return TIME_NEVER_US;
	}
	if (due <= self->now.timestamp) {
		return self->at_us;
	}
	return self->at_us + (int64_t)(due - self->now.timestamp) * MAVLINK_TIMESTAMP_UNIT_US;
}

struct mavlink_signing_record mavlink_signing_take_record(struct mavlink_signing *self,
                                                          int64_t now_us)
{
	begin_at(self, now_us, mavlink_signing_timestamp(self, now_us));
	self->stored = self->now.timestamp;
	self->to_store = false;
	return self->now;
}

const char *mavlink_signing_verdict_name(enum mavlink_signing_verdict verdict)
{
	switch (verdict) {
	case MAVLINK_SIGNING_ACCEPTED:
		return "accepted";
	case MAVLINK_SIGNING_UNSIGNED:
		return "unsigned";
	case MAVLINK_SIGNING_BAD_SIGNATURE:
		return "bad signature";
	case MAVLINK_SIGNING_REPLAYED:
		return "replayed";
	case MAVLINK_SIGNING_OLD:
		return "old";
	case MAVLINK_SIGNING_NO_ROOM:
		return "no room";
	case MAVLINK_SIGNING_VERDICTS:
		break;
	}
	return "";
}
