/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lamp, on behalf of the actuation service.
 */
#include "proto/imc/actuation_internal.h"

/* The event that sets everything at once. */
enum imc_actuation_outcome imc_actuation_set_lamp(struct imc_actuation *self, int64_t now_us,
                                                  const struct illuminator_settings *settings)
{
	const struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_RESTORE,
	                                        .restore = *settings};

	return imc_actuation_outcome_of(
		pharos_device_apply(self->device, now_us, &imc_who, IMC_LAMP, &event, 1));
}

/* Dark is off, and keeps the brightness set before. */
enum imc_actuation_outcome imc_actuation_dim_lamp(struct imc_actuation *self, int64_t now_us,
                                                  uint32_t brightness_ppm)
{
	struct illuminator_settings settings = imc_lamp_of(self)->settings;

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
	struct illuminator_settings settings = imc_lamp_of(self)->settings;

	if (pwm->period == 0 || pwm->duty_cycle > pwm->period) {
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	const uint32_t duty_ppm =
		(uint32_t)(((uint64_t)pwm->duty_cycle * PPM_ONE + pwm->period / 2) / pwm->period);

	settings.enable = pwm->duty_cycle > 0;
	settings.mode = ILLUMINATOR_MODE_INTERNAL;
	if (pwm->period < imc_lamp_of(self)->config.min_period_us) {
		settings.strobe_period_us = 0;
		settings.duty_ppm = PPM_ONE;
		settings.brightness_ppm = settings.enable ? duty_ppm : settings.brightness_ppm;
	} else {
		settings.strobe_period_us = pwm->period;
		settings.duty_ppm = duty_ppm;
	}
	return imc_actuation_set_lamp(self, now_us, &settings);
}
