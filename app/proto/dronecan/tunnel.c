/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/tunnel.h"

#include <string.h>

#include "core/assert.h"

_Static_assert(DRONECAN_TUNNEL_CHUNK == sizeof(((struct dronecan_tunnel_targetted *)0)->buffer),
               "a chunk is what the type holds");

void dronecan_tunnel_init(struct dronecan_tunnel *self)
{
	memset(self, 0, sizeof(*self));
}

bool dronecan_tunnel_is_ours(uint8_t node_id, const uint8_t *payload, size_t size)
{
	/* The target's seven bits come after the protocol's byte; 0 would be an anonymous us. */
	return size >= 2u && node_id != 0 && payload[1] >> 1 == node_id;
}

bool dronecan_tunnel_is_open(const struct dronecan_tunnel *self, int64_t now_us, uint8_t channel)
{
	PHAROS_ASSERT(channel < DRONECAN_TUNNEL_CHANNELS);
	const struct dronecan_tunnel_channel *c = &self->channels[channel];

	return c->open && now_us - c->heard_us < DRONECAN_TUNNEL_TIMEOUT_US;
}

static void close_timed_out(struct dronecan_tunnel *self, int64_t now_us)
{
	for (uint8_t i = 0; i < DRONECAN_TUNNEL_CHANNELS; i++) {
		if (self->channels[i].open && !dronecan_tunnel_is_open(self, now_us, i)) {
			self->channels[i].open = false;
			self->stats.closed++;
		}
	}
}

/* The asker's channel, else a free one that is opened for it; NULL: all are taken. */
static struct dronecan_tunnel_channel *find(struct dronecan_tunnel *self, uint8_t node,
                                            int8_t serial_id, bool *opened)
{
	struct dronecan_tunnel_channel *free_one = NULL;

	*opened = false;
	for (size_t i = 0; i < DRONECAN_TUNNEL_CHANNELS; i++) {
		struct dronecan_tunnel_channel *c = &self->channels[i];

		if (c->open && c->node == node && c->serial_id == serial_id) {
			return c;
		}
		if (!c->open && free_one == NULL) {
			free_one = c;
		}
	}
	if (free_one != NULL) {
		*opened = true;
		self->stats.opened++;
		free_one->open = true;
		free_one->node = node;
		free_one->serial_id = serial_id;
		free_one->first = 0;
		free_one->count = 0;
	}
	return free_one;
}

static bool is_mavlink(uint8_t protocol)
{
	switch (protocol) {
	case DRONECAN_TUNNEL_PROTOCOL_MAVLINK:
	case DRONECAN_TUNNEL_PROTOCOL_MAVLINK2:
	case DRONECAN_TUNNEL_PROTOCOL_UNDEFINED:
		return true;
	default:
		return false;
	}
}

bool dronecan_tunnel_receive(struct dronecan_tunnel *self, int64_t now_us,
                             const struct dronecan_transfer *transfer,
                             struct dronecan_tunnel_targetted *scratch,
                             struct dronecan_tunnel_received *out)
{
	close_timed_out(self, now_us);
	if (transfer->source == 0 ||
	    !dronecan_tunnel_targetted_decode(scratch, !transfer->fd, transfer->data,
	                                      transfer->size)) {
		self->stats.malformed++;
		return false;
	}
	if (!is_mavlink(scratch->protocol.protocol)) {
		self->stats.foreign++;
		return false;
	}
	struct dronecan_tunnel_channel *c =
		find(self, transfer->source, scratch->serial_id, &out->opened);

	if (c == NULL) {
		self->stats.refused++;
		return false;
	}
	c->heard_us = now_us;
	c->baudrate = scratch->baudrate;
	c->protocol = scratch->protocol.protocol;
	c->locked = (scratch->options & DRONECAN_TUNNEL_TARGETTED_OPTION_LOCK_PORT) != 0;
	c->fd = transfer->fd;
	out->channel = (uint8_t)(c - self->channels);
	out->data = scratch->buffer;
	out->size = scratch->buffer_len;
	self->stats.bytes_rx += scratch->buffer_len;
	return true;
}

