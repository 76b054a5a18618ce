/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which vehicle the device belongs to: its system id is the vehicle's.
 *
 * Listens for heartbeats of autopilots: component 1, an autopilot that is not INVALID, of a type
 * that is a vehicle (ground stations, antenna trackers and onboard controllers are none). When
 * MAVLINK_VEHICLE_WAIT_US after the first of them only one system has been heard, its id is
 * adopted; when several, the configured one stays. Either holds until the next reset: another
 * vehicle that comes within earshot later must not get the light.
 *
 * Sans-IO. Context: the endpoint's. Spec: common.xml HEARTBEAT, MAV_TYPE.
 */
#ifndef PHAROS_PROTO_MAVLINK_VEHICLE_H
#define PHAROS_PROTO_MAVLINK_VEHICLE_H

#include <stdbool.h>
#include <stdint.h>

#define MAVLINK_VEHICLE_WAIT_US 3000000

enum mavlink_vehicle_state {
	MAVLINK_VEHICLE_FIXED,     /* the id is configured */
	MAVLINK_VEHICLE_LISTENING, /* no autopilot yet */
	MAVLINK_VEHICLE_DECIDING,  /* within the time after the first */
	MAVLINK_VEHICLE_ADOPTED,
	MAVLINK_VEHICLE_SEVERAL,
};

/* What a heartbeat says. */
struct mavlink_vehicle_heartbeat {
	uint8_t system;
	uint8_t component;
	uint8_t type;      /* MAV_TYPE */
	uint8_t autopilot; /* MAV_AUTOPILOT */
};

struct mavlink_vehicle {
	enum mavlink_vehicle_state state;
	int64_t decide_us;
	uint8_t system; /* heard first, or adopted; 0: none */
	uint8_t other;  /* another one, heard later; 0: none */
};

/* adopt: false: FIXED for good. */
void mavlink_vehicle_init(struct mavlink_vehicle *self, bool adopt);

/* A heartbeat has come, on any link. */
void mavlink_vehicle_heard(struct mavlink_vehicle *self, int64_t now_us,
                           const struct mavlink_vehicle_heartbeat *heartbeat);

/* True once, when it is decided: state is then ADOPTED (system) or SEVERAL (system, other). */
bool mavlink_vehicle_decide(struct mavlink_vehicle *self, int64_t now_us);

/* When mavlink_vehicle_decide may return true; TIME_NEVER_US: not without another heartbeat. */
int64_t mavlink_vehicle_deadline_us(const struct mavlink_vehicle *self);

/* Is this the heartbeat of a vehicle's autopilot? */
bool mavlink_vehicle_is_autopilot(const struct mavlink_vehicle_heartbeat *heartbeat);

/* For people, constant and never NULL: "configured", … */
const char *mavlink_vehicle_state_name(enum mavlink_vehicle_state state);

#endif
