/* SPDX-License-Identifier: Apache-2.0 */
/*
 * LEDs, GPIO lines, PWM, servos and motors of the actuation service.
 */
#include "proto/imc/actuation_internal.h"

#define LED_FULL  255u
#define ZOOM_FULL 255u

/* The f32 nearest to a quarter turn and half a turn; both are a little more. */
#define QUARTER_TURN_RAD 1.5707964f
#define HALF_TURN_RAD    3.1415927f
#define MDEG_PER_RAD     57295.78f

/* --- LEDs ------------------------------------------------------------------------------------- */

/* Of the lamp as commanded, but 0 while heat keeps it dark: IMC has no flag that would tell. */
static uint8_t led_value(const struct imc_actuation *self, const struct imc_map_row *row)
{
	const struct illuminator_settings *const lamp = &imc_lamp_of(self)->settings;

	if (row->thing != IMC_THING_LAMP) {
		return self->device->actuators.leds[row->number];
	}
	if (!lamp->enable || imc_lamp_of(self)->thermal.state == THERMAL_STATE_SHUTDOWN) {
		return 0;
	}
	return (uint8_t)((lamp->brightness_ppm * LED_FULL + PPM_ONE / 2) / PPM_ONE);
}

static void reply_led(const struct imc_actuation *self, const struct imc_turn *turn,
                      const struct imc_map_row *row)
{
	const struct imc_message message = {
		.id = IMC_LED_BRIGHTNESS,
		.led_brightness = {.name = imc_text_of(row->name), .value = led_value(self, row)},
	};

	imc_turn_reply(turn, IMC_ENTITY_LAMP, &message);
}

