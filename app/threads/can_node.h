/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light on a CAN bus, as the command thread has it: a DroneCAN node, commands of plain DroneCAN
 * for the lamp, and the channels of tunnels (tunnel_link.h). A board without CAN has none of it.
 *
 * Context: the command thread.
 */
#ifndef PHAROS_THREADS_CAN_NODE_H
#define PHAROS_THREADS_CAN_NODE_H

#include <stdint.h>

#include "core/device.h"
#include "core/limits.h"
#include "proto/dronecan/endpoint.h"

/* What people are told. */
struct can_node_status {
	uint8_t node_id; /* 0: none yet */
	struct dronecan_transport_stats transport;
	struct dronecan_tunnel_stats tunnel;
	struct dronecan_lights_stats lights;
	uint32_t requests;
	bool clash;          /* another node has our id */
	bool is_other_named; /* other: its unique id */
	uint8_t other[DRONECAN_UNIQUE_ID_SIZE];
};

#define CAN_NODE_CLASH_TEXT_MAX sizeof("CAN node id 127 is another node's too")

#ifdef CONFIG_CAN

/* With the parameters as loaded. */
void can_node_init(struct pharos_device *device);

/* A frame has come. */
void can_node_take(const struct dronecan_frame *frame);

/* What the device did: tells it. */
void can_node_tell(const struct device_effects *effects);

/* What is due. */
void can_node_step(void);
int64_t can_node_deadline_us(void);

/* Sends what the bus takes now. After everything that the command thread does; cheap. */
void can_node_flush(void);

void can_node_status_get(struct can_node_status *status);

/* What people are to be told while another node has our id; false: none has. */
bool can_node_clash_text(char text[CAN_NODE_CLASH_TEXT_MAX]);

#else

static inline void can_node_init(struct pharos_device *device)
{
}

static inline void can_node_take(const struct dronecan_frame *frame)
{
}

static inline void can_node_tell(const struct device_effects *effects)
{
}

static inline void can_node_step(void)
{
}

static inline int64_t can_node_deadline_us(void)
{
	return TIME_NEVER_US;
}

static inline void can_node_flush(void)
{
}

static inline bool can_node_clash_text(char text[CAN_NODE_CLASH_TEXT_MAX])
{
	(void)text;
	return false;
}

#endif

#endif
