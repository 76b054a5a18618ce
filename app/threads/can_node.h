/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light on a CAN bus, as the command thread has it: a DroneCAN node, commands of plain DroneCAN
 * for the lamp, and tunnels that are MAVLink links like a UART. A board without CAN has none of it.
 *
 * Context: functions take the command thread's state and run in that thread.
 */
#ifndef PHAROS_THREADS_CAN_NODE_H
#define PHAROS_THREADS_CAN_NODE_H

#include <errno.h>
#include <stdint.h>

#include "core/limits.h"
#include "proto/dronecan/endpoint.h"
#include "threads/command.h"
#include "threads/link.h"

struct can_node_stats {
	uint32_t applied;     /* commands for lamp and gimbal carried out */
	uint32_t refused;     /* by the arbiter or the illuminator */
	uint32_t unchanged;   /* repetitions of a command while somebody else is in command */
	uint32_t no_gimbal;   /* pan and tilt, but there is none */
	uint32_t log_skipped; /* LogMessages within a second of the last one */
};

/* What people are told. */
struct can_node_status {
	uint8_t node_id; /* 0: none yet */
	struct can_node_stats stats;
	struct dronecan_transport_stats transport;
	struct dronecan_tunnel_stats tunnel;
	struct dronecan_lights_stats lights;
	uint32_t requests;
};

#ifdef CONFIG_CAN

/* With the parameters as loaded. */
void can_node_init(struct command *command);

/* A frame from the CAN thread's pool, which gets it back. */
void can_node_take(struct command *command, struct dronecan_frame *frame);

/* What is due. */
void can_node_step(struct command *command);
int64_t can_node_deadline_us(void);

/* Sends what the bus takes now. After everything that the command thread does; cheap. */
void can_node_flush(void);

/* The lamp's state may be new: tell it. */
void can_node_report(const struct illuminator *illuminator);

/* Parameters of the group DRONECAN have changed. */
void can_node_configure(const struct params *params);

/* A LogMessage of level WARNING, at most one a second. */
void can_node_log(const char *text);

/* As link_send() and link_stats_get() of the link TUNNEL_LINK0 + channel. */
int can_node_tunnel_send(uint8_t channel, const uint8_t *frame, size_t length);
int can_node_tunnel_forward(uint8_t channel, const uint8_t *frame, size_t length);
int can_node_tunnel_stats(uint8_t channel, struct link_stats *stats);

void can_node_status_get(struct can_node_status *status);

#else

static inline void can_node_init(struct command *command)
{
}

static inline void can_node_take(struct command *command, struct dronecan_frame *frame)
{
}

static inline void can_node_step(struct command *command)
{
}

static inline int64_t can_node_deadline_us(void)
{
	return TIME_NEVER_US;
}

static inline void can_node_flush(void)
{
}

static inline void can_node_report(const struct illuminator *illuminator)
{
}

static inline void can_node_configure(const struct params *params)
{
}

static inline void can_node_log(const char *text)
{
}

static inline int can_node_tunnel_send(uint8_t channel, const uint8_t *frame, size_t length)
{
	return -ENODEV;
}

static inline int can_node_tunnel_forward(uint8_t channel, const uint8_t *frame, size_t length)
{
	return -ENODEV;
}

static inline int can_node_tunnel_stats(uint8_t channel, struct link_stats *stats)
{
	return -ENODEV;
}

#endif

#endif
