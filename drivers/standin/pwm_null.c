/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_pwm_null

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/drivers/pwm.h>

#include <pharos/compat.h>

struct pwm_null_config {
	uint32_t clock_hz;
};

static int pwm_null_set_cycles(const struct device *dev, uint32_t channel, uint32_t period_cycles,
                               uint32_t pulse_cycles, pwm_flags_t flags)
{
	return pulse_cycles <= period_cycles ? 0 : -EINVAL;
}

static int pwm_null_get_cycles_per_sec(const struct device *dev, uint32_t channel, uint64_t *cycles)
{
	const struct pwm_null_config *config = dev->config;

	*cycles = config->clock_hz;
	return 0;
}

static DEVICE_API(pwm, pwm_null_api) = {
	.set_cycles = pwm_null_set_cycles,
	.get_cycles_per_sec = pwm_null_get_cycles_per_sec,
};

#define PWM_NULL_DEFINE(inst)                                                                      \
	static const struct pwm_null_config pwm_null_config_##inst = {                             \
		.clock_hz = DT_INST_PROP(inst, clock_frequency),                                   \
	};                                                                                         \
	DEVICE_DT_INST_DEFINE(inst, NULL, NULL, NULL, &pwm_null_config_##inst, POST_KERNEL,        \
	                      CONFIG_KERNEL_INIT_PRIORITY_DEVICE, &pwm_null_api);

DT_INST_FOREACH_STATUS_OKAY(PWM_NULL_DEFINE)
