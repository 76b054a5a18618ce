/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/actuation.h"

#include "core/assert.h"
#include "proto/imc/actuation_internal.h"

#include <string.h>

#define STROBE_DEFAULT_PERIOD_US 500000u
#define STROBE_DEFAULT_DUTY_PPM  500000u

_Static_assert(SHUTDOWN_GRACE_MAX_US <= UINT32_MAX, "fits what small processors convert");

/* A message's function, and the entity that it is for. */
struct handler {
	uint16_t id;
	uint8_t entity;
	bool when_down; /* taken also while the device is down */
	enum imc_actuation_outcome (*take)(struct imc_actuation *self, const struct imc_turn *turn);
};

void imc_turn_reply(const struct imc_turn *turn, enum imc_entity entity,
                    const struct imc_message *message)
{
	imc_outbox_reply(turn->out, turn->packet, (uint8_t)entity, message);
}

/* Whether this board has what the map says. */
bool imc_actuation_has(const struct imc_actuation *self, const struct imc_map_row *row)
{
	const struct actuators_config *const board = &self->device->actuators.config;

	switch (row->thing) {
	case IMC_THING_POWER_CHANNEL:
		return imc_mask_has(board->power, row->number);
	case IMC_THING_LAMP:
		return true;
	case IMC_THING_LED:
		return imc_mask_has(board->leds, row->number);
	case IMC_THING_GPIO_OUTPUT:
		return imc_mask_has(board->gpio_outputs, row->number);
	case IMC_THING_GPIO_INPUT:
		return imc_mask_has(board->gpio_inputs, row->number);
	case IMC_THING_PWM:
		return imc_mask_has(board->pwms, row->number);
	case IMC_THING_PAN:
	case IMC_THING_TILT:
		return pharos_device_has_gimbal(self->device);
	case IMC_THING_THRUSTER:
		return board->thruster;
	case IMC_THING_FOCUS:
		return board->focus;
	}
	PHAROS_ASSERT(false);
	return false;
}

/* NULL: not on this board; what was asked for is remembered for the log. */
const struct imc_map_row *imc_actuation_find_name(struct imc_actuation *self,
                                                  enum imc_map_space space,
                                                  const struct imc_text *name)
{
	const struct imc_map_row *const row = imc_map_by_name(space, name);
	const size_t length =
		(name->length < IMC_ACTUATION_NAME_MAX) ? name->length : IMC_ACTUATION_NAME_MAX;

	for (size_t i = 0; i < length; i++) {
		const char byte = name->bytes[i];

		self->refusal.name[i] = (byte >= ' ' && byte <= '~') ? byte : '?';
	}
	self->refusal.name[length] = '\0';
	return (row != NULL && imc_actuation_has(self, row)) ? row : NULL;
}

const struct imc_map_row *imc_actuation_find_id(struct imc_actuation *self,
                                                enum imc_map_space space, uint8_t id)
{
	const struct imc_map_row *const row = imc_map_by_id(space, id);

	self->refusal.number = id;
	return (row != NULL && imc_actuation_has(self, row)) ? row : NULL;
}

void imc_actuation_tell(const struct shutdown_notice *notice, struct imc_outbox *out)
{
	const struct imc_message message = {
		.id = IMC_POWER_OPERATION,
		.power_operation = {.op = (uint8_t)notice->op,
	                            .time_remain =
	                                    (float)(uint32_t)notice->remain_us / (float)US_PER_S},
	};

	imc_outbox_publish(out, (uint8_t)IMC_ENTITY_POWER, &message);
}

void imc_actuation_button(uint8_t button, bool pressed, struct imc_outbox *out)
{
	const struct imc_message message = {
		.id = IMC_BUTTON_EVENT,
		.button_event = {.button = button, .value = pressed ? 1 : 0},
	};

	imc_outbox_publish(out, (uint8_t)IMC_ENTITY_PANEL, &message);
}

