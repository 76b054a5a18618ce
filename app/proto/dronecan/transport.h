/* SPDX-License-Identifier: Apache-2.0 */
/*
 * DroneCAN transfers over CAN frames, classic and FD; sans-IO.
 *
 * Receiving: frames in, whole transfers out. Only subscribed types take memory. Transfers of one
 * type from several nodes may interleave. What the wire does wrong is refused and counted, never
 * more: lost, repeated and reordered frames, wrong CRC, transfers older than 2 s. When the pools
 * are full, a new transfer takes the place of the session idle for longest; when none is idle, of
 * the oldest incomplete transfer of lower priority; when there is none, it is refused.
 *
 * Sending: transfers in, frames out by priority, then in order. A transfer whose frames have begun
 * is finished before a later one to the same peer and of the same type, whatever its priority. When
 * the queue is full, a new transfer takes the place of the newest one of lower priority of which
 * nothing was sent; when there is none, it is refused. One that waited for 1 s is dropped. All
 * counted.
 *
 * On FD a response is FD when its request was; the caller says so. No tail array optimisation
 * there.
 *
 * Context: the thread that owns it, no locks inside. Spec: DroneCAN, "CAN bus transport layer".
 */
#ifndef PHAROS_PROTO_DRONECAN_TRANSPORT_H
#define PHAROS_PROTO_DRONECAN_TRANSPORT_H

#include "proto/dronecan/limits.h"
#include "proto/dronecan/type.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A data frame with an extended (29 bit) id. size: 0…8, with fd a length that FD has, up to 64. */
struct dronecan_frame {
	uint32_t id;
	bool fd;
	uint8_t size;
	uint8_t data[DRONECAN_FRAME_SIZE_FD];
};

enum dronecan_kind {
	DRONECAN_MESSAGE,
	DRONECAN_REQUEST,
	DRONECAN_RESPONSE,
};

/*
 * source, target 0…127: 0 is an anonymous source, a broadcast. priority 0 (highest) … 31. id: the
 * transfer id, 0…31. data of a received one holds until the next dronecan_transport_receive(),
 * and no longer than the frame given to it.
 */
struct dronecan_transfer {
	const struct dronecan_type *type;
	enum dronecan_kind kind;
	uint8_t source;
	uint8_t target;
	uint8_t priority;
	uint8_t id;
	bool fd;
	const uint8_t *data;
	size_t size;
};

/* Whose transfers are taken. Our own id can only be another node's: clash.h. */
enum dronecan_from {
	DRONECAN_FROM_OTHERS,
	DRONECAN_FROM_ALL,
	DRONECAN_FROM_OWN_ID,
};

/*
 * is_ours: NULL, or looks at the payload's part in the first frame and says whether the transfer
 * concerns this node. One that does not takes no buffer.
 */
struct dronecan_subscription {
	const struct dronecan_type *type;
	enum dronecan_kind kind;
	enum dronecan_from from;
	bool (*is_ours)(uint8_t node_id, const uint8_t *payload, size_t size);
};

struct dronecan_transport_stats {
	/* GetTransportStats. */
	uint64_t transfers_tx;
	uint64_t transfers_rx;
	uint64_t frames_tx;
	uint64_t frames_rx;
	/* Frames and transfers refused, by reason. */
	uint32_t rx_malformed;     /* no tail byte, impossible id, length or flags */
	uint32_t rx_own_id;        /* another node has our node id */
	uint32_t rx_without_start; /* the start was lost, or came out of order */
	uint32_t rx_repeated;      /* a frame of the transfer received last */
	uint32_t rx_wrong_toggle;  /* repeated, lost or out of order within a transfer */
	uint32_t rx_wrong_id;      /* neither this transfer's nor the last one's */
	uint32_t rx_incomplete;    /* a new transfer began, or 2 s passed, before the end */
	uint32_t rx_wrong_crc;
	uint32_t rx_too_long;
	uint32_t rx_evicted; /* incomplete, given up for one of higher priority */
	uint32_t rx_no_room; /* refused: pools full */
	uint32_t tx_evicted; /* given up for one of higher priority */
	uint32_t tx_no_room; /* refused: queue full */
	uint32_t tx_expired; /* waited for too long */
};

