/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Message signing: who may say something. SHA-256 over a shared key and the frame, cut to 48 bits,
 * with a timestamp that must rise. Sans-IO.
 *
 *   mavlink_signing_init(&signing, now_us, &stored);
 *   if (mavlink_signing_check(&signing, now_us, &frame) == MAVLINK_SIGNING_ACCEPTED) …
 *   length += mavlink_signing_sign(&signing, now_us, bytes, length, link_id);
 *
 * With a key, a frame is heard only if its signature is right, it is at most a minute behind the
 * local timestamp, and it is newer than the last one of its stream (system, component and link id
 * of the sender, on whichever link it comes). No message is excepted: an unsigned HEARTBEAT could
 * give the light an id, or keep its lamp on. Without a key everything is heard, signed or not, and
 * nothing is signed.
 *
 * The local timestamp begins where the stored one ended, since the device has no clock; it goes on
 * with the time since the start, and to the latest that a rightly signed frame showed. Each frame
 * that is signed takes the next. At 2^48 - 1, in 2104, it stands still: a new key begins anew.
 *
 * A full table of streams reuses the place of a stream whose last frame is more than a minute
 * behind: nothing of it could be repeated. If there is none, the new stream is refused.
 *
 * A key that was lost (what was stored cannot be read) locks: every frame is refused until a new
 * key is set, or none, which only the device's own shell can do then.
 *
 * The key is in the owner's memory and in what is stored; nothing here tells it.
 *
 * Context: the thread that owns it. Spec: mavlink.io/en/guide/message_signing.html.
 */
#ifndef PHAROS_PROTO_MAVLINK_SIGNING_H
#define PHAROS_PROTO_MAVLINK_SIGNING_H

#include "proto/mavlink/frame.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MAVLINK_SIGNING_KEY_BYTES 32

/* Timestamps: units of 10 µs since 1 January 2015, 00:00 UTC, in 48 bits. */
#define MAVLINK_TIMESTAMP_UNIT_US 10
#define MAVLINK_TIMESTAMP_SECOND  UINT64_C(100000)
#define MAVLINK_TIMESTAMP_MINUTE  (60 * MAVLINK_TIMESTAMP_SECOND)
#define MAVLINK_TIMESTAMP_MAX     ((UINT64_C(1) << 48) - 1)
#define MAVLINK_TIMESTAMP_EPOCH_S UINT64_C(1420070400) /* as Unix time */

/* What is stored, as one value, so that a key never meets another's timestamp. */
struct mavlink_signing_record {
	uint64_t timestamp;
	uint8_t key[MAVLINK_SIGNING_KEY_BYTES]; /* all zero: none, signing is off */
};

/* The timestamp of a record whose key, all zero, was lost: no timestamp that there can be. */
#define MAVLINK_SIGNING_LOST UINT64_MAX

enum mavlink_signing_verdict {
	MAVLINK_SIGNING_ACCEPTED, /* rightly signed; or there is no key */
	MAVLINK_SIGNING_UNSIGNED,
	MAVLINK_SIGNING_BAD_SIGNATURE, /* another key, or changed on the way */
	MAVLINK_SIGNING_REPLAYED,      /* not newer than the last of its stream */
	MAVLINK_SIGNING_OLD,           /* more than a minute behind */
	MAVLINK_SIGNING_NO_ROOM,       /* too many streams at once */
	MAVLINK_SIGNING_VERDICTS
};

struct mavlink_signing_stream {
	uint64_t timestamp; /* of its last frame */
	uint8_t system_id;
	uint8_t component_id;
	uint8_t link_id;
};

struct mavlink_signing_stats {
	uint32_t verdicts[MAVLINK_SIGNING_VERDICTS]; /* of frames, while there was a key */
	uint32_t signed_frames;                      /* sent */
	uint32_t setups;                             /* SETUP_SIGNING obeyed */
	uint32_t setups_refused; /* link not secure, not addressed to us, or not signed with the key
	                          */
};

struct mavlink_signing {
	struct mavlink_signing_record now; /* timestamp: at at_us */
	struct mavlink_signing_stats stats;
	uint64_t stored; /* timestamp that was last given out to be stored */
	int64_t at_us;
	bool on;
	bool locked;   /* and on: the key was lost */
	bool to_store; /* the key is new */
	uint8_t stream_count;
	struct mavlink_signing_stream streams[MAVLINK_SIGNING_STREAMS_MAX];
};

/* stored: from the last run; an all-zero key: off, or lost. */
void mavlink_signing_init(struct mavlink_signing *self, int64_t now_us,
                          const struct mavlink_signing_record *stored);

/*
 * A key comes (all zero: goes). timestamp: where to begin. The key that is there already again only
 * moves the timestamp on, so that SETUP_SIGNING can be repeated and nothing else can.
 */
void mavlink_signing_set_key(struct mavlink_signing *self, int64_t now_us,
                             const struct mavlink_signing_record *record);

/* Whether the frame may be heard; counted. */
enum mavlink_signing_verdict mavlink_signing_check(struct mavlink_signing *self, int64_t now_us,
                                                   const struct mavlink_frame *frame);

/*
 * Appends the signature to a frame built with has_signature; bytes has room for it. There is a key
 * (asserted). Returns MAVLINK_SIGNATURE_BYTES.
 */
size_t mavlink_signing_sign(struct mavlink_signing *self, int64_t now_us, uint8_t *bytes,
                            size_t length, uint8_t link_id);

/* When to store; TIME_NEVER_US: there is no key. In the past: now. */
int64_t mavlink_signing_deadline_us(const struct mavlink_signing *self);

/* What to store now. It counts as stored. */
struct mavlink_signing_record mavlink_signing_take_record(struct mavlink_signing *self,
                                                          int64_t now_us);

/* The local timestamp. */
uint64_t mavlink_signing_timestamp(const struct mavlink_signing *self, int64_t now_us);

/* For people, constant and never NULL: "accepted", "bad signature", … */
const char *mavlink_signing_verdict_name(enum mavlink_signing_verdict verdict);

#endif