size_t dronecan_tunnel_waiting(const struct dronecan_tunnel *self, uint8_t channel)
{
	PHAROS_ASSERT(channel < DRONECAN_TUNNEL_CHANNELS);
	return self->channels[channel].count;
}

bool dronecan_tunnel_write(struct dronecan_tunnel *self, int64_t now_us, uint8_t channel,
                           const uint8_t *data, size_t size)
{
	PHAROS_ASSERT(channel < DRONECAN_TUNNEL_CHANNELS);
	struct dronecan_tunnel_channel *c = &self->channels[channel];

	if (!dronecan_tunnel_is_open(self, now_us, channel) ||
	    size > DRONECAN_TUNNEL_BUFFER - (size_t)c->count) {
		self->stats.tx_no_room++;
		return false;
	}
	for (size_t i = 0; i < size; i++) {
		c->bytes[(c->first + c->count + i) % DRONECAN_TUNNEL_BUFFER] = data[i];
	}
	c->count = (uint16_t)(c->count + size);
	return true;
}

/* One chunk. False: the transport refused it; the bytes stay. */
static bool send_chunk(struct dronecan_tunnel *self, struct dronecan_tunnel_channel *c,
                       int64_t now_us, struct dronecan_transport *transport)
{
	const size_t size = (c->count < DRONECAN_TUNNEL_CHUNK) ? c->count : DRONECAN_TUNNEL_CHUNK;
	const bool fd = c->fd && transport->fd;
	struct dronecan_tunnel_targetted message = {
		.protocol.protocol = c->protocol,
		.target_node = c->node,
		.serial_id = c->serial_id,
		.baudrate = c->baudrate,
		.buffer_len = (uint8_t)size,
	};
	uint8_t data[DRONECAN_TUNNEL_TARGETTED_MAX_SIZE];
	struct dronecan_transfer transfer = {
		.type = &dronecan_tunnel_targetted_type,
		.kind = DRONECAN_MESSAGE,
		.priority = DRONECAN_TUNNEL_PRIORITY,
		.fd = fd,
		.data = data,
	};

	for (size_t i = 0; i < size; i++) {
		message.buffer[i] = c->bytes[(c->first + i) % DRONECAN_TUNNEL_BUFFER];
	}
	if (!dronecan_tunnel_targetted_encode(&message, !fd, data, sizeof(data), &transfer.size) ||
	    !dronecan_transport_send(transport, now_us, &transfer)) {
		return false;
	}
	c->first = (uint16_t)((c->first + size) % DRONECAN_TUNNEL_BUFFER);
	c->count = (uint16_t)(c->count - size);
	self->stats.bytes_tx += (uint32_t)size;
	return true;
}

void dronecan_tunnel_step(struct dronecan_tunnel *self, int64_t now_us,
                          struct dronecan_transport *transport)
{
	close_timed_out(self, now_us);
	/* One chunk each in turn, so that a talkative channel does not starve the others. */
	for (size_t idle = 0; idle < DRONECAN_TUNNEL_CHANNELS;) {
		struct dronecan_tunnel_channel *c = &self->channels[self->turn];

		if (c->open && c->count > 0) {
			if (dronecan_transport_room(transport) <= DRONECAN_TUNNEL_TX_RESERVE ||
			    !send_chunk(self, c, now_us, transport)) {
				return;
			}
			idle = 0;
		} else {
			idle++;
		}
		self->turn = (uint8_t)((self->turn + 1u) % DRONECAN_TUNNEL_CHANNELS);
	}
}

int64_t dronecan_tunnel_deadline_us(const struct dronecan_tunnel *self)
{
	int64_t deadline_us = TIME_NEVER_US;

	for (size_t i = 0; i < DRONECAN_TUNNEL_CHANNELS; i++) {
		const struct dronecan_tunnel_channel *c = &self->channels[i];

		if (c->open && c->heard_us + DRONECAN_TUNNEL_TIMEOUT_US < deadline_us) {
			deadline_us = c->heard_us + DRONECAN_TUNNEL_TIMEOUT_US;
		}
	}
	return deadline_us;
}
