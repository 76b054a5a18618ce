/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/gimbal_service.h"

#include "proto/mavlink/dialect.h"
#include "proto/mavlink/ftp.h"
#include "proto/mavlink/gimbal_vehicle.h"
#include "proto/mavlink/internal.h"
#include "proto/mavlink/quaternion.h"
#include "proto/mavlink/real.h"

#include <stddef.h>
#include <string.h>

#define HEARTBEAT_INTERVAL_US 1000000
#define ATTITUDE_INTERVAL_US  200000

#define MDEG_PER_DEG  1000.0f
#define MDEG_PER_RAD  57295.78f
/* What the core takes. */
#define ANGLE_MAX_DEG 360.0f
#define RATE_MAX_RAD  34.9f
#define RATE_MAX_DEG  2000.0f

/* Places on the earth. */
#define LAT_MAX_E7 900000000.0f
#define LON_MAX_E7 1800000000.0f
#define ALT_MAX_M  100000.0f
#define MM_PER_M   1000.0f

/* GMB_MNT_SIGN */
#define SIGN_PITCH 1
#define SIGN_YAW   2

/* What 204 says that an input of 205 is. */
#define INPUT_BODY_ANGLE  0u
#define INPUT_RATE        1u
#define INPUT_EARTH_ANGLE 2u

#define CAP_FLAGS                                                                                  \
	(GIMBAL_DEVICE_CAP_FLAGS_HAS_RETRACT | GIMBAL_DEVICE_CAP_FLAGS_HAS_NEUTRAL |               \
	 GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_AXIS | GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_FOLLOW |       \
	 GIMBAL_DEVICE_CAP_FLAGS_HAS_PITCH_LOCK | GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_AXIS |           \
	 GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_FOLLOW | GIMBAL_DEVICE_CAP_FLAGS_HAS_YAW_LOCK |           \
	 GIMBAL_DEVICE_CAP_FLAGS_SUPPORTS_YAW_IN_EARTH_FRAME)

#define FRAME_FLAGS                                                                                \
	(GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME | GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME)

static const struct gimbal_event retract = {.kind = GIMBAL_EVENT_RETRACT};
static const struct gimbal_event neutral = {.kind = GIMBAL_EVENT_NEUTRAL};

void mavlink_gimbal_init(struct mavlink_gimbal *self, struct pharos_device *device,
                         const struct mavlink_identity *identity)
{
	memset(self, 0, sizeof(*self));
	self->device = device;
	self->identity = identity;
	mavlink_params_init(&self->params, device, MAVLINK_PARAMS_GIMBAL);
	self->vehicle_us = -1;
	self->ask_us = TIME_NEVER_US;
	for (size_t i = 0; i < MAVLINK_GIMBAL_DATA; i++) {
		self->heard_us[i] = -1;
	}
}

static uint8_t apply(const struct mavlink_context *context, const struct gimbal_event *event)
{
	struct mavlink_gimbal *const self = context->component->service;

	const struct device_who who = mavlink_who(context);
	const enum device_result result =
		pharos_device_point(self->device, context->now_us, &who, event);

	self->is_tracking = self->is_tracking && result != DEVICE_ACCEPTED;
	return mavlink_result(result);
}

/* --- mount commands --------------------------------------------------------------------------- */

/* NaN is how some clients leave a parameter out. */
static bool choice(float wire, uint32_t max, uint32_t *value)
{
	*value = 0;
	return isnan(wire) || mavlink_whole(wire, max, value);
}

static bool mount_input(float input, float stabilize, struct mavlink_mount_input *mount)
{
	uint32_t kind;
	uint32_t stabilized;

	if (!choice(input, INPUT_EARTH_ANGLE, &kind) || !choice(stabilize, 1, &stabilized)) {
		return false;
	}
	mount->is_rate = kind == INPUT_RATE;
	mount->is_locked = kind == INPUT_EARTH_ANGLE || stabilized != 0;
	return true;
}

static bool mount_mode(float wire, uint32_t *mode)
{
	return mavlink_whole(wire, MAV_MOUNT_MODE_GPS_POINT, mode) &&
	       *mode != MAV_MOUNT_MODE_RC_TARGETING;
}

