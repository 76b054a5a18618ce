/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/illuminator_service.h"
#include "proto/mavlink/internal.h"

/*
 * 246: param3 is what to do with the component of param4, 0: all. Only rebooting is in our hands;
 * a lamp that is on would go dark, so that needs REBOOT_SHUTDOWN_CONDITIONS_FORCE in param6. To all
 * it may be about the autopilot alone.
 */
uint8_t mavlink_preflight_reboot(const struct mavlink_context *context,
                                 const struct mavlink_command *command, struct mavlink_reply *reply)
{
	const struct mavlink_illuminator *const self = context->component->service;
	const struct device_who who = mavlink_who(context);
	uint32_t action;
	uint32_t component;

	(void)reply;
	if (!mavlink_whole(command->param[2], UINT8_MAX, &action) ||
	    !mavlink_whole(command->param[3], UINT8_MAX, &component) ||
	    action != REBOOT_SHUTDOWN_ACTION_REBOOT ||
	    (component != 0 && component != context->component->id)) {
		return command->to_all ? MAVLINK_NO_ANSWER : MAV_RESULT_DENIED;
	}
	if (!pharos_device_may(self->device, &who, SECURITY_RESTART)) {
		return MAV_RESULT_DENIED;
	}
	if (pharos_device_lamp(self->device, self->lamp)->illuminator.settings.enable &&
	    command->param[5] != (float)REBOOT_SHUTDOWN_CONDITIONS_FORCE) {
		return MAV_RESULT_TEMPORARILY_REJECTED;
	}
	context->out->reboot = true;
	return MAV_RESULT_ACCEPTED;
}

/*
 * 245: parameters are stored whenever they change, and read at the start, so only putting them back
 * to the defaults has anything to do. To all it may be about an autopilot's sensors or missions.
 */
uint8_t mavlink_preflight_storage(const struct mavlink_context *context,
                                  const struct mavlink_command *command,
                                  struct mavlink_reply *reply)
{
	const struct mavlink_illuminator *const self = context->component->service;
	const struct device_who who = mavlink_who(context);
	uint32_t action;

	(void)reply;
	if (!mavlink_whole(command->param[0], UINT8_MAX, &action)) {
		action = UINT8_MAX;
	}
	switch (action) {
	case PARAM_READ_PERSISTENT:
	case PARAM_WRITE_PERSISTENT:
		return MAV_RESULT_ACCEPTED;
	case PARAM_RESET_FACTORY_DEFAULT:
	case PARAM_RESET_ALL_DEFAULT:
		return pharos_device_reset_params(self->device, context->now_us, &who)
		               ? MAV_RESULT_ACCEPTED
		               : MAV_RESULT_DENIED;
	default:
		return command->to_all ? MAVLINK_NO_ANSWER : MAV_RESULT_DENIED;
	}
}
