/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_light_pwm

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/drivers/gpio.h>
#include <zephyr/drivers/pwm.h>
#include <zephyr/irq.h>
#include <zephyr/spinlock.h>
#include <zephyr/sys/util.h>

#include <pharos/drivers/light.h>
#include <pharos/drivers/probe.h>

#include "pulse.h"

/* 2 kHz: faster than eyes and rolling shutters see */
#define PERIOD_MAX_NS 500000u

#define OUTPUT_UNKNOWN UINT32_MAX

struct light_pwm_config {
	struct pwm_dt_spec pwm;
	struct gpio_dt_spec enable; /* port NULL: there is none */
};

struct light_pwm_data {
	struct k_spinlock lock;
	struct light_state state;
	uint32_t output_ppm;    /* as written; OUTPUT_UNKNOWN after an error */
	uint32_t period_cycles; /* 0: not initialised */
};

/* A simulated board's; NULL elsewhere. */
static const struct device *const probe = DEVICE_DT_GET_OR_NULL(DT_ALIAS(probe0));

/* 0, or the first error; *dark: the lamp is dark nonetheless. */
static int write_dark(const struct device *dev, bool *dark)
{
	const struct light_pwm_config *config = dev->config;
	const struct light_pwm_data *data = dev->data;
	int enable_rc = 0;
	int pwm_rc;

	/* The enable line acts at once, the PWM with its next period; both, as one may fail. */
	if (config->enable.port != NULL) {
		enable_rc = gpio_pin_set_dt(&config->enable, 0);
	}
	pwm_rc = pwm_set_cycles(config->pwm.dev, config->pwm.channel, data->period_cycles, 0,
	                        config->pwm.flags);
	*dark = pwm_rc == 0 || (config->enable.port != NULL && enable_rc == 0);
	return enable_rc != 0 ? enable_rc : pwm_rc;
}

static int write_lit(const struct device *dev, uint32_t output_ppm)
{
	const struct light_pwm_config *config = dev->config;
	const struct light_pwm_data *data = dev->data;
	const uint32_t pulse = light_pulse(output_ppm, data->period_cycles);
	int rc = pwm_set_cycles(config->pwm.dev, config->pwm.channel, data->period_cycles, pulse,
	                        config->pwm.flags);

	if (rc == 0 && config->enable.port != NULL) {
		rc = gpio_pin_set_dt(&config->enable, 1);
	}
	return rc;
}

/* The one place that decides what the lamp does. With the lock, or interrupts locked. */
static int apply(const struct device *dev)
{
	struct light_pwm_data *data = dev->data;
	struct light_state *state = &data->state;
	const uint32_t output_ppm =
		state->gate && !state->off ? MIN(state->level_ppm, state->limit_ppm) : 0;
	bool dark = true;
	int rc;

	if (data->period_cycles == 0) {
		return -EIO;
	}
	if (output_ppm == data->output_ppm) {
		return 0;
	}
	/* after an error both must have been dark before one may be lit */
	rc = output_ppm == 0 || data->output_ppm == OUTPUT_UNKNOWN ? write_dark(dev, &dark) : 0;
	if (rc == 0 && output_ppm != 0) {
		rc = write_lit(dev, output_ppm);
		if (rc != 0) {
			(void)write_dark(dev, &dark);
		}
	}
	data->output_ppm = rc == 0 ? output_ppm : OUTPUT_UNKNOWN;
	state->stuck = !dark;
	state->error = rc;
	state->errors += rc != 0 ? 1 : 0;
	return rc;
}

static int light_pwm_set_level(const struct device *dev, uint32_t level_ppm)
{
	struct light_pwm_data *data = dev->data;
	k_spinlock_key_t key;
	int rc;

	if (level_ppm > LIGHT_LEVEL_MAX_PPM) {
		return -EINVAL;
	}
	key = k_spin_lock(&data->lock);
	data->state.level_ppm = level_ppm;
	rc = apply(dev);
	probe_set(probe, PROBE_LEVEL_PPM, level_ppm);
	k_spin_unlock(&data->lock, key);
	return rc;
}

static int light_pwm_set_limit(const struct device *dev, uint32_t limit_ppm)
{
	const struct light_pwm_config *config = dev->config;
	struct light_pwm_data *data = dev->data;
	k_spinlock_key_t key;
	uint64_t hz;
	int rc;

	if (limit_ppm > LIGHT_LEVEL_MAX_PPM) {
		return -EINVAL;
	}
	key = k_spin_lock(&data->lock);
	data->state.limit_ppm = limit_ppm;
	/* Steady light is not written again. So, ten times a second, is the PWM still there? */
	if (pwm_get_cycles_per_sec(config->pwm.dev, config->pwm.channel, &hz) != 0) {
		data->output_ppm = OUTPUT_UNKNOWN;
	}
	rc = apply(dev);
	probe_set(probe, PROBE_LIMIT_PPM, limit_ppm);
	k_spin_unlock(&data->lock, key);
	return rc;
}

