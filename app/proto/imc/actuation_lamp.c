/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lamp, on behalf of the actuation service.
 */
#include "proto/imc/actuation_internal.h"

/* At most once per call: there is one place for what follows from it. */
static enum imc_actuation_outcome step_lamp(struct imc_actuation *self, int64_t now_us,
                                            const struct illuminator_event *event)
{
	if (arbiter_check(self->arbiter, now_us, ARBITER_SOURCE_IMC) != ARBITER_GRANTED) {
		return IMC_ACTUATION_REFUSED;
	}
	switch (illuminator_step(self->illuminator, now_us, event, &self->effects.command)) {
	case ILLUMINATOR_ACCEPTED:
		arbiter_commit(self->arbiter, now_us, ARBITER_SOURCE_IMC);
		return IMC_ACTUATION_DONE;
	case ILLUMINATOR_DENIED:
		return IMC_ACTUATION_OUT_OF_RANGE;
	case ILLUMINATOR_FAILED:
		break;
	}
	return IMC_ACTUATION_REFUSED;
}

/* The event that sets everything at once. */
enum imc_actuation_outcome imc_actuation_set_lamp(struct imc_actuation *self, int64_t now_us,
                                                  const struct illuminator_settings *settings)
{
	const struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_RESTORE,
	                                        .restore = *settings};

	return step_lamp(self, now_us, &event);
}

/* Dark is off, and keeps the brightness set before. */
enum imc_actuation_outcome imc_actuation_dim_lamp(struct imc_actuation *self, int64_t now_us,
                                                  uint32_t brightness_ppm)
{
	struct illuminator_settings settings = self->illuminator->settings;

	settings.enable = brightness_ppm > 0;
	if (settings.enable) {
		settings.brightness_ppm = brightness_ppm;
	}
	return imc_actuation_set_lamp(self, now_us, &settings);
}

/*
 * Too fast for a strobe is dimming: the duty cycle is the brightness. Else it is a strobe of the
 * brightness set before. A duty cycle of 0 is off.
 */
enum imc_actuation_outcome imc_actuation_pulse_lamp(struct imc_actuation *self, int64_t now_us,
                                                    const struct imc_pwm *pwm)
{
	struct illuminator_settings settings = self->illuminator->settings;

	if (pwm->period == 0 || pwm->duty_cycle > pwm->period) {
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	const uint32_t duty_ppm =
		(uint32_t)(((uint64_t)pwm->duty_cycle * PPM_ONE + pwm->period / 2) / pwm->period);

	settings.enable = pwm->duty_cycle > 0;
	settings.mode = ILLUMINATOR_MODE_INTERNAL;
	if (pwm->period < self->illuminator->config.min_period_us) {
		settings.strobe_period_us = 0;
		settings.duty_ppm = PPM_ONE;
		settings.brightness_ppm = settings.enable ? duty_ppm : settings.brightness_ppm;
	} else {
		settings.strobe_period_us = pwm->period;
		settings.duty_ppm = duty_ppm;
	}
	return imc_actuation_set_lamp(self, now_us, &settings);
}

void imc_actuation_power_lamp(struct imc_actuation *self, int64_t now_us)
{
	const uint32_t lamp = 1u << POWER_CHANNEL_LAMP;
	const bool switched = (self->actuators.config.power & lamp) != 0;
	const struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_POWER,
		.powered = switched ? (power_outputs(&self->actuators.power) & lamp) != 0
	                            : actuators_is_up(&self->actuators),
	};

	if (event.powered == self->illuminator->unpowered) {
		illuminator_step(self->illuminator, now_us, &event, &self->effects.power);
	}
}