/* Whose mount commands are not heard now, since the manager points the gimbal. */
static bool is_foreign_mount(const struct mavlink_context *context)
{
	struct mavlink_gimbal *const self = context->component->service;
	const bool foreign =
		!mavlink_gimbal_is_manager(context) && mavlink_gimbal_is_managed(context);

	self->stats.foreign += foreign;
	return foreign;
}

/* To all, it is for the manager to answer. */
static uint8_t foreign_result(const struct mavlink_command *command)
{
	return command->to_all ? MAVLINK_NO_ANSWER : MAV_RESULT_TEMPORARILY_REJECTED;
}

/*
 * 204: mode, stabilize roll, pitch, yaw, then what 205's roll, pitch and yaw are; these three have
 * since left the definition. A mode of angles moves nothing yet.
 */
static uint8_t mount_configure(const struct mavlink_context *context,
                               const struct mavlink_command *command, struct mavlink_reply *reply)
{
	struct mavlink_gimbal *const self = context->component->service;
	const float *const param = command->param;
	struct mavlink_mount_input mount[GIMBAL_AXES];
	struct mavlink_mount_input roll;
	uint8_t result = MAV_RESULT_ACCEPTED;
	uint32_t mode;

	(void)reply;
	if (is_foreign_mount(context)) {
		return foreign_result(command);
	}
	if (!mount_mode(param[0], &mode) || !mount_input(param[4], param[1], &roll) ||
	    !mount_input(param[5], param[2], &mount[GIMBAL_TILT]) ||
	    !mount_input(param[6], param[3], &mount[GIMBAL_PAN])) {
		return MAV_RESULT_DENIED;
	}
	if (mode == MAV_MOUNT_MODE_RETRACT || mode == MAV_MOUNT_MODE_NEUTRAL) {
		result = apply(context, mode == MAV_MOUNT_MODE_RETRACT ? &retract : &neutral);
	}
	if (result == MAV_RESULT_ACCEPTED) {
		memcpy(self->mount, mount, sizeof(mount));
	}
	return result;
}

static bool mount_aim(const struct mavlink_mount_input *mount, float wire, bool reversed,
                      struct gimbal_aim *aim)
{
	const float most = mount->is_rate ? RATE_MAX_DEG : ANGLE_MAX_DEG;

	if (!mavlink_is_within(wire, most)) {
		return false;
	}
	aim->kind = mount->is_rate ? GIMBAL_RATE : GIMBAL_ANGLE;
	aim->lock = mount->is_locked;
	aim->value = mavlink_rounded((reversed ? -wire : wire) * MDEG_PER_DEG);
	return true;
}

/* Latitude and longitude [deg * 10^7], altitude [m]; the vehicle's own place must be known. */
static uint8_t track(const struct mavlink_context *context, const struct mavlink_command *command)
{
	struct mavlink_gimbal *const self = context->component->service;
	const float *const param = command->param;
	struct gimbal_event event;

	if (!mavlink_is_within(param[4], LAT_MAX_E7) || !mavlink_is_within(param[5], LON_MAX_E7) ||
	    !mavlink_is_within(param[3], ALT_MAX_M)) {
		return MAV_RESULT_DENIED;
	}

	const struct mavlink_place target = {
		.lat_e7 = mavlink_rounded(param[4]),
		.lon_e7 = mavlink_rounded(param[5]),
		.alt_mm = mavlink_rounded(param[3] * MM_PER_M),
	};
	if (mavlink_gimbal_is_missing(self, context->now_us, MAVLINK_GIMBAL_POSITION) ||
	    !mavlink_gimbal_aim_at(&self->vehicle, &target, &event)) {
		return MAV_RESULT_FAILED;
	}

	const uint8_t result = apply(context, &event);

	if (result == MAV_RESULT_ACCEPTED) {
		self->target = target;
		self->is_tracking = true;
	}
	return result;
}

