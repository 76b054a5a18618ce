/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gimbal as a MAVLink component: a gimbal device of protocol v2 (messages 283 to 286), which
 * also takes the mount commands before it (204, 205).
 *
 * 284 has an angle (its quaternion) or rates (quaternion NaN); of both, the angle counts. Retract
 * goes before neutral, and both before the rest. An axis without either holds. The pitch lock bit
 * makes pitch count from the horizon, the yaw lock bit holds yaw against north; YAW_IN_…_FRAME say
 * what the yaw given counts from, and without them the lock bit does. What is beyond the limits is
 * approached to the limit and told in failure_flags. Refused and counted: numbers that are no
 * quaternion, infinite or absurd rates, both frames at once, a heading that is needed and not
 * known.
 *
 * 205 has degrees, in mode 2, with the signs that GMB_MNT_SIGN says; 204 before it may make them
 * rates, or count from horizon and north. In mode 4 it has a place, at which the beam stays pointed
 * as the vehicle moves, until it is pointed otherwise. There is no roll axis: roll is taken and is
 * 0.
 *
 * A gimbal device acts upon its manager's messages alone: the autopilot of its own system, or a
 * component of that system that names it in GIMBAL_MANAGER_INFORMATION or _STATUS. So 284 from
 * anyone else is counted and left. Mount commands are older than managers: anyone's are carried out
 * while no manager is heard, by the autopilot's heartbeats or what else the manager sends, for
 * MAVLINK_GIMBAL_VEHICLE_LOST_US; meanwhile others' are rejected for the time being.
 *
 * The vehicle's attitude comes with 286 or ATTITUDE, its position with GLOBAL_POSITION_INT. While
 * the vehicle is there and one of them does not come, it is asked for it every second, and after
 * MAVLINK_GIMBAL_ASKS times in vain every MAVLINK_GIMBAL_ASK_AGAIN_US.
 *
 * Context: the endpoint's. Spec: mavlink.io services gimbal_v2, gimbal_v1; common.xml.
 */
#ifndef PHAROS_PROTO_MAVLINK_GIMBAL_SERVICE_H
#define PHAROS_PROTO_MAVLINK_GIMBAL_SERVICE_H

#include "core/device.h"
#include "proto/mavlink/endpoint.h"
#include "proto/mavlink/identity.h"
#include "proto/mavlink/param_service.h"

/* What the vehicle is asked for. */
enum mavlink_gimbal_datum {
	MAVLINK_GIMBAL_ATTITUDE,
	MAVLINK_GIMBAL_POSITION,
	MAVLINK_GIMBAL_DATA
};

/* WGS84, and the height over the sea. */
struct mavlink_place {
	int32_t lat_e7;
	int32_t lon_e7;
	int32_t alt_mm;
};

struct mavlink_gimbal_stats {
	uint32_t set;      /* 284 that were carried out */
	uint32_t bad;      /* messages with numbers of no meaning */
	uint32_t refused;  /* 284 that the arbiter refused */
	uint32_t foreign;  /* 284, 204 and 205 of others than the manager */
	uint32_t requests; /* for data */
};

/* What 204 said about an axis. */
struct mavlink_mount_input {
	bool is_rate;
	bool is_locked;
};

struct mavlink_gimbal {
	struct pharos_device *device;
	const struct mavlink_identity *identity;
	struct mavlink_params params; /* the gimbal's */
	struct mavlink_mount_input mount[GIMBAL_AXES];
	struct mavlink_place vehicle; /* of its last GLOBAL_POSITION_INT */
	struct mavlink_place target;
	bool is_tracking; /* the target */
	struct mavlink_gimbal_stats stats;
	int64_t heard_us[MAVLINK_GIMBAL_DATA];  /* -1: never */
	int64_t vehicle_us;                     /* of its last heartbeat; -1: never */
	int64_t ask_us;                         /* when to look for what is missing */
	int64_t wanted_us[MAVLINK_GIMBAL_DATA]; /* and not to ask for it before */
	uint8_t asked[MAVLINK_GIMBAL_DATA];     /* in vain, up to MAVLINK_GIMBAL_ASKS */
	uint8_t vehicle_link;
	uint8_t vehicle_system;
	uint8_t manager;    /* beside the vehicle, a component of the same system; 0: none */
	int64_t manager_us; /* when it was heard last */
};

extern const struct mavlink_profile mavlink_gimbal_profile;

/* Both outlive the service. The device has a gimbal. */
void mavlink_gimbal_init(struct mavlink_gimbal *self, struct pharos_device *device,
                         const struct mavlink_identity *identity);

#endif
