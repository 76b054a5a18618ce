/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A DroneCAN node; sans-IO: NodeStatus at 1 Hz, GetNodeInfo, dynamic node id, parameters,
 * RestartNode, GetTransportStats, LogMessage.
 *
 * Answers go to the transport, with the priority and the kind of frame (classic, FD) of the
 * request; what the rest of the firmware has to do comes back in the outbox.
 *
 * Health is for what makes the light unusable, or its bus: autopilots refuse to arm while it is not
 * OK.
 * Throttling and the like belong into the vendor specific code.
 *
 * Context: the thread that owns it, no locks inside.
 */
#ifndef PHAROS_PROTO_DRONECAN_NODE_H
#define PHAROS_PROTO_DRONECAN_NODE_H

#include "core/device.h"
#include "proto/dronecan/allocation.h"
#include "proto/dronecan/clash.h"
#include "proto/dronecan/transport.h"

#include <stdbool.h>
#include <stdint.h>

/* Kept by reference: lives as long as the node. unique_id: stable, not all zero. name: <= 80. */
struct dronecan_node_config {
	uint8_t unique_id[DRONECAN_UNIQUE_ID_SIZE];
	const char *name;
	uint8_t software_major;
	uint8_t software_minor;
	uint8_t hardware_major;
	uint8_t hardware_minor;
	uint32_t vcs_commit;  /* 0: not known */
	uint8_t preferred_id; /* what to ask the allocator for, 0: any */
};

/* As in NodeStatus: DRONECAN_NODE_STATUS_HEALTH_… and _MODE_… */
struct dronecan_node_condition {
	uint8_t health;
	uint8_t mode;
	uint16_t vendor_code;
};

enum dronecan_node_action_kind {
	DRONECAN_NODE_RESTART,      /* reset the device; the answer has had time to leave */
	DRONECAN_NODE_SAVE,         /* write the parameters to storage */
	DRONECAN_NODE_ERASE,        /* erase the stored parameters; all are at defaults now */
	DRONECAN_NODE_ID_ALLOCATED, /* node_id: in force already */
};

struct dronecan_node_action {
	enum dronecan_node_action_kind kind;
	uint8_t node_id;
};

/* One call returns at most two. */
#define DRONECAN_NODE_OUTBOX_MAX 2u
struct dronecan_node_outbox {
	uint8_t count;
	struct dronecan_node_action actions[DRONECAN_NODE_OUTBOX_MAX];
};

struct dronecan_node_stats {
	uint32_t requests;
	uint32_t malformed;      /* payloads that are not of their type */
	uint32_t unanswered;     /* no room in the transport */
	uint32_t params_refused; /* sets of a wrong type, and those that core/params refused */
};

struct dronecan_node {
	const struct dronecan_node_config *config;
	struct dronecan_transport *transport;
	struct pharos_device *device;
	struct dronecan_allocation allocation;
	struct dronecan_clash clash;
	struct dronecan_node_condition condition;
	struct dronecan_node_stats stats;
	int64_t status_us;  /* the next NodeStatus */
	int64_t restart_us; /* TIME_NEVER_US: nobody asked */
	uint64_t bus_errors;
};

/*
 * The transport is initialised; anonymous means: ask the allocator. Mode INITIALIZATION, health OK
 * until told otherwise.
 */
void dronecan_node_init(struct dronecan_node *self, int64_t now_us,
                        const struct dronecan_node_config *config,
                        struct dronecan_transport *transport, struct pharos_device *device);

/* A change of health or mode is sent at the next step instead of within a second. */
void dronecan_node_set_condition(struct dronecan_node *self, int64_t now_us,
                                 const struct dronecan_node_condition *condition);

/* Errors that the CAN controller has counted since boot, for GetTransportStats. */
void dronecan_node_set_bus_errors(struct dronecan_node *self, uint64_t bus_errors);

/* A transfer of one of the node's types (others: ignored). *out is overwritten. */
void dronecan_node_receive(struct dronecan_node *self, int64_t now_us,
                           const struct dronecan_transfer *transfer,
                           struct dronecan_node_outbox *out);

/* At its deadline or before. *out is overwritten. */
void dronecan_node_step(struct dronecan_node *self, int64_t now_us,
                        struct dronecan_node_outbox *out);
int64_t dronecan_node_deadline_us(const struct dronecan_node *self);

/* RESTART comes in an outbox soon, after what is queued has had time to leave. */
void dronecan_node_restart(struct dronecan_node *self, int64_t now_us);

/*
 * level: DRONECAN_DEBUG_LOG_LEVEL_…. source and text are cut to 31 and 90 bytes. False: anonymous
 * or no room. The caller limits the rate.
 */
bool dronecan_node_log(struct dronecan_node *self, int64_t now_us, uint8_t level,
                       const char *source, const char *text);

/* Answers a request with a payload; false: no room. Counted. */
bool dronecan_node_respond(struct dronecan_node *self, int64_t now_us,
                           const struct dronecan_transfer *request, const uint8_t *data,
                           size_t size);

/* param_service.c: GetSet and ExecuteOpcode. */
void dronecan_node_get_set(struct dronecan_node *self, int64_t now_us,
                           const struct dronecan_transfer *request);
void dronecan_node_execute_opcode(struct dronecan_node *self, int64_t now_us,
                                  const struct dronecan_transfer *request,
                                  struct dronecan_node_outbox *out);

#endif
