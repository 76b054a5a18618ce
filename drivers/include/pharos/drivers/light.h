/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A lamp. Its output is linear in electrical power, and is always
 *
 *     gate ? min(level, limit) : 0
 *
 * computed in one place of the driver, whoever changed what. After a reset level and limit are 0
 * and the gate is closed: dark until level, limit and gate have all been set.
 *
 * All ratios in ppm: 0…1 000 000. Every function: any context, including interrupts; never blocks.
 * 0 or -errno: -EINVAL: out of range, nothing changed; -EIO or what the PWM or GPIO driver gave:
 * the wish is kept and tried again with the next call, and the lamp is as dark as could be made.
 * An enable line or a pulse of 0 suffices for that; a lamp on which neither has effect is stuck,
 * and only a reset, in which its pins float, is left.
 *
 * So a strobe's edge, a timer's interrupt, calls the drivers of the PWM and of the enable line:
 * pwm_set_cycles() and gpio_pin_set_dt(), with interrupts locked. Zephyr leaves to each driver
 * whether that is allowed. It is where it writes registers, as those of STM32, nRF, SAM, Gecko and
 * RP2 do; it is not where it waits for a mutex (i.MX, ESP32) or for a bus, as any expander's.
 * "pharos,light-pwm" refuses the PWMs known to wait, at build time.
 */
#ifndef PHAROS_DRIVERS_LIGHT_H_
#define PHAROS_DRIVERS_LIGHT_H_

#include <stdbool.h>
#include <stdint.h>

#include <zephyr/device.h>

#define LIGHT_LEVEL_MAX_PPM 1000000u

struct light_state {
	uint32_t level_ppm;  /* asked for */
	uint32_t limit_ppm;  /* allowed */
	uint32_t output_ppm; /* what the lamp does now */
	bool gate;
	bool off;        /* light_off_now() was called: dark until the next reset */
	bool stuck;      /* it may be lit, and could not be made dark */
	int error;       /* of the last write, -errno; 0: it had effect */
	uint32_t errors; /* writes that failed, since the reset */
};

struct light_driver_api {
	int (*set_level)(const struct device *dev, uint32_t level_ppm);
	int (*set_limit)(const struct device *dev, uint32_t limit_ppm);
	int (*set_gate)(const struct device *dev, bool open);
	void (*get)(const struct device *dev, struct light_state *state);
	int (*off_now)(const struct device *dev);
};

/* The level while the gate is open. */
static inline int light_set_level(const struct device *dev, uint32_t level_ppm)
{
	return ((const struct light_driver_api *)dev->api)->set_level(dev, level_ppm);
}

/* The highest output allowed, for the thermal supervisor. */
static inline int light_set_limit(const struct device *dev, uint32_t limit_ppm)
{
	return ((const struct light_driver_api *)dev->api)->set_limit(dev, limit_ppm);
}

/* Opens or closes the gate: a strobe's edge. */
static inline int light_set_gate(const struct device *dev, bool open)
{
	return ((const struct light_driver_api *)dev->api)->set_gate(dev, open);
}

static inline void light_get(const struct device *dev, struct light_state *state)
{
	((const struct light_driver_api *)dev->api)->get(dev, state);
}

/* For fault handlers and before a reset: dark at once, until the next reset whatever is asked. */
static inline int light_off_now(const struct device *dev)
{
	return ((const struct light_driver_api *)dev->api)->off_now(dev);
}

#endif
