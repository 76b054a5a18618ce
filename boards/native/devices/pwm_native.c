/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_pwm_native

#include <zephyr/device.h>
#include <zephyr/drivers/pwm.h>
#include <zephyr/sys/util.h>
#include <zephyr/toolchain.h>

#include "devices/fault.h"
#include "host/clock.h"
#include "models/board.h"

struct pwm_native_config {
	uint32_t hz;
};

/* A real output that has gone. */
static bool is_away(uint32_t channel)
{
	return channel < BOARD_PWM_COUNT && (board_pwm_away & BIT(channel)) != 0;
}

static int pwm_native_set_cycles(const struct device *dev, uint32_t channel, uint32_t period,
                                 uint32_t pulse, pwm_flags_t flags)
{
	const struct pwm_native_config *config = dev->config;

	const int fault = fault_pass(BOARD_CHIP_PWM);

	if (fault != 0) {
		return fault;
	}
	if (is_away(channel) && channel == BOARD_PWM_LAMP) {
		return -ENODEV;
	}
	if ((flags & ~PWM_POLARITY_INVERTED) != 0) {
		return -ENOTSUP;
	}
	if (period == 0) {
		return -EINVAL;
	}
	if ((flags & PWM_POLARITY_INVERTED) != 0) {
		pulse = period - pulse;
	}
	if (board_pwm_set((int64_t)clock_board_us(), channel, period, pulse, config->hz) != 0) {
		return -EINVAL;
	}
	/* what it is to be is kept for when it is back */
	return is_away(channel) ? -ENODEV : 0;
}

static int pwm_native_get_cycles_per_sec(const struct device *dev, uint32_t channel,
                                         uint64_t *cycles)
{
	const struct pwm_native_config *config = dev->config;

	if (channel >= BOARD_PWM_COUNT) {
		return -EINVAL;
	}
	*cycles = config->hz;
	/* the others' pulses are to be told, to be kept */
	return is_away(channel) && channel == BOARD_PWM_LAMP ? -ENODEV : 0;
}

static int pwm_native_init(const struct device *dev)
{
	return fault_start(BOARD_CHIP_PWM);
}

static const struct pwm_driver_api pwm_native_api = {
	.set_cycles = pwm_native_set_cycles,
	.get_cycles_per_sec = pwm_native_get_cycles_per_sec,
};

#define PWM_NATIVE_DEFINE(inst)                                                                    \
	BUILD_ASSERT(DT_INST_PROP(inst, channels) == BOARD_PWM_COUNT, "as models/board.h says");   \
	static const struct pwm_native_config pwm_native_config_##inst = {                         \
		.hz = DT_INST_PROP(inst, clock_frequency),                                         \
	};                                                                                         \
	DEVICE_DT_INST_DEFINE(inst, pwm_native_init, NULL, NULL, &pwm_native_config_##inst,        \
	                      POST_KERNEL, 40, &pwm_native_api);

DT_INST_FOREACH_STATUS_OKAY(PWM_NATIVE_DEFINE)