static int light_pwm_set_gate(const struct device *dev, bool open)
{
	struct light_pwm_data *data = dev->data;
	const k_spinlock_key_t key = k_spin_lock(&data->lock);
	int rc;

	data->state.gate = open;
	rc = apply(dev);
	probe_set(probe, PROBE_GATE, open);
	k_spin_unlock(&data->lock, key);
	return rc;
}

static void light_pwm_get(const struct device *dev, struct light_state *state)
{
	struct light_pwm_data *data = dev->data;
	const k_spinlock_key_t key = k_spin_lock(&data->lock);

	*state = data->state;
	/* after an error the driver has tried to make it dark */
	state->output_ppm = data->output_ppm == OUTPUT_UNKNOWN ? 0 : data->output_ppm;
	k_spin_unlock(&data->lock, key);
}

/* Not with the lock: the fault that it is called for may have come to who holds it. */
static int light_pwm_off_now(const struct device *dev)
{
	struct light_pwm_data *data = dev->data;
	const unsigned int key = irq_lock();
	int rc;

	data->state.off = true;
	/* written even if it is thought to be dark: a fault may have happened between the two */
	data->output_ppm = OUTPUT_UNKNOWN;
	rc = apply(dev);
	irq_unlock(key);
	return rc;
}

static int light_pwm_init(const struct device *dev)
{
	const struct light_pwm_config *config = dev->config;
	struct light_pwm_data *data = dev->data;
	uint64_t hz;
	uint64_t cycles;
	int rc;

	if (config->enable.port != NULL) {
		if (!device_is_ready(config->enable.port)) {
			return -ENODEV;
		}
		rc = gpio_pin_configure_dt(&config->enable, GPIO_OUTPUT_INACTIVE);
		if (rc != 0) {
			return rc;
		}
	}
	if (!device_is_ready(config->pwm.dev)) {
		return -ENODEV;
	}
	rc = pwm_get_cycles_per_sec(config->pwm.dev, config->pwm.channel, &hz);
	if (rc != 0) {
		return rc;
	}
	cycles = (hz * config->pwm.period) / 1000000000u;
	if (cycles == 0 || cycles > UINT32_MAX) {
		return -ENOTSUP;
	}
	data->period_cycles = (uint32_t)cycles;
	data->output_ppm = OUTPUT_UNKNOWN;
	return apply(dev);
}

static const struct light_driver_api light_pwm_api = {
	.set_level = light_pwm_set_level,
	.set_limit = light_pwm_set_limit,
	.set_gate = light_pwm_set_gate,
	.get = light_pwm_get,
	.off_now = light_pwm_off_now,
};

/*
 * The driver's calls come from interrupts as well, and so must the PWM's: these wait for a mutex or
 * a bus (as of Zephyr 4.2).
 */
#define PWM_MAY_WAIT(node)                                                                         \
	(DT_NODE_HAS_COMPAT(node, nxp_imx_pwm) || DT_NODE_HAS_COMPAT(node, nxp_qtmr_pwm) ||        \
	 DT_NODE_HAS_COMPAT(node, espressif_esp32_ledc) ||                                         \
	 DT_NODE_HAS_COMPAT(node, espressif_esp32_mcpwm) ||                                        \
	 DT_NODE_HAS_COMPAT(node, nxp_pca9685_pwm) ||                                              \
	 DT_NODE_HAS_COMPAT(node, maxim_max31790_pwm) || DT_NODE_HAS_COMPAT(node, ite_it8801_pwm))

#define LIGHT_PWM_DEFINE(inst)                                                                     \
	BUILD_ASSERT(DT_INST_PWMS_PERIOD(inst) > 0 && DT_INST_PWMS_PERIOD(inst) <= PERIOD_MAX_NS,  \
	             "the PWM period of a light must be at most 500 us");                          \
	BUILD_ASSERT(!PWM_MAY_WAIT(DT_PWMS_CTLR(DT_DRV_INST(inst))),                               \
	             "this PWM's driver cannot be called from an interrupt");                      \
	static struct light_pwm_data light_pwm_data_##inst;                                        \
	static const struct light_pwm_config light_pwm_config_##inst = {                           \
		.pwm = PWM_DT_SPEC_INST_GET(inst),                                                 \
		.enable = GPIO_DT_SPEC_INST_GET_OR(inst, enable_gpios, {0}),                       \
	};                                                                                         \
	DEVICE_DT_INST_DEFINE(inst, light_pwm_init, NULL, &light_pwm_data_##inst,                  \
	                      &light_pwm_config_##inst, POST_KERNEL,                               \
	                      CONFIG_PHAROS_DRIVERS_INIT_PRIORITY, &light_pwm_api);

DT_INST_FOREACH_STATUS_OKAY(LIGHT_PWM_DEFINE)
