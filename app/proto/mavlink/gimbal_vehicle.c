/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/gimbal_vehicle.h"

#include "proto/mavlink/dialect.h"
#include "proto/mavlink/gimbal_service.h"
#include "proto/mavlink/internal.h"
#include "proto/mavlink/quaternion.h"

#include <string.h>

#define MDEG_PER_RAD  57295.78f
/* No vehicle counts its angles beyond two turns. */
#define ANGLE_MAX_RAD 12.6f

/* Degrees times 10^7: half a turn, a thousandth of a degree, and what one is on the ground. */
#define HALF_TURN_E7 INT64_C(1800000000)
#define E7_PER_MDEG  10000
#define UM_PER_E7    11132 /* 40 075 km / 360 / 10^7 */
/* No beam reaches farther: 1000 km. */
#define FAR_MM       INT64_C(1000000000)

_Static_assert(MAVLINK_OUTBOX_FRAMES >= 2 * MAVLINK_GIMBAL_DATA, "all requests fit at once");

static bool is_from_vehicle(const struct mavlink_context *context)
{
	return context->source_system == context->endpoint->config.system_id &&
	       context->source_component == MAV_COMP_ID_AUTOPILOT1;
}

/* --- who manages it --------------------------------------------------------------------------- */

bool mavlink_gimbal_is_manager(const struct mavlink_context *context)
{
	struct mavlink_gimbal *const self = context->component->service;

	if (context->source_system != context->endpoint->config.system_id) {
		return false;
	}
	if (self->manager != 0 && context->source_component == self->manager) {
		self->manager_us = context->now_us;
		return true;
	}
	return context->source_component == MAV_COMP_ID_AUTOPILOT1;
}

static bool is_recent(int64_t now_us, int64_t heard_us)
{
	return heard_us >= 0 && now_us - heard_us < MAVLINK_GIMBAL_VEHICLE_LOST_US;
}

bool mavlink_gimbal_is_managed(const struct mavlink_context *context)
{
	const struct mavlink_gimbal *const self = context->component->service;

	return (self->vehicle_system == context->endpoint->config.system_id &&
	        is_recent(context->now_us, self->vehicle_us)) ||
	       (self->manager != 0 && is_recent(context->now_us, self->manager_us));
}

/* Of our own system, and no station's claim: a station is no component of the vehicle. */
static void take_manager(const struct mavlink_context *context, uint8_t gimbal_device_id)
{
	struct mavlink_gimbal *const self = context->component->service;

	if (gimbal_device_id == context->component->id &&
	    context->source_system == context->endpoint->config.system_id &&
	    context->source_component != MAV_COMP_ID_AUTOPILOT1) {
		self->manager = context->source_component;
		self->manager_us = context->now_us;
	}
}

void mavlink_gimbal_manager_information(const struct mavlink_context *context,
                                        const struct mavlink_frame *frame)
{
	mavlink_gimbal_manager_information_t wire;

	mavlink_frame_payload(frame, &wire, sizeof(wire));
	take_manager(context, wire.gimbal_device_id);
}

void mavlink_gimbal_manager_status(const struct mavlink_context *context,
                                   const struct mavlink_frame *frame)
{
	mavlink_gimbal_manager_status_t wire;

	mavlink_frame_payload(frame, &wire, sizeof(wire));
	take_manager(context, wire.gimbal_device_id);
}

/* --- attitude and position -------------------------------------------------------------------- */

/* It comes: if it stops, it is asked for at once. */
static void datum_heard(struct mavlink_gimbal *self, int64_t now_us,
                        enum mavlink_gimbal_datum datum)
{
	self->heard_us[datum] = now_us;
	self->wanted_us[datum] = now_us;
	self->asked[datum] = 0;
}

static void take_attitude(const struct mavlink_context *context, const struct attitude *attitude)
{
	struct mavlink_gimbal *const self = context->component->service;
	const struct device_who who = mavlink_who(context);

	datum_heard(self, context->now_us, MAVLINK_GIMBAL_ATTITUDE);
	pharos_device_report_attitude(self->device, context->now_us, &who, attitude);
}

void mavlink_gimbal_autopilot_state(const struct mavlink_context *context,
                                    const struct mavlink_frame *frame)
{
	struct mavlink_gimbal *const self = context->component->service;
	mavlink_autopilot_state_for_gimbal_device_t wire;
	float q[4];

	if (!is_from_vehicle(context)) {
		return;
	}
	mavlink_frame_payload(frame, &wire, sizeof(wire));
	memcpy(q, wire.q, sizeof(q));
	if (!quaternion_is_unit(q)) {
		self->stats.bad++;
		return;
	}

	const struct attitude attitude = quaternion_attitude(q);

	take_attitude(context, &attitude);
}