/* 205: pitch, roll, yaw [deg]; param7 is the mode. Roll is taken, and there is no axis for it. */
static uint8_t mount_control(const struct mavlink_context *context,
                             const struct mavlink_command *command, struct mavlink_reply *reply)
{
	const struct mavlink_gimbal *const self = context->component->service;
	const int32_t sign = self->device->params.values[PARAM_GMB_MNT_SIGN];
	struct gimbal_event event = {.kind = GIMBAL_EVENT_AIM};
	uint32_t mode;

	(void)reply;
	if (is_foreign_mount(context)) {
		return foreign_result(command);
	}
	if (!mount_mode(command->param[6], &mode)) {
		return MAV_RESULT_DENIED;
	}
	if (mode == MAV_MOUNT_MODE_GPS_POINT) {
		return track(context, command);
	}
	if (mode == MAV_MOUNT_MODE_RETRACT) {
		return apply(context, &retract);
	}
	if (mode == MAV_MOUNT_MODE_NEUTRAL) {
		return apply(context, &neutral);
	}
	if (!mount_aim(&self->mount[GIMBAL_TILT], command->param[0], (sign & SIGN_PITCH) != 0,
	               &event.aim[GIMBAL_TILT]) ||
	    !mavlink_is_within(command->param[1], ANGLE_MAX_DEG) ||
	    !mount_aim(&self->mount[GIMBAL_PAN], command->param[2], (sign & SIGN_YAW) != 0,
	               &event.aim[GIMBAL_PAN])) {
		return MAV_RESULT_DENIED;
	}
	return apply(context, &event);
}

static const struct mavlink_command_row commands[] = {
	MAVLINK_COMMON_COMMANDS,
	{.id = MAV_CMD_DO_MOUNT_CONFIGURE, .run = mount_configure},
	{.id = MAV_CMD_DO_MOUNT_CONTROL, .run = mount_control},
};

/* --- GIMBAL_DEVICE_SET_ATTITUDE --------------------------------------------------------------- */

/* A yaw counts from north or from the heading, whatever it is then held against. */
static bool set_yaw(const struct gimbal_report *now, uint16_t flags, int32_t yaw_mdeg,
                    struct gimbal_aim *pan)
{
	const bool locked = (flags & GIMBAL_DEVICE_FLAGS_YAW_LOCK) != 0;
	const bool from_north = (flags & FRAME_FLAGS) == 0
	                                ? locked
	                                : (flags & GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME) != 0;
	const int32_t heading_mdeg = now->heading_mdeg;

	*pan = (struct gimbal_aim){.kind = GIMBAL_ANGLE, .lock = locked, .value = yaw_mdeg};
	if (locked != from_north) {
		pan->value = angle_wrap_mdeg((int64_t)yaw_mdeg +
		                             (locked ? heading_mdeg : -heading_mdeg));
	}
	return locked == from_north || now->heading_known;
}

/* No rate: the axis holds. */
static bool set_rate(float wire, bool locked, struct gimbal_aim *aim)
{
	*aim = (struct gimbal_aim){.kind = GIMBAL_RATE, .lock = locked};
	if (isnan(wire)) {
		return true;
	}
	if (!mavlink_is_within(wire, RATE_MAX_RAD)) {
		return false;
	}
	aim->value = mavlink_rounded(wire * MDEG_PER_RAD);
	return true;
}

/* false: the numbers mean nothing. */
static bool event_of(const struct mavlink_context *context,
                     const mavlink_gimbal_device_set_attitude_t *wire, struct gimbal_event *event)
{
	const struct mavlink_gimbal *const self = context->component->service;
	const bool pitch_locked = (wire->flags & GIMBAL_DEVICE_FLAGS_PITCH_LOCK) != 0;
	struct gimbal_aim *const pan = &event->aim[GIMBAL_PAN];
	struct gimbal_aim *const tilt = &event->aim[GIMBAL_TILT];
	float q[4];

	event->kind = GIMBAL_EVENT_AIM;
	if ((wire->flags & FRAME_FLAGS) == FRAME_FLAGS ||
	    !(isnan(wire->angular_velocity_x) ||
	      mavlink_is_within(wire->angular_velocity_x, RATE_MAX_RAD))) {
		return false;
	}
	if (!set_rate(wire->angular_velocity_y, pitch_locked, tilt) ||
	    !set_rate(wire->angular_velocity_z, (wire->flags & GIMBAL_DEVICE_FLAGS_YAW_LOCK) != 0,
	              pan)) {
		return false;
	}
	memcpy(q, wire->q, sizeof(q));
	if (quaternion_is_absent(q)) {
		return true;
	}
	if (!quaternion_is_unit(q)) {
		return false;
	}

	const struct gimbal_report now = gimbal_report(&self->device->gimbal, context->now_us);
	const struct direction direction = quaternion_direction(q);

	*tilt = (struct gimbal_aim){
		.kind = GIMBAL_ANGLE, .lock = pitch_locked, .value = direction.pitch_mdeg};
	return set_yaw(&now, wire->flags, direction.yaw_mdeg, pan);
}