/* One stream of transfers of a type from a node. */
struct dronecan_session {
	int64_t started_us; /* first frame of the transfer under way, or of the last one */
	uint16_t crc;
	uint16_t wire_crc;
	uint16_t size;
	uint8_t subscription;
	uint8_t source;
	uint8_t priority;
	uint8_t next_id; /* under way: its id; idle: the one expected next */
	int8_t buffer;   /* -1: none */
	bool used;
	bool under_way;
	bool toggle;
	bool fd;
};

struct dronecan_tx {
	int64_t queued_us;
	uint32_t frame_id;
	uint32_t order;
	const struct dronecan_type *type;
	uint16_t size;
	uint16_t sent; /* of the payload with its CRC, bytes */
	uint16_t crc;
	uint8_t target;
	uint8_t priority;
	uint8_t id;
	bool used;
	bool toggle;
	bool fd;
	uint8_t data[DRONECAN_TX_PAYLOAD_MAX];
};

struct dronecan_counter {
	const struct dronecan_type *type;
	uint8_t target;
	uint8_t next;
};

/* Readable by the owner; only the functions below write. */
struct dronecan_transport {
	const struct dronecan_subscription *subscriptions;
	size_t subscriptions_count;
	uint8_t node_id;
	bool fd;
	uint32_t random;
	struct dronecan_transport_stats stats;

	struct dronecan_session sessions[DRONECAN_RX_SESSIONS];
	bool buffer_taken[DRONECAN_RX_BUFFERS];
	uint8_t buffers[DRONECAN_RX_BUFFERS][DRONECAN_RX_PAYLOAD_MAX];
	int8_t delivered; /* buffer that the caller may still read, -1: none */

	struct dronecan_tx tx[DRONECAN_TX_TRANSFERS];
	uint32_t tx_order;
	int8_t tx_current; /* the transfer of the frame shown last, -1: none */
	struct dronecan_counter counters[DRONECAN_TX_COUNTERS];
	uint8_t counters_next;
};

/*
 * subscriptions: at most 32, constant, kept by reference. node_id 0…127, 0: anonymous. fd: send FD
 * frames where the transfer says so. seed: any; makes the discriminator of anonymous frames.
 */
void dronecan_transport_init(struct dronecan_transport *self,
                             const struct dronecan_subscription *subscriptions, size_t count,
                             uint8_t node_id, bool fd, uint32_t seed);

/* node_id 1…127: from now on. What was queued keeps the id it was queued with. */
void dronecan_transport_set_node_id(struct dronecan_transport *self, uint8_t node_id);

/* True: *out is a transfer. Frames for others and of other types are ignored. */
bool dronecan_transport_receive(struct dronecan_transport *self, int64_t now_us,
                                const struct dronecan_frame *frame, struct dronecan_transfer *out);

/*
 * Queues a copy. source is ours; id is taken only from a RESPONSE (the request's), else counted
 * here. fd takes effect when the transport's is on. False, nothing queued: no room (counted); or
 * anonymous and not a message of at most 7 bytes. size <= DRONECAN_TX_PAYLOAD_MAX, asserted.
 */
bool dronecan_transport_send(struct dronecan_transport *self, int64_t now_us,
                             const struct dronecan_transfer *transfer);

/* The transfer id that the last message of the type, or request of the type to target, carries. */
uint8_t dronecan_transport_last_id(const struct dronecan_transport *self,
                                   const struct dronecan_type *type, uint8_t target);

/* Transfers that could be queued now. */
size_t dronecan_transport_room(const struct dronecan_transport *self);

/*
 * Shows the frame to send now; false: none. It stays until dronecan_transport_frame_sent() (the
 * driver took it) and may be another one the next time when something more urgent was queued.
 */
bool dronecan_transport_next_frame(struct dronecan_transport *self, int64_t now_us,
                                   struct dronecan_frame *frame);
void dronecan_transport_frame_sent(struct dronecan_transport *self);

/* Sum of what was refused on the way in. */
uint64_t dronecan_transport_rx_errors(const struct dronecan_transport *self);

/* CRC-16-CCITT-FALSE: polynomial 0x1021, not reflected, no final inversion. */
uint16_t dronecan_crc(uint16_t crc, const uint8_t *data, size_t size);

/* The next number of a xorshift generator; *state is never 0. Not for secrets. */
uint32_t dronecan_random(uint32_t *state);

#endif