void mavlink_gimbal_vehicle_attitude(const struct mavlink_context *context,
                                     const struct mavlink_frame *frame)
{
	struct mavlink_gimbal *const self = context->component->service;
	mavlink_attitude_t wire;

	if (!is_from_vehicle(context)) {
		return;
	}
	mavlink_frame_payload(frame, &wire, sizeof(wire));
	if (!mavlink_is_within(wire.roll, ANGLE_MAX_RAD) ||
	    !mavlink_is_within(wire.pitch, ANGLE_MAX_RAD) ||
	    !mavlink_is_within(wire.yaw, ANGLE_MAX_RAD)) {
		self->stats.bad++;
		return;
	}

	const struct attitude attitude = {
		.roll_mdeg = mavlink_rounded(wire.roll * MDEG_PER_RAD),
		.pitch_mdeg = mavlink_rounded(wire.pitch * MDEG_PER_RAD),
		.yaw_mdeg = mavlink_rounded(wire.yaw * MDEG_PER_RAD),
	};

	take_attitude(context, &attitude);
}

/* Nearer to ANGLE_ONE, so that no precision is lost, or no bits. */
static int32_t scaled(int64_t value, int64_t largest)
{
	return (int32_t)(value * ANGLE_ONE / largest);
}

static int64_t larger(int64_t largest, int64_t value)
{
	const int64_t size = value < 0 ? -value : value;

	return size > largest ? size : largest;
}

bool mavlink_gimbal_aim_at(const struct mavlink_place *from, const struct mavlink_place *to,
                           struct gimbal_event *event)
{
	int64_t east_e7 = (int64_t)to->lon_e7 - from->lon_e7;
	int32_t narrower = ANGLE_ONE; /* how much a degree of longitude is, by the cosine */
	int32_t unused = 0;
	int32_t level;
	int32_t whole;

	if (east_e7 > HALF_TURN_E7 || east_e7 < -HALF_TURN_E7) {
		east_e7 += east_e7 > 0 ? -2 * HALF_TURN_E7 : 2 * HALF_TURN_E7;
	}
	angle_rotate(&narrower, &unused, from->lat_e7 / E7_PER_MDEG);

	const int64_t north_mm = ((int64_t)to->lat_e7 - from->lat_e7) * UM_PER_E7 / 1000;
	const int64_t east_mm = east_e7 * UM_PER_E7 / 1000 * narrower / ANGLE_ONE;
	const int64_t up_mm = (int64_t)to->alt_mm - from->alt_mm;
	const int64_t largest = larger(larger(larger(0, north_mm), east_mm), up_mm);

	if (largest == 0 || largest > FAR_MM) {
		return false;
	}

	const int32_t yaw_mdeg =
		angle_of_mdeg(scaled(north_mm, largest), scaled(east_mm, largest), &level);
	const int32_t pitch_mdeg = angle_of_mdeg(level, scaled(up_mm, largest), &whole);

	*event = (struct gimbal_event){
		.kind = GIMBAL_EVENT_AIM,
		.aim =
			{
				[GIMBAL_PAN] = {GIMBAL_ANGLE, true, yaw_mdeg},
				[GIMBAL_TILT] = {GIMBAL_ANGLE, true, pitch_mdeg},
			},
	};
	return true;
}

void mavlink_gimbal_vehicle_position(const struct mavlink_context *context,
                                     const struct mavlink_frame *frame)
{
	struct mavlink_gimbal *const self = context->component->service;
	mavlink_global_position_int_t wire;
	struct gimbal_event event;

	if (!is_from_vehicle(context)) {
		return;
	}
	mavlink_frame_payload(frame, &wire, sizeof(wire));
	datum_heard(self, context->now_us, MAVLINK_GIMBAL_POSITION);
	self->vehicle = (struct mavlink_place){wire.lat, wire.lon, wire.alt};
	if (self->is_tracking && mavlink_gimbal_aim_at(&self->vehicle, &self->target, &event)) {
		const struct device_who who = mavlink_who(context);

		self->is_tracking = pharos_device_follow(self->device, context->now_us, &who,
		                                         &event) == DEVICE_ACCEPTED;
	}
}