static void set_attitude(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	struct mavlink_gimbal *const self = context->component->service;
	mavlink_gimbal_device_set_attitude_t wire;
	struct gimbal_event event;

	if (!mavlink_gimbal_is_manager(context)) {
		self->stats.foreign++;
		return;
	}
	mavlink_frame_payload(frame, &wire, sizeof(wire));
	if ((wire.flags & GIMBAL_DEVICE_FLAGS_RETRACT) != 0) {
		event = retract;
	} else if ((wire.flags & GIMBAL_DEVICE_FLAGS_NEUTRAL) != 0) {
		event = neutral;
	} else if (!event_of(context, &wire, &event)) {
		self->stats.bad++;
		return;
	}
	if (apply(context, &event) == MAV_RESULT_ACCEPTED) {
		self->stats.set++;
	} else {
		self->stats.refused++;
	}
}

/* --- what it tells ---------------------------------------------------------------------------- */

static uint16_t flags_of(const struct gimbal_report *now)
{
	uint32_t flags = GIMBAL_DEVICE_FLAGS_ACCEPTS_YAW_IN_EARTH_FRAME;

	switch (now->mode) {
	case GIMBAL_MODE_RETRACTED:
		flags |= GIMBAL_DEVICE_FLAGS_RETRACT;
		break;
	case GIMBAL_MODE_NEUTRAL:
		flags |= GIMBAL_DEVICE_FLAGS_NEUTRAL;
		break;
	case GIMBAL_MODE_AIMED:
		break;
	}
	if (now->tilt_locked) {
		flags |= GIMBAL_DEVICE_FLAGS_ROLL_LOCK | GIMBAL_DEVICE_FLAGS_PITCH_LOCK;
	}
	flags |= now->pan_locked
	                 ? GIMBAL_DEVICE_FLAGS_YAW_LOCK | GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME
	                 : GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME;
	return (uint16_t)flags;
}

static uint32_t failures_of(const struct gimbal_report *now)
{
	uint32_t flags = 0;

	flags |= now->at_limit[GIMBAL_TILT] ? GIMBAL_DEVICE_ERROR_FLAGS_AT_PITCH_LIMIT : 0;
	flags |= now->at_limit[GIMBAL_PAN] ? GIMBAL_DEVICE_ERROR_FLAGS_AT_YAW_LIMIT : 0;
	flags |= now->fault ? GIMBAL_DEVICE_ERROR_FLAGS_MOTOR_ERROR : 0;
	flags |= now->attitude_lost ? GIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR : 0;
	return flags;
}

static float radians(int32_t mdeg)
{
	return (float)mdeg / MDEG_PER_RAD;
}

/* Where the beam points, as the locks in force make it count. */
static struct direction told_direction(const struct gimbal_report *now)
{
	struct direction direction = now->tilt_locked ? now->level : now->own;

	if (now->pan_locked) {
		direction.yaw_mdeg =
			angle_wrap_mdeg((int64_t)direction.yaw_mdeg + now->heading_mdeg);
	}
	return direction;
}

