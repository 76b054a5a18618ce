/* SPDX-License-Identifier: Apache-2.0 */
/*
 * All of DroneCAN for one CAN bus: transport, node, tunnel and lights put together; sans-IO.
 *
 * A thread does this: each received frame into _receive(), _step() at the deadline and after
 * whatever was written or reported, then frames out while _next_frame() has one and the driver
 * takes it. The device's effects and the outbox of each call are to be performed before the next.
 *
 * Context: the thread that owns it, no locks inside.
 */
#ifndef PHAROS_PROTO_DRONECAN_ENDPOINT_H
#define PHAROS_PROTO_DRONECAN_ENDPOINT_H

#include "core/device.h"
#include "proto/dronecan/firmware.h"
#include "proto/dronecan/lights.h"
#include "proto/dronecan/node.h"
#include "proto/dronecan/transport.h"
#include "proto/dronecan/tunnel.h"

#include <stdbool.h>
#include <stdint.h>

/* node_id 0…127, 0: ask the allocator. fd: the bus may carry FD frames. seed: any. */
struct dronecan_endpoint_config {
	struct dronecan_node_config node;
	struct dronecan_lights_config lights;
	uint8_t node_id;
	bool fd;
	uint32_t seed;
	const char
		*no_update; /* why there is no firmware update, at most 127 bytes; NULL: there is */
};

/* tunnel_received: tunnel is set, its data holds until the next _receive(). */
struct dronecan_outbox {
	struct dronecan_node_outbox node;
	struct dronecan_firmware_outbox firmware;
	bool tunnel_received;
	struct dronecan_tunnel_received tunnel;
};

struct dronecan_endpoint {
	struct dronecan_transport transport;
	struct dronecan_node node;
	struct dronecan_tunnel tunnel;
	struct dronecan_lights lights;
	struct dronecan_firmware firmware;
	struct dronecan_tunnel_targetted scratch;
};

/* config, device: kept by reference. */
void dronecan_endpoint_init(struct dronecan_endpoint *self, int64_t now_us,
                            const struct dronecan_endpoint_config *config,
                            struct pharos_device *device);

void dronecan_endpoint_receive(struct dronecan_endpoint *self, int64_t now_us,
                               const struct dronecan_frame *frame, struct dronecan_outbox *out);

/*
 * Looks at what the lamp is like now: becomes NodeStatus, hardpoint.Status and Temperature. After
 * whatever has changed it, and when the firmware's state has changed. The first call
 * makes the node OPERATIONAL. Health is ERROR while heat or a failed sensor allow no light at all,
 * else WARNING while another node has our id (node.clash.on: report again when it changes); the
 * vendor specific code is ILLUMINATOR_ERROR_FLAGS. Mode SOFTWARE_UPDATE while an image is read.
 */
void dronecan_endpoint_report(struct dronecan_endpoint *self, int64_t now_us);

void dronecan_endpoint_step(struct dronecan_endpoint *self, int64_t now_us,
                            struct dronecan_outbox *out);
int64_t dronecan_endpoint_deadline_us(const struct dronecan_endpoint *self);

/* As dronecan_transport_next_frame(), and refills from the tunnel. */
bool dronecan_endpoint_next_frame(struct dronecan_endpoint *self, int64_t now_us,
                                  struct dronecan_frame *frame);
void dronecan_endpoint_frame_sent(struct dronecan_endpoint *self);

#endif