void mavlink_gimbal_heartbeat(const struct mavlink_context *context,
                              const struct mavlink_frame *frame)
{
	struct mavlink_gimbal *const self = context->component->service;
	mavlink_heartbeat_t wire;

	mavlink_frame_payload(frame, &wire, sizeof(wire));

	const struct mavlink_vehicle_heartbeat said = {
		.system = frame->system_id,
		.component = frame->component_id,
		.type = wire.type,
		.autopilot = wire.autopilot,
	};

	if (!is_from_vehicle(context) || !mavlink_vehicle_is_autopilot(&said)) {
		return;
	}
	self->vehicle_us = context->now_us;
	self->vehicle_link = context->link;
	self->vehicle_system = frame->system_id;
	if (self->ask_us == TIME_NEVER_US) {
		self->ask_us = context->now_us;
		for (size_t i = 0; i < MAVLINK_GIMBAL_DATA; i++) {
			self->wanted_us[i] = context->now_us;
			self->asked[i] = 0;
		}
	}
}

static const struct {
	uint8_t stream;
	uint16_t message_id;
	uint16_t rate_hz;
} data[MAVLINK_GIMBAL_DATA] = {
	[MAVLINK_GIMBAL_ATTITUDE] = {MAV_DATA_STREAM_EXTRA1, MAVLINK_MSG_ID_ATTITUDE,
                                     MAVLINK_GIMBAL_ATTITUDE_HZ},
	[MAVLINK_GIMBAL_POSITION] = {MAV_DATA_STREAM_POSITION, MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
                                     MAVLINK_GIMBAL_POSITION_HZ},
};

/* In both ways: ArduPilot has long known the first, PX4 knows the second. */
static void ask_for(const struct mavlink_context *context, enum mavlink_gimbal_datum datum)
{
	static const struct mavlink_kind stream_kind = MAVLINK_KIND(REQUEST_DATA_STREAM);
	static const struct mavlink_kind command_kind = MAVLINK_KIND(COMMAND_LONG);
	struct mavlink_gimbal *const self = context->component->service;
	const mavlink_request_data_stream_t request = {
		.req_message_rate = data[datum].rate_hz,
		.target_system = self->vehicle_system,
		.target_component = MAV_COMP_ID_AUTOPILOT1,
		.req_stream_id = data[datum].stream,
		.start_stop = 1,
	};
	const mavlink_command_long_t command = {
		.param1 = (float)data[datum].message_id,
		.param2 = (float)US_PER_S / (float)data[datum].rate_hz,
		.command = MAV_CMD_SET_MESSAGE_INTERVAL,
		.target_system = self->vehicle_system,
		.target_component = MAV_COMP_ID_AUTOPILOT1,
	};

	self->stats.requests++;
	(void)mavlink_send(context, self->vehicle_link, &stream_kind, &request);
	(void)mavlink_send(context, self->vehicle_link, &command_kind, &command);
}

bool mavlink_gimbal_is_missing(const struct mavlink_gimbal *self, int64_t now_us,
                               enum mavlink_gimbal_datum datum)
{
	const int64_t heard_us = self->heard_us[datum];

	return heard_us < 0 || now_us - heard_us >= MAVLINK_GIMBAL_DATA_LOST_US;
}

bool mavlink_gimbal_ask(const struct mavlink_context *context)
{
	struct mavlink_gimbal *const self = context->component->service;
	const int64_t now_us = context->now_us;

	if (now_us < self->ask_us) {
		return true;
	}
	if (self->device->params.values[PARAM_GMB_ASK_DATA] == 0 ||
	    self->vehicle_system != context->endpoint->config.system_id ||
	    now_us - self->vehicle_us >= MAVLINK_GIMBAL_VEHICLE_LOST_US) {
		self->ask_us = TIME_NEVER_US; /* until its next heartbeat */
		return true;
	}
	if (!mavlink_outbox_has_frames(context->out, 2 * MAVLINK_GIMBAL_DATA)) {
		return false;
	}
	for (size_t i = 0; i < MAVLINK_GIMBAL_DATA; i++) {
		if (!mavlink_gimbal_is_missing(self, now_us, (enum mavlink_gimbal_datum)i) ||
		    now_us < self->wanted_us[i]) {
			continue;
		}
		ask_for(context, (enum mavlink_gimbal_datum)i);
		if (self->asked[i] < MAVLINK_GIMBAL_ASKS) {
			self->asked[i]++;
		}
		self->wanted_us[i] = now_us + (self->asked[i] < MAVLINK_GIMBAL_ASKS
		                                       ? MAVLINK_GIMBAL_ASK_US
		                                       : MAVLINK_GIMBAL_ASK_AGAIN_US);
	}
	self->ask_us = now_us + MAVLINK_GIMBAL_ASK_US;
	return true;
}

int64_t mavlink_gimbal_ask_us(const void *service)
{
	return ((const struct mavlink_gimbal *)service)->ask_us;
}
