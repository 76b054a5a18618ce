/* SPDX-License-Identifier: Apache-2.0 */
/* What the DroneCAN suites share: frames from hex, a peer that sends, and a wire between. */
#ifndef TESTS_PROTO_DRONECAN_BUS_H
#define TESTS_PROTO_DRONECAN_BUS_H

#include "proto/dronecan/transport.h"

#include <zephyr/ztest.h>

#include <string.h>

#define BUS_FRAMES_MAX 64

/* Frames on their way, in order. */
struct bus {
	size_t count;
	struct dronecan_frame frames[BUS_FRAMES_MAX];
};

static inline struct dronecan_frame bus_frame(uint32_t id, const uint8_t *data, size_t size)
{
	struct dronecan_frame frame = {.id = id, .size = (uint8_t)size};

	memcpy(frame.data, data, size);
	return frame;
}

#define FRAME(id, ...)                                                                             \
	bus_frame(id, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

/* Everything the transport has to send, appended. */
static inline void bus_take(struct bus *bus, struct dronecan_transport *from, int64_t now_us)
{
	while (bus->count < BUS_FRAMES_MAX &&
	       dronecan_transport_next_frame(from, now_us, &bus->frames[bus->count])) {
		bus->count++;
		dronecan_transport_frame_sent(from);
	}
}

/* The frames of one transfer as node `source` would send it. The last argument counts on. */
static inline void bus_send(struct bus *bus, struct dronecan_transport *peer, int64_t now_us,
                            const struct dronecan_type *type, enum dronecan_kind kind,
                            uint8_t target, const uint8_t *data, size_t size)
{
	const struct dronecan_transfer transfer = {
		.type = type,
		.kind = kind,
		.target = target,
		.priority = 20,
		.fd = peer->fd,
		.data = data,
		.size = size,
	};

	bus->count = 0;
	zassert_true(dronecan_transport_send(peer, now_us, &transfer));
	bus_take(bus, peer, now_us);
}

#endif