static uint8_t fill_attitude(const struct mavlink_context *context, float argument, void *payload)
{
	const struct mavlink_gimbal *const self = context->component->service;
	const struct gimbal_report now = gimbal_report(&self->device->gimbal, context->now_us);
	const bool is_still = now.pan_locked || now.tilt_locked;
	mavlink_gimbal_device_attitude_status_t *const status = payload;
	float q[4];

	(void)argument;
	quaternion_of_direction(told_direction(&now), q);
	memcpy(status->q, q, sizeof(q));
	status->time_boot_ms = (uint32_t)(context->now_us / US_PER_MS);
	status->flags = flags_of(&now);
	status->failure_flags = failures_of(&now);
	status->angular_velocity_x = is_still ? NAN : 0.0f;
	status->angular_velocity_y = is_still ? NAN : radians(now.speed[GIMBAL_TILT]);
	status->angular_velocity_z = is_still ? NAN : radians(now.speed[GIMBAL_PAN]);
	status->delta_yaw = now.heading_known ? radians(now.heading_mdeg) : NAN;
	status->delta_yaw_velocity = NAN;
	return MAV_RESULT_ACCEPTED;
}

/* For ground stations from before protocol v2. */
static uint8_t fill_mount(const struct mavlink_context *context, float argument, void *payload)
{
	const struct mavlink_gimbal *const self = context->component->service;
	const struct gimbal_report now = gimbal_report(&self->device->gimbal, context->now_us);
	const int64_t north_mdeg = (int64_t)now.level.yaw_mdeg + now.heading_mdeg;
	mavlink_mount_orientation_t *const mount = payload;

	(void)argument;
	mount->time_boot_ms = (uint32_t)(context->now_us / US_PER_MS);
	mount->roll = 0.0f;
	mount->pitch = (float)now.level.pitch_mdeg / MDEG_PER_DEG;
	mount->yaw = (float)now.own.yaw_mdeg / MDEG_PER_DEG;
	mount->yaw_absolute =
		now.heading_known ? (float)angle_wrap_mdeg(north_mdeg) / MDEG_PER_DEG : NAN;
	return MAV_RESULT_ACCEPTED;
}

static uint8_t fill_information(const struct mavlink_context *context, float argument,
                                void *payload)
{
	const struct mavlink_gimbal *const self = context->component->service;
	const struct gimbal_axis_config *const pan = &self->device->gimbal.config.axes[GIMBAL_PAN];
	const struct gimbal_axis_config *const tilt =
		&self->device->gimbal.config.axes[GIMBAL_TILT];
	const uint32_t code = self->identity->version_code;
	mavlink_gimbal_device_information_t *const info = payload;

	(void)argument;
	info->time_boot_ms = (uint32_t)(context->now_us / US_PER_MS);
	mavlink_copy_text(info->vendor_name, sizeof(info->vendor_name),
	                  self->identity->vendor_name);
	mavlink_copy_text(info->model_name, sizeof(info->model_name), self->identity->model_name);
	/* here the lowest byte is the major number */
	info->firmware_version = code >> 24 | (code >> 8 & 0xFF00u) | (code << 8 & 0xFF0000u);
	info->uid = mavlink_uid(self->identity);
	info->cap_flags = CAP_FLAGS;
	info->cap_flags2 = CAP_FLAGS;
	info->pitch_min = radians(tilt->min_mdeg);
	info->pitch_max = radians(tilt->max_mdeg);
	info->yaw_min = radians(pan->min_mdeg);
	info->yaw_max = radians(pan->max_mdeg);
	return MAV_RESULT_ACCEPTED;
}

static const struct mavlink_message_row messages[] = {
	MAVLINK_HEARTBEAT(HEARTBEAT_INTERVAL_US),
	{.kind = MAVLINK_KIND(GIMBAL_DEVICE_ATTITUDE_STATUS),
         .interval_us = ATTITUDE_INTERVAL_US,
         .fill = fill_attitude},
	{.kind = MAVLINK_KIND(GIMBAL_DEVICE_INFORMATION),
         .interval_us = MAVLINK_INTERVAL_OFF,
         .fill = fill_information},
	{.kind = MAVLINK_KIND(MOUNT_ORIENTATION),
         .interval_us = MAVLINK_INTERVAL_OFF,
         .fill = fill_mount},
	MAVLINK_COMMON_MESSAGES,
};

/* --- profile ---------------------------------------------------------------------------------- */

#ifdef CONFIG_PHAROS_FTP
static void no_files(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	mavlink_ftp_receive(NULL, context, frame);
}
#endif

