/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The client of dynamic node id allocation; sans-IO.
 *
 * A request every 600…1000 ms; a follow-up 0…400 ms after the allocator answered with the start of
 * our unique id; any other Allocation message in between takes the follow-up back and restarts the
 * request timer. Random times come from the transport's generator. Requests are classic frames.
 *
 * Spec: uavcan.protocol.dynamic_node_id.Allocation, rules A to E.
 */
#ifndef PHAROS_PROTO_DRONECAN_ALLOCATION_H
#define PHAROS_PROTO_DRONECAN_ALLOCATION_H

#include "proto/dronecan/transport.h"

#include <stdbool.h>
#include <stdint.h>

#define DRONECAN_UNIQUE_ID_SIZE 16u

enum dronecan_allocation_state {
	DRONECAN_ALLOCATION_DONE, /* or never begun: the node id was configured */
	DRONECAN_ALLOCATION_REQUESTING,
	DRONECAN_ALLOCATION_FOLLOWING_UP,
};

struct dronecan_allocation {
	enum dronecan_allocation_state state;
	int64_t request_us;
	int64_t follow_up_us;
	uint8_t unique_id[DRONECAN_UNIQUE_ID_SIZE];
	uint8_t preferred_id;
	uint8_t confirmed; /* bytes of our unique id that the allocator has repeated */
};

/* Idle. unique_id: 16 bytes, copied. preferred_id 0…125, 0: any. */
void dronecan_allocation_init(struct dronecan_allocation *self, const uint8_t *unique_id,
                              uint8_t preferred_id);

/* Begins to ask; the transport is anonymous. */
void dronecan_allocation_start(struct dronecan_allocation *self, int64_t now_us,
                               struct dronecan_transport *transport);

/* An Allocation message. Returns the id that was allocated to us, else 0. */
uint8_t dronecan_allocation_receive(struct dronecan_allocation *self, int64_t now_us,
                                    struct dronecan_transport *transport,
                                    const struct dronecan_transfer *transfer);

void dronecan_allocation_step(struct dronecan_allocation *self, int64_t now_us,
                              struct dronecan_transport *transport);

/* TIME_NEVER_US when done. */
int64_t dronecan_allocation_deadline_us(const struct dronecan_allocation *self);

#endif
