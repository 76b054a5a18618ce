/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_servo_pwm

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/drivers/pwm.h>
#include <zephyr/sys/util.h>

#include <pharos/drivers/servo.h>

struct servo_pwm_config {
	struct pwm_dt_spec pwm;
	uint32_t pulse_min_ns;
	uint32_t pulse_max_ns;
};

static int servo_pwm_set_pulse(const struct device *dev, uint32_t pulse_ns)
{
	const struct servo_pwm_config *config = dev->config;

	if (pulse_ns != 0 && (pulse_ns < config->pulse_min_ns || pulse_ns > config->pulse_max_ns)) {
		return -EINVAL;
	}
	return pwm_set_pulse_dt(&config->pwm, pulse_ns);
}

static int servo_pwm_init(const struct device *dev)
{
	const struct servo_pwm_config *config = dev->config;

	if (!device_is_ready(config->pwm.dev)) {
		return -ENODEV;
	}
	return servo_pwm_set_pulse(dev, 0);
}

static const struct servo_driver_api servo_pwm_api = {
	.set_pulse = servo_pwm_set_pulse,
};

#define SERVO_PWM_DEFINE(inst)                                                                     \
	BUILD_ASSERT(DT_INST_PROP(inst, pulse_min_us) > 0 &&                                       \
	                     DT_INST_PROP(inst, pulse_min_us) <                                    \
	                             DT_INST_PROP(inst, pulse_max_us) &&                           \
	                     DT_INST_PROP(inst, pulse_max_us) * 1000 < DT_INST_PWMS_PERIOD(inst),  \
	             "a servo's pulses are shorter than their period");                            \
	static const struct servo_pwm_config servo_pwm_config_##inst = {                           \
		.pwm = PWM_DT_SPEC_INST_GET(inst),                                                 \
		.pulse_min_ns = DT_INST_PROP(inst, pulse_min_us) * 1000u,                          \
		.pulse_max_ns = DT_INST_PROP(inst, pulse_max_us) * 1000u,                          \
	};                                                                                         \
	DEVICE_DT_INST_DEFINE(inst, servo_pwm_init, NULL, NULL, &servo_pwm_config_##inst,          \
	                      POST_KERNEL, CONFIG_PHAROS_DRIVERS_INIT_PRIORITY, &servo_pwm_api);

DT_INST_FOREACH_STATUS_OKAY(SERVO_PWM_DEFINE)
