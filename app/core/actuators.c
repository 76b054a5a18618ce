/* SPDX-License-Identifier: Apache-2.0 */
#include "core/actuators.h"

#include "core/assert.h"

#include <string.h>

#define MASK(count) ((1u << (count)) - 1u)

#define SERVO_PERIOD_US 20000u
#define SERVO_CENTRE_US 1500
#define SERVO_HALF_US   500

_Static_assert(SERVO_CENTRE_US - SERVO_HALF_US >= (int)SERVO_PULSE_MIN_US &&
                       SERVO_CENTRE_US + SERVO_HALF_US <= (int)SERVO_PULSE_MAX_US,
               "a servo's pulses are what servos take");

void actuators_init(struct actuators *self, int64_t now_us, const struct actuators_config *config)
{
	PHAROS_ASSERT((config->pwms & ~MASK(ACTUATORS_PWMS_MAX)) == 0);
	PHAROS_ASSERT((config->leds & ~MASK(ACTUATORS_LEDS_MAX)) == 0);
	PHAROS_ASSERT((config->gpio_outputs & ~MASK(ACTUATORS_GPIOS_MAX)) == 0);
	PHAROS_ASSERT((config->gpio_inputs & ~MASK(ACTUATORS_GPIOS_MAX)) == 0);
	memset(self, 0, sizeof(*self));
	self->config = *config;
	power_init(&self->power, config->power, config->power_on);
	shutdown_init(&self->shutdown, config->grace_us);
	thruster_init(&self->thruster, now_us, &config->thruster_config);
	focus_init(&self->focus, config->focus_travel_us);
	display_init(&self->display);
}

static bool has(uint32_t mask, uint32_t number)
{
	return number < 32u && (mask & (1u << number)) != 0;
}

bool actuators_set_pwm(struct actuators *self, uint32_t number, uint32_t period_us,
                       uint32_t duty_us)
{
	if (!has(self->config.pwms, number) || period_us == 0 ||
	    period_us > ACTUATORS_PERIOD_MAX_US || duty_us > period_us) {
		return false;
	}
	self->pwms[number] = (struct actuators_pwm){.period_us = period_us, .duty_us = duty_us};
	return true;
}

bool actuators_set_servo(struct actuators *self, uint32_t number, int32_t angle_mdeg)
{
	if (angle_mdeg < -ACTUATORS_SERVO_RANGE_MDEG || angle_mdeg > ACTUATORS_SERVO_RANGE_MDEG) {
		return false;
	}
	const int64_t way_us = (int64_t)angle_mdeg * SERVO_HALF_US / ACTUATORS_SERVO_RANGE_MDEG;

	return actuators_set_pwm(self, number, SERVO_PERIOD_US,
	                         (uint32_t)(SERVO_CENTRE_US + way_us));
}

bool actuators_set_led(struct actuators *self, uint32_t number, uint8_t value)
{
	if (!has(self->config.leds, number)) {
		return false;
	}
	self->leds[number] = value;
	return true;
}

bool actuators_set_gpio(struct actuators *self, uint32_t number, bool level)
{
	if (!has(self->config.gpio_outputs, number)) {
		return false;
	}
	const uint32_t bit = 1u << number;

	self->gpio_outputs = level ? self->gpio_outputs | bit : self->gpio_outputs & ~bit;
	return true;
}

static bool carry_out(struct actuators *self, int64_t now_us, const struct actuators_event *event)
{
	switch (event->kind) {
	case ACTUATORS_EVENT_POWER:
		return power_command(&self->power, now_us, event->number, event->timed.op,
		                     event->timed.us);
	case ACTUATORS_EVENT_SHUTDOWN:
		return shutdown_command(&self->shutdown, now_us, event->timed.op, event->timed.us);
	case ACTUATORS_EVENT_PWM:
		return actuators_set_pwm(self, event->number, event->pwm.period_us,
		                         event->pwm.duty_us);
	case ACTUATORS_EVENT_SERVO:
		return actuators_set_servo(self, event->number, event->angle_mdeg);
	case ACTUATORS_EVENT_LED:
		return actuators_set_led(self, event->number, event->led);
	case ACTUATORS_EVENT_GPIO:
		return actuators_set_gpio(self, event->number, event->level);
	case ACTUATORS_EVENT_THRUSTER:
		return thruster_set(&self->thruster, now_us, event->share_ppm);
	case ACTUATORS_EVENT_FOCUS:
		return focus_command(&self->focus, now_us, event->op);
	case ACTUATORS_EVENT_ZOOM:
		focus_move(&self->focus, now_us, (uint32_t)event->share_ppm);
		return true;
	case ACTUATORS_EVENT_DISPLAY:
		return display_command(&self->display, event->display.op, event->display.text,
		                       event->display.length);
	}
	PHAROS_ASSERT(false);
	return false;
}

enum actuators_result actuators_step(struct actuators *self, int64_t now_us,
                                     const struct actuators_event *event)
{
	if (carry_out(self, now_us, event)) {
		return ACTUATORS_ACCEPTED;
	}
	/* its controller arms: the only one that takes any value later */
	return event->kind == ACTUATORS_EVENT_THRUSTER ? ACTUATORS_FAILED : ACTUATORS_DENIED;
}

bool actuators_is_up(const struct actuators *self)
{
	return self->shutdown.state != SHUTDOWN_STATE_DOWN;
}

/* Down, the motors stop where they are; up again, the thruster's controller arms anew. */
static void follow_shutdown(struct actuators *self, int64_t now_us, bool was_up)
{
	const bool up = actuators_is_up(self);

	self->power.down = !up;
	if (was_up != up) {
		thruster_restart(&self->thruster, now_us);
		(void)focus_command(&self->focus, now_us, FOCUS_ACTION_STOP);
	}
}

bool actuators_advance(struct actuators *self, int64_t now_us, struct shutdown_notice *notice)
{
	power_advance(&self->power, now_us);
	thruster_advance(&self->thruster, now_us);
	focus_advance(&self->focus, now_us);
	const bool told = shutdown_advance(&self->shutdown, now_us, notice);

	follow_shutdown(self, now_us, !self->power.down);
	return told;
}

static int64_t earlier(int64_t a_us, int64_t b_us)
{
	return (a_us < b_us) ? a_us : b_us;
}

int64_t actuators_deadline_us(const struct actuators *self)
{
	const int64_t motors_us =
		earlier(thruster_deadline_us(&self->thruster), focus_deadline_us(&self->focus));
	const int64_t power_us =
		earlier(power_deadline_us(&self->power), shutdown_deadline_us(&self->shutdown));

	return earlier(motors_us, power_us);
}

void actuators_outputs(const struct actuators *self, struct actuators_outputs *outputs)
{
	memset(outputs, 0, sizeof(*outputs));
	outputs->display = self->display;
	if (!actuators_is_up(self)) {
		outputs->display.on = false;
		return;
	}
	outputs->power = power_outputs(&self->power);
	outputs->gpio_outputs = self->gpio_outputs;
	outputs->thruster_pulse_us = self->config.thruster ? thruster_pulse_us(&self->thruster) : 0;
	outputs->focus = self->focus.motor;
	memcpy(outputs->pwms, self->pwms, sizeof(outputs->pwms));
	memcpy(outputs->leds, self->leds, sizeof(outputs->leds));
}
