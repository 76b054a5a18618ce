/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/messages.h"

#define KIND_OF(member)                                                                            \
	_Generic((member), uint8_t                                                                 \
	         : IMC_U8, uint16_t                                                                \
	         : IMC_U16, uint32_t                                                               \
	         : IMC_U32, float                                                                  \
	         : IMC_F32, double                                                                 \
	         : IMC_F64, struct imc_text                                                        \
	         : IMC_TEXT, struct imc_parameter_list                                             \
	         : IMC_PARAMETER_LIST)

/* A field of struct imc_type_; its kind follows from its C type. */
#define FIELD(type_, name_)                                                                        \
	{                                                                                          \
		.kind = KIND_OF(((const struct imc_##type_ *)0)->name_),                           \
		.offset = offsetof(struct imc_##type_, name_),                                     \
	}

/* The fields of struct imc_type_, in wire order. */
#define FIELDS(type_, ...) static const struct imc_field type_##_fields[] = {__VA_ARGS__}

FIELDS(entity_state, FIELD(entity_state, state), FIELD(entity_state, flags),
       FIELD(entity_state, description));
FIELDS(entity_info, FIELD(entity_info, id), FIELD(entity_info, label),
       FIELD(entity_info, component), FIELD(entity_info, act_time), FIELD(entity_info, deact_time));
FIELDS(query_entity_info, FIELD(query_entity_info, id));
FIELDS(entity_list, FIELD(entity_list, op), FIELD(entity_list, list));
FIELDS(entity_activation_state, FIELD(entity_activation_state, state),
       FIELD(entity_activation_state, error));
FIELDS(announce, FIELD(announce, sys_name), FIELD(announce, sys_type), FIELD(announce, owner),
       FIELD(announce, lat), FIELD(announce, lon), FIELD(announce, height),
       FIELD(announce, services));
FIELDS(announce_service, FIELD(announce_service, service), FIELD(announce_service, service_type));
FIELDS(entity_parameter, FIELD(entity_parameter, name), FIELD(entity_parameter, value));
FIELDS(entity_parameters, FIELD(entity_parameters, name), FIELD(entity_parameters, params));
FIELDS(query_entity_parameters, FIELD(query_entity_parameters, name),
       FIELD(query_entity_parameters, visibility), FIELD(query_entity_parameters, scope));
FIELDS(save_entity_parameters, FIELD(save_entity_parameters, name));
FIELDS(version_info, FIELD(version_info, op), FIELD(version_info, version),
       FIELD(version_info, description));
FIELDS(camera_zoom, FIELD(camera_zoom, id), FIELD(camera_zoom, zoom), FIELD(camera_zoom, action));
FIELDS(set_thruster_actuation, FIELD(set_thruster_actuation, id),
       FIELD(set_thruster_actuation, value));
FIELDS(set_servo_position, FIELD(set_servo_position, id), FIELD(set_servo_position, value));
FIELDS(set_control_surface_deflection, FIELD(set_control_surface_deflection, id),
       FIELD(set_control_surface_deflection, angle));
FIELDS(remote_actions_request, FIELD(remote_actions_request, op),
       FIELD(remote_actions_request, actions));
FIELDS(remote_actions, FIELD(remote_actions, actions));
FIELDS(button_event, FIELD(button_event, button), FIELD(button_event, value));
FIELDS(lcd_control, FIELD(lcd_control, op), FIELD(lcd_control, text));
FIELDS(power_operation, FIELD(power_operation, op), FIELD(power_operation, time_remain),
       FIELD(power_operation, sched_time));
FIELDS(power_channel_control, FIELD(power_channel_control, name), FIELD(power_channel_control, op),
       FIELD(power_channel_control, sched_time));
FIELDS(power_channel_state, FIELD(power_channel_state, name), FIELD(power_channel_state, state));
FIELDS(led_brightness, FIELD(led_brightness, name), FIELD(led_brightness, value));
FIELDS(query_led_brightness, FIELD(query_led_brightness, name));
FIELDS(pwm, FIELD(pwm, id), FIELD(pwm, period), FIELD(pwm, duty_cycle));
FIELDS(gpio_state, FIELD(gpio_state, name), FIELD(gpio_state, value));
FIELDS(gpio_state_get, FIELD(gpio_state_get, name));

#define TYPE(id_, name_, fields_)                                                                  \
	{                                                                                          \
		.id = IMC_##id_, .name = (name_), .fields = fields_##_fields,                      \
		.fields_count = sizeof(fields_##_fields) / sizeof(fields_##_fields[0]),            \
	}
#define EMPTY(id_, name_)                                                                          \
	{                                                                                          \
		.id = IMC_##id_, .name = (name_)                                                   \
	}

const struct imc_type imc_types[] = {
	TYPE(ENTITY_STATE, "EntityState", entity_state),
	EMPTY(QUERY_ENTITY_STATE, "QueryEntityState"),
	TYPE(ENTITY_INFO, "EntityInfo", entity_info),
	TYPE(QUERY_ENTITY_INFO, "QueryEntityInfo", query_entity_info),
	TYPE(ENTITY_LIST, "EntityList", entity_list),
	TYPE(ENTITY_ACTIVATION_STATE, "EntityActivationState", entity_activation_state),
	EMPTY(QUERY_ENTITY_ACTIVATION_STATE, "QueryEntityActivationState"),
	EMPTY(HEARTBEAT, "Heartbeat"),
	TYPE(ANNOUNCE, "Announce", announce),
	TYPE(ANNOUNCE_SERVICE, "AnnounceService", announce_service),
	TYPE(CAMERA_ZOOM, "CameraZoom", camera_zoom),
	TYPE(SET_THRUSTER_ACTUATION, "SetThrusterActuation", set_thruster_actuation),
	TYPE(SET_SERVO_POSITION, "SetServoPosition", set_servo_position),
	TYPE(SET_CONTROL_SURFACE_DEFLECTION, "SetControlSurfaceDeflection",
             set_control_surface_deflection),
	TYPE(REMOTE_ACTIONS_REQUEST, "RemoteActionsRequest", remote_actions_request),
	TYPE(REMOTE_ACTIONS, "RemoteActions", remote_actions),
	TYPE(BUTTON_EVENT, "ButtonEvent", button_event),
	TYPE(LCD_CONTROL, "LcdControl", lcd_control),
	TYPE(POWER_OPERATION, "PowerOperation", power_operation),
	TYPE(POWER_CHANNEL_CONTROL, "PowerChannelControl", power_channel_control),
	EMPTY(QUERY_POWER_CHANNEL_STATE, "QueryPowerChannelState"),
	TYPE(POWER_CHANNEL_STATE, "PowerChannelState", power_channel_state),
	TYPE(LED_BRIGHTNESS, "LedBrightness", led_brightness),
	TYPE(QUERY_LED_BRIGHTNESS, "QueryLedBrightness", query_led_brightness),
	TYPE(SET_LED_BRIGHTNESS, "SetLedBrightness", led_brightness),
	TYPE(SET_PWM, "SetPWM", pwm),
	TYPE(PWM, "PWM", pwm),
	TYPE(ENTITY_PARAMETER, "EntityParameter", entity_parameter),
	TYPE(ENTITY_PARAMETERS, "EntityParameters", entity_parameters),
	TYPE(QUERY_ENTITY_PARAMETERS, "QueryEntityParameters", query_entity_parameters),
	TYPE(SET_ENTITY_PARAMETERS, "SetEntityParameters", entity_parameters),
	TYPE(SAVE_ENTITY_PARAMETERS, "SaveEntityParameters", save_entity_parameters),
	TYPE(GPIO_STATE, "GpioState", gpio_state),
	TYPE(GPIO_STATE_GET, "GpioStateGet", gpio_state_get),
	TYPE(GPIO_STATE_SET, "GpioStateSet", gpio_state),
	TYPE(VERSION_INFO, "VersionInfo", version_info),
};

const size_t imc_types_count = sizeof(imc_types) / sizeof(imc_types[0]);

const struct imc_type *imc_type_find(uint16_t id)
{
	size_t first = 0;
	size_t last = imc_types_count;

	while (first < last) {
		const size_t middle = (first + last) / 2;

		if (imc_types[middle].id == id) {
			return &imc_types[middle];
		}
		if (imc_types[middle].id < id) {
			first = middle + 1;
		} else {
			last = middle;
		}
	}
	return NULL;
}