enum imc_actuation_outcome imc_actuation_take_query_led_brightness(struct imc_actuation *self,
                                                                   const struct imc_turn *turn)
{
	const struct imc_map_row *const row = imc_actuation_find_name(
		self, IMC_MAP_LED, &turn->packet->message.query_led_brightness.name);

	if (row == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	reply_led(self, turn, row);
	return IMC_ACTUATION_DONE;
}

enum imc_actuation_outcome imc_actuation_take_set_led_brightness(struct imc_actuation *self,
                                                                 const struct imc_turn *turn)
{
	const struct imc_led_brightness *const set = &turn->packet->message.led_brightness;
	const struct imc_map_row *const row =
		imc_actuation_find_name(self, IMC_MAP_LED, &set->name);
	enum imc_actuation_outcome outcome;

	if (row == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	if (row->thing == IMC_THING_LAMP) {
		outcome = imc_actuation_dim_lamp(self, turn->now_us,
		                                 (set->value * PPM_ONE + LED_FULL / 2) / LED_FULL);
	} else {
		outcome = imc_actuation_drive(self, turn->now_us,
		                              &(struct actuators_event){
						      .kind = ACTUATORS_EVENT_LED,
						      .number = row->number,
						      .led = set->value,
					      });
	}
	reply_led(self, turn, row);
	return outcome;
}

/* --- GPIO lines ------------------------------------------------------------------------------- */

static void reply_gpio(const struct imc_actuation *self, const struct imc_turn *turn,
                       const struct imc_map_row *row)
{
	const uint32_t levels = (row->thing == IMC_THING_GPIO_INPUT)
	                                ? self->gpio_inputs
	                                : self->device->actuators.gpio_outputs;
	const struct imc_message message = {
		.id = IMC_GPIO_STATE,
		.gpio_state = {.name = imc_text_of(row->name),
	                       .value = imc_mask_has(levels, row->number) ? 1 : 0},
	};

	imc_turn_reply(turn, IMC_ENTITY_OUTPUTS, &message);
}

enum imc_actuation_outcome imc_actuation_take_gpio_state_get(struct imc_actuation *self,
                                                             const struct imc_turn *turn)
{
	const struct imc_map_row *const row = imc_actuation_find_name(
		self, IMC_MAP_GPIO, &turn->packet->message.gpio_state_get.name);

	if (row == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	reply_gpio(self, turn, row);
	return IMC_ACTUATION_DONE;
}

enum imc_actuation_outcome imc_actuation_take_gpio_state_set(struct imc_actuation *self,
                                                             const struct imc_turn *turn)
{
	const struct imc_gpio_state *const set = &turn->packet->message.gpio_state;
	const struct imc_map_row *const row =
		imc_actuation_find_name(self, IMC_MAP_GPIO, &set->name);

	if (row == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	if (set->value > 1) {
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	const struct actuators_event event = {
		.kind = ACTUATORS_EVENT_GPIO,
		.number = row->number,
		.level = set->value != 0,
	};
	const enum imc_actuation_outcome outcome =
		row->thing == IMC_THING_GPIO_OUTPUT
			? imc_actuation_drive(self, turn->now_us, &event)
			: IMC_ACTUATION_REFUSED;

	reply_gpio(self, turn, row);
	return outcome;
}

/* --- PWM, servos, motors ---------------------------------------------------------------------- */

enum imc_actuation_outcome imc_actuation_take_set_pwm(struct imc_actuation *self,
                                                      const struct imc_turn *turn)
{
	struct imc_message message = turn->packet->message;
	const struct imc_map_row *const row =
		imc_actuation_find_id(self, IMC_MAP_PWM, message.pwm.id);
	enum imc_actuation_outcome outcome;

	if (row == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	if (row->thing == IMC_THING_LAMP) {
		outcome = imc_actuation_pulse_lamp(self, turn->now_us, &message.pwm);
	} else {
		const struct actuators_event event = {
			.kind = ACTUATORS_EVENT_PWM,
			.number = row->number,
			.pwm = {.period_us = message.pwm.period, .duty_us = message.pwm.duty_cycle},
		};

		outcome = imc_actuation_drive(self, turn->now_us, &event);
	}
	if (outcome == IMC_ACTUATION_DONE) {
		message.id = IMC_PWM;
		imc_turn_reply(turn, IMC_ENTITY_OUTPUTS, &message);
	}
	return outcome;
}

/* angle_rad within ±limit_rad, at most half a turn. Comparisons with NaN are false. */
static enum imc_actuation_outcome turn_servo(struct imc_actuation *self, int64_t now_us, uint8_t id,
                                             float angle_rad, float limit_rad)
{
	const struct imc_map_row *const row = imc_actuation_find_id(self, IMC_MAP_SERVO, id);

	if (row == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	if (!(angle_rad >= -limit_rad && angle_rad <= limit_rad)) {
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	const float half = (angle_rad < 0.0f) ? -0.5f : 0.5f;
	const int32_t angle_mdeg = (int32_t)(angle_rad * MDEG_PER_RAD + half);

	if (row->thing == IMC_THING_PWM) {
		const struct actuators_event event = {
			.kind = ACTUATORS_EVENT_SERVO,
			.number = row->number,
			.angle_mdeg = angle_mdeg,
		};

		return imc_actuation_drive(self, now_us, &event);
	}
	struct gimbal_event event = {.kind = GIMBAL_EVENT_AIM};

	event.aim[row->thing == IMC_THING_PAN ? GIMBAL_PAN : GIMBAL_TILT] =
		(struct gimbal_aim){.kind = GIMBAL_ANGLE, .value = angle_mdeg};
	return imc_actuation_outcome_of(
		pharos_device_point(self->device, now_us, &imc_who, &event));
}

enum imc_actuation_outcome imc_actuation_take_set_servo_position(struct imc_actuation *self,
                                                                 const struct imc_turn *turn)
{
	const struct imc_set_servo_position *const set = &turn->packet->message.set_servo_position;

	return turn_servo(self, turn->now_us, set->id, set->value, QUARTER_TURN_RAD);
}

enum imc_actuation_outcome
imc_actuation_take_set_control_surface_deflection(struct imc_actuation *self,
                                                  const struct imc_turn *turn)
{
	const struct imc_set_control_surface_deflection *const set =
		&turn->packet->message.set_control_surface_deflection;

	return turn_servo(self, turn->now_us, set->id, set->angle, HALF_TURN_RAD);
}

enum imc_actuation_outcome imc_actuation_take_set_thruster_actuation(struct imc_actuation *self,
                                                                     const struct imc_turn *turn)
{
	const struct imc_set_thruster_actuation *const set =
		&turn->packet->message.set_thruster_actuation;

	if (imc_actuation_find_id(self, IMC_MAP_THRUSTER, set->id) == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	if (!(set->value >= -1.0f && set->value <= 1.0f)) {
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	const struct actuators_event event = {
		.kind = ACTUATORS_EVENT_THRUSTER,
		.share_ppm = (int32_t)(set->value * (float)PPM_ONE),
	};

	return imc_actuation_drive(self, turn->now_us, &event);
}

/* In and out run until stopped or at the end; with a zoom level they go there. */
enum imc_actuation_outcome imc_actuation_take_camera_zoom(struct imc_actuation *self,
                                                          const struct imc_turn *turn)
{
	const struct imc_camera_zoom *const set = &turn->packet->message.camera_zoom;
	const bool level =
		set->zoom != 0 && (set->action == IMC_ZOOM_IN || set->action == IMC_ZOOM_OUT);

	if (imc_actuation_find_id(self, IMC_MAP_ZOOM, set->id) == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	struct actuators_event event = {.kind = ACTUATORS_EVENT_FOCUS, .op = set->action};

	if (level) {
		event.kind = ACTUATORS_EVENT_ZOOM;
		event.share_ppm = (int32_t)((set->zoom * PPM_ONE + ZOOM_FULL / 2) / ZOOM_FULL);
	}
	return imc_actuation_drive(self, turn->now_us, &event);
}
