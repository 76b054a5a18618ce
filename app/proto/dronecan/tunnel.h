/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A virtual serial port through uavcan.tunnel.Targetted; sans-IO. The bytes are opaque.
 *
 * A channel is one asker: its node and its serial id. The asker opens it with any Targetted that
 * names our node and says that it carries MAVLink (an empty one is a keepalive), and it closes 3 s
 * after the asker's last one. MAVLink is protocol 0, 1, or 255 (undefined), which ArduPilot up to
 * 4.5 always sends; what says that it is anything else is counted and otherwise left. Until the
 * first and after the last nothing is sent. Answers carry the asker's node and serial id, protocol
 * and baud rate; chunks of at most 120 bytes, priority 16, FD when the asker's last one was. Each
 * asker has a port of its own, so the lock option excludes nobody; it is kept to be shown. When
 * every channel is taken, another asker is refused and counted.
 *
 * Context: the thread that owns it, no locks inside.
 */
#ifndef PHAROS_PROTO_DRONECAN_TUNNEL_H
#define PHAROS_PROTO_DRONECAN_TUNNEL_H

#include "proto/dronecan/transport.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct dronecan_tunnel_channel {
	int64_t heard_us;
	uint32_t baudrate;
	uint8_t node; /* of the asker */
	int8_t serial_id;
	uint8_t protocol;
	bool open;
	bool locked;
	bool fd;
	/* Bytes to send: a ring. */
	uint16_t first;
	uint16_t count;
	uint8_t bytes[DRONECAN_TUNNEL_BUFFER];
};

struct dronecan_tunnel_stats {
	uint32_t opened;
	uint32_t closed;
	uint32_t refused; /* askers, per Targetted: every channel is taken */
	uint32_t foreign; /* Targetted that carry something else than MAVLink */
	uint32_t malformed;
	uint32_t bytes_rx;
	uint32_t bytes_tx;
	uint32_t tx_no_room; /* writes refused */
};

struct dronecan_tunnel {
	struct dronecan_tunnel_channel channels[DRONECAN_TUNNEL_CHANNELS];
	struct dronecan_tunnel_stats stats;
	uint8_t turn; /* the channel that may send first */
};

/*
 * channel 0…DRONECAN_TUNNEL_CHANNELS - 1. opened: the asker is new on this channel, so whatever was
 * half parsed there belongs to another. data holds as long as the transfer's; size 0: a keepalive.
 */
struct dronecan_tunnel_received {
	uint8_t channel;
	bool opened;
	const uint8_t *data;
	size_t size;
};

void dronecan_tunnel_init(struct dronecan_tunnel *self);

/* For the subscription: whether a Targetted that begins so names this node. */
bool dronecan_tunnel_is_ours(uint8_t node_id, const uint8_t *payload, size_t size);

/* A Targetted for us. False: refused, counted. scratch keeps out->data. */
bool dronecan_tunnel_receive(struct dronecan_tunnel *self, int64_t now_us,
                             const struct dronecan_transfer *transfer,
                             struct dronecan_tunnel_targetted *scratch,
                             struct dronecan_tunnel_received *out);

/* Whether the asker was heard within 3 s. */
bool dronecan_tunnel_is_open(const struct dronecan_tunnel *self, int64_t now_us, uint8_t channel);

/* Bytes that wait to be sent. */
size_t dronecan_tunnel_waiting(const struct dronecan_tunnel *self, uint8_t channel);

/* Takes all of data or, when it is too much or the channel is closed, none (false, counted). */
bool dronecan_tunnel_write(struct dronecan_tunnel *self, int64_t now_us, uint8_t channel,
                           const uint8_t *data, size_t size);

/* Closes what has timed out; hands waiting bytes to the transport while it has room to spare. */
void dronecan_tunnel_step(struct dronecan_tunnel *self, int64_t now_us,
                          struct dronecan_transport *transport);

/* The next time-out; TIME_NEVER_US: nobody asks. Waiting bytes go at the next step. */
int64_t dronecan_tunnel_deadline_us(const struct dronecan_tunnel *self);

#endif
