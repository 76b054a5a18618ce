/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PWM outputs, by Zephyr's names. Periods and pulses are in nanoseconds, or in cycles of the
 * controller's clock. All calls: any context; 0 or -errno (-EINVAL: no such channel, pulse >
 * period; -ENOTSUP: flags or a time that the clock cannot count).
 */
#ifndef ZEPHYR_DRIVERS_PWM_H_
#define ZEPHYR_DRIVERS_PWM_H_

#include <errno.h>
#include <stdint.h>

#include <zephyr/device.h>
#include <zephyr/dt-bindings/pwm/pwm.h>

typedef uint16_t pwm_flags_t;

struct pwm_driver_api {
	int (*set_cycles)(const struct device *dev, uint32_t channel, uint32_t period_cycles,
	                  uint32_t pulse_cycles, pwm_flags_t flags);
	int (*get_cycles_per_sec)(const struct device *dev, uint32_t channel, uint64_t *cycles);
};

struct pwm_dt_spec {
	const struct device *dev;
	uint32_t channel;
	uint32_t period; /* ns */
	pwm_flags_t flags;
};

#define PWM_DT_SPEC_GET_BY_IDX(node_id, idx)                                                       \
	{                                                                                          \
		.dev = DEVICE_DT_GET(DT_PWMS_CTLR_BY_IDX(node_id, idx)),                           \
		.channel = DT_PWMS_CHANNEL_BY_IDX(node_id, idx),                                   \
		.period = DT_PWMS_PERIOD_BY_IDX(node_id, idx),                                     \
		.flags = DT_PWMS_FLAGS_BY_IDX(node_id, idx),                                       \
	}
#define PWM_DT_SPEC_GET(node_id)               PWM_DT_SPEC_GET_BY_IDX(node_id, 0)
#define PWM_DT_SPEC_INST_GET_BY_IDX(inst, idx) PWM_DT_SPEC_GET_BY_IDX(DT_DRV_INST(inst), idx)
#define PWM_DT_SPEC_INST_GET(inst)             PWM_DT_SPEC_GET_BY_IDX(DT_DRV_INST(inst), 0)

/* A period of 0 is -EINVAL; a pulse of 0 is constantly inactive, a pulse of the period constantly
 * active. */
static inline int pwm_set_cycles(const struct device *dev, uint32_t channel, uint32_t period,
                                 uint32_t pulse, pwm_flags_t flags)
{
	const struct pwm_driver_api *api = dev->api;

	if (pulse > period) {
		return -EINVAL;
	}
	return api->set_cycles(dev, channel, period, pulse, flags);
}

static inline int pwm_get_cycles_per_sec(const struct device *dev, uint32_t channel,
                                         uint64_t *cycles)
{
	const struct pwm_driver_api *api = dev->api;

	return api->get_cycles_per_sec(dev, channel, cycles);
}

static inline int pwm_set(const struct device *dev, uint32_t channel, uint32_t period,
                          uint32_t pulse, pwm_flags_t flags)
{
	uint64_t hz;
	const int rc = pwm_get_cycles_per_sec(dev, channel, &hz);

	if (rc != 0) {
		return rc;
	}

	const uint64_t period_cycles = (period * hz) / 1000000000u;
	const uint64_t pulse_cycles = (pulse * hz) / 1000000000u;

	if (period_cycles > UINT32_MAX || pulse_cycles > UINT32_MAX) {
		return -ENOTSUP;
	}
	return pwm_set_cycles(dev, channel, (uint32_t)period_cycles, (uint32_t)pulse_cycles, flags);
}

static inline int pwm_set_dt(const struct pwm_dt_spec *spec, uint32_t period, uint32_t pulse)
{
	return pwm_set(spec->dev, spec->channel, period, pulse, spec->flags);
}

static inline int pwm_set_pulse_dt(const struct pwm_dt_spec *spec, uint32_t pulse)
{
	return pwm_set(spec->dev, spec->channel, spec->period, pulse, spec->flags);
}

#endif