/* PING and TIMESYNC ask the device, which answers once: as the illuminator. */
static const struct mavlink_receiver_row receivers[] = {
	MAVLINK_COMMON_RECEIVERS,
	MAVLINK_PARAM_RECEIVERS,
	{.id = MAVLINK_MSG_ID_HEARTBEAT,
         .target_system_offset = MAVLINK_NO_TARGET,
         .target_component_offset = MAVLINK_NO_TARGET,
         .receive = mavlink_gimbal_heartbeat},
	{.id = MAVLINK_MSG_ID_GIMBAL_DEVICE_SET_ATTITUDE,
         .target_system_offset = offsetof(mavlink_gimbal_device_set_attitude_t, target_system),
         .target_component_offset =
                 offsetof(mavlink_gimbal_device_set_attitude_t, target_component),
         .receive = set_attitude},
	{.id = MAVLINK_MSG_ID_AUTOPILOT_STATE_FOR_GIMBAL_DEVICE,
         .target_system_offset =
                 offsetof(mavlink_autopilot_state_for_gimbal_device_t, target_system),
         .target_component_offset =
                 offsetof(mavlink_autopilot_state_for_gimbal_device_t, target_component),
         .receive = mavlink_gimbal_autopilot_state},
	{.id = MAVLINK_MSG_ID_GIMBAL_MANAGER_INFORMATION,
         .target_system_offset = MAVLINK_NO_TARGET,
         .target_component_offset = MAVLINK_NO_TARGET,
         .receive = mavlink_gimbal_manager_information},
	{.id = MAVLINK_MSG_ID_GIMBAL_MANAGER_STATUS,
         .target_system_offset = MAVLINK_NO_TARGET,
         .target_component_offset = MAVLINK_NO_TARGET,
         .receive = mavlink_gimbal_manager_status},
	{.id = MAVLINK_MSG_ID_ATTITUDE,
         .target_system_offset = MAVLINK_NO_TARGET,
         .target_component_offset = MAVLINK_NO_TARGET,
         .receive = mavlink_gimbal_vehicle_attitude},
	{.id = MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
         .target_system_offset = MAVLINK_NO_TARGET,
         .target_component_offset = MAVLINK_NO_TARGET,
         .receive = mavlink_gimbal_vehicle_position},
#ifdef CONFIG_PHAROS_FTP
	{.id = MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL,
         .target_system_offset = offsetof(mavlink_file_transfer_protocol_t, target_system),
         .target_component_offset = offsetof(mavlink_file_transfer_protocol_t, target_component),
         .receive = no_files},
#endif
};

static uint8_t system_status(const void *service)
{
	const struct mavlink_gimbal *const self = service;

	return self->device->gimbal.fault ? MAV_STATE_CRITICAL : MAV_STATE_ACTIVE;
}

static bool step(const struct mavlink_context *context)
{
	struct mavlink_gimbal *const self = context->component->service;

	return mavlink_params_step(&self->params, context) && mavlink_gimbal_ask(context);
}

static int64_t deadline_us(const void *service)
{
	const struct mavlink_gimbal *const self = service;
	const int64_t list_us = mavlink_params_deadline_us(&self->params);
	const int64_t ask_us = mavlink_gimbal_ask_us(service);

	return list_us < ask_us ? list_us : ask_us;
}

static struct mavlink_params *params(void *service)
{
	return &((struct mavlink_gimbal *)service)->params;
}

static void tell(const struct mavlink_context *context, const struct device_effects *effects)
{
	mavlink_params_tell(params(context->component->service), context, &effects->params);
}

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

_Static_assert(COUNT(messages) <= MAVLINK_MESSAGES_MAX, "a stream for each message");

static const struct mavlink_identity *identity(const void *service)
{
	const struct mavlink_gimbal *const self = service;

	return self->identity;
}

const struct mavlink_profile mavlink_gimbal_profile = {
	.capabilities = MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE,
	.type = MAV_TYPE_GIMBAL,
	.command_count = COUNT(commands),
	.message_count = COUNT(messages),
	.receiver_count = COUNT(receivers),
	.commands = commands,
	.messages = messages,
	.receivers = receivers,
	.system_status = system_status,
	.step = step,
	.deadline_us = deadline_us,
	.identity = identity,
	.params = params,
	.tell = tell,
};