static const struct handler handlers[] = {
	{IMC_CAMERA_ZOOM, IMC_ENTITY_OUTPUTS, false, imc_actuation_take_camera_zoom},
	{IMC_SET_THRUSTER_ACTUATION, IMC_ENTITY_OUTPUTS, false,
         imc_actuation_take_set_thruster_actuation},
	{IMC_SET_SERVO_POSITION, IMC_ENTITY_OUTPUTS, false, imc_actuation_take_set_servo_position},
	{IMC_SET_CONTROL_SURFACE_DEFLECTION, IMC_ENTITY_OUTPUTS, false,
         imc_actuation_take_set_control_surface_deflection},
	{IMC_REMOTE_ACTIONS_REQUEST, IMC_ENTITY_PANEL, true,
         imc_actuation_take_remote_actions_request},
	{IMC_REMOTE_ACTIONS, IMC_ENTITY_PANEL, false, imc_actuation_take_remote_actions},
	{IMC_LCD_CONTROL, IMC_ENTITY_PANEL, false, imc_actuation_take_lcd_control},
	{IMC_POWER_OPERATION, IMC_ENTITY_POWER, true, imc_actuation_take_power_operation},
	{IMC_POWER_CHANNEL_CONTROL, IMC_ENTITY_POWER, false,
         imc_actuation_take_power_channel_control},
	{IMC_QUERY_POWER_CHANNEL_STATE, IMC_ENTITY_POWER, true,
         imc_actuation_take_query_power_channel_state},
	{IMC_QUERY_LED_BRIGHTNESS, IMC_ENTITY_LAMP, true, imc_actuation_take_query_led_brightness},
	{IMC_SET_LED_BRIGHTNESS, IMC_ENTITY_LAMP, false, imc_actuation_take_set_led_brightness},
	{IMC_SET_PWM, IMC_ENTITY_OUTPUTS, false, imc_actuation_take_set_pwm},
	{IMC_GPIO_STATE_GET, IMC_ENTITY_OUTPUTS, true, imc_actuation_take_gpio_state_get},
	{IMC_GPIO_STATE_SET, IMC_ENTITY_OUTPUTS, false, imc_actuation_take_gpio_state_set},
};

static const struct handler *handler_of(uint16_t id)
{
	for (size_t i = 0; i < sizeof(handlers) / sizeof(handlers[0]); i++) {
		if (handlers[i].id == id) {
			return &handlers[i];
		}
	}
	return NULL;
}

static bool is_for(const struct handler *handler, uint8_t entity)
{
	return entity == IMC_ENTITY_ALL || entity == IMC_ENTITY_SYSTEM || entity == handler->entity;
}

void imc_actuation_init(struct imc_actuation *self, struct pharos_device *device)
{
	memset(self, 0, sizeof(*self));
	self->device = device;
	self->strobe_period_us = STROBE_DEFAULT_PERIOD_US;
	self->strobe_duty_ppm = STROBE_DEFAULT_DUTY_PPM;
	remote_init(&self->remote);
}

const struct device_who imc_who = {.way = SECURITY_WAY_IMC};

enum imc_actuation_outcome imc_actuation_outcome_of(enum device_result result)
{
	switch (result) {
	case DEVICE_ACCEPTED:
		return IMC_ACTUATION_DONE;
	case DEVICE_DENIED:
		return IMC_ACTUATION_OUT_OF_RANGE;
	case DEVICE_ABSENT:
		return IMC_ACTUATION_UNKNOWN;
	case DEVICE_FAILED:
	case DEVICE_EXCLUDED:
	case DEVICE_OUTRANKED:
	case DEVICE_KEPT:
		break;
	}
	return IMC_ACTUATION_REFUSED;
}

enum imc_actuation_outcome imc_actuation_drive(struct imc_actuation *self, int64_t now_us,
                                               const struct actuators_event *event)
{
	return imc_actuation_outcome_of(
		pharos_device_output(self->device, now_us, &imc_who, event));
}

void imc_actuation_receive(struct imc_actuation *self, int64_t now_us,
                           const struct imc_packet *packet, struct imc_outbox *out)
{
	const struct imc_turn turn = {.now_us = now_us, .packet = packet, .out = out};
	const struct handler *const handler = handler_of(packet->message.id);
	enum imc_actuation_outcome outcome = IMC_ACTUATION_UNKNOWN;

	if (handler == NULL) {
		return;
	}
	memset(&self->refusal, 0, sizeof(self->refusal));
	self->refusal.id = packet->message.id;
	if (is_for(handler, packet->header.dst_ent)) {
		outcome = (handler->when_down || actuators_is_up(&self->device->actuators))
		                  ? handler->take(self, &turn)
		                  : IMC_ACTUATION_REFUSED;
	}
	self->stats.outcomes[outcome]++;
	self->refusal.outcome = outcome;
}

void imc_actuation_step(struct imc_actuation *self, int64_t now_us)
{
	const struct remote_output released = remote_advance(&self->remote, now_us);

	(void)imc_actuation_perform_remote(self, now_us, &released);
}

int64_t imc_actuation_deadline_us(const struct imc_actuation *self)
{
	return remote_deadline_us(&self->remote);
}
