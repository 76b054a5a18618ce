/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/vehicle.h"

#include "core/assert.h"
#include "core/limits.h"
#include "proto/mavlink/dialect.h"

void mavlink_vehicle_init(struct mavlink_vehicle *self, bool adopt)
{
	*self = (struct mavlink_vehicle){
		.state = adopt ? MAVLINK_VEHICLE_LISTENING : MAVLINK_VEHICLE_FIXED,
		.decide_us = TIME_NEVER_US,
	};
}

bool mavlink_vehicle_is_autopilot(const struct mavlink_vehicle_heartbeat *heartbeat)
{
	const uint8_t type = heartbeat->type;

	return heartbeat->system != 0 && heartbeat->component == MAV_COMP_ID_AUTOPILOT1 &&
	       heartbeat->autopilot != MAV_AUTOPILOT_INVALID && type != MAV_TYPE_GCS &&
	       type != MAV_TYPE_ANTENNA_TRACKER && type != MAV_TYPE_ONBOARD_CONTROLLER;
}

void mavlink_vehicle_heard(struct mavlink_vehicle *self, int64_t now_us,
                           const struct mavlink_vehicle_heartbeat *heartbeat)
{
	if (!mavlink_vehicle_is_autopilot(heartbeat)) {
		return;
	}
	switch (self->state) {
	case MAVLINK_VEHICLE_LISTENING:
		self->state = MAVLINK_VEHICLE_DECIDING;
		self->system = heartbeat->system;
		self->decide_us = now_us + MAVLINK_VEHICLE_WAIT_US;
		break;
	case MAVLINK_VEHICLE_DECIDING:
		if (heartbeat->system != self->system && now_us <= self->decide_us) {
			self->other = heartbeat->system;
		}
		break;
	case MAVLINK_VEHICLE_FIXED:
	case MAVLINK_VEHICLE_ADOPTED:
	case MAVLINK_VEHICLE_SEVERAL:
		break;
	}
}

bool mavlink_vehicle_decide(struct mavlink_vehicle *self, int64_t now_us)
{
	if (now_us < self->decide_us) {
		return false;
	}
	self->state = self->other == 0 ? MAVLINK_VEHICLE_ADOPTED : MAVLINK_VEHICLE_SEVERAL;
	self->decide_us = TIME_NEVER_US;
	return true;
}

int64_t mavlink_vehicle_deadline_us(const struct mavlink_vehicle *self)
{
	return self->decide_us;
}

const char *mavlink_vehicle_state_name(enum mavlink_vehicle_state state)
{
	switch (state) {
	case MAVLINK_VEHICLE_FIXED:
		return "configured";
	case MAVLINK_VEHICLE_LISTENING:
		return "until a vehicle is heard";
	case MAVLINK_VEHICLE_DECIDING:
		return "a vehicle is heard, waiting for others";
	case MAVLINK_VEHICLE_ADOPTED:
		return "the vehicle's";
	case MAVLINK_VEHICLE_SEVERAL:
		return "several vehicles are heard";
	}
	PHAROS_ASSERT(false);
	return "";
}
