/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hobby servo: the length of a repeated pulse is the position it goes to. After a reset there are
 * no pulses, so that it moves nowhere until the first servo_set_pulse().
 *
 * Any context; never blocks. 0 or -errno: -EINVAL: outside the limits in the devicetree, nothing
 * changed; or what the PWM driver gave.
 */
#ifndef PHAROS_DRIVERS_SERVO_H_
#define PHAROS_DRIVERS_SERVO_H_

#include <stdint.h>

#include <zephyr/device.h>

struct servo_driver_api {
	int (*set_pulse)(const struct device *dev, uint32_t pulse_ns);
};

/* pulse_ns 0: no pulses, which lets go of the servo. */
static inline int servo_set_pulse(const struct device *dev, uint32_t pulse_ns)
{
	return ((const struct servo_driver_api *)dev->api)->set_pulse(dev, pulse_ns);
}

#endif
