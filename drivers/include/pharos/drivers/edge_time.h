/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When an input last changed, for a GPIO controller whose interrupts come later than its edges (a
 * host's chip: the kernel takes the time, the process hears of it later). It exists where the
 * devicetree has a "pharos,edge-time" node (alias edge-time0); elsewhere the device is NULL
 * (DEVICE_DT_GET_OR_NULL), and an edge is as old as its interrupt.
 */
#ifndef PHAROS_DRIVERS_EDGE_TIME_H_
#define PHAROS_DRIVERS_EDGE_TIME_H_

#include <stdint.h>

#include <zephyr/device.h>
#include <zephyr/drivers/gpio.h>
#include <zephyr/kernel.h>

struct edge_time_driver_api {
	int64_t (*get_us)(const struct device *dev, const struct gpio_dt_spec *input);
};

/* Uptime in us of the last edge of input, never later than now. Any context. dev may be NULL. */
static inline int64_t edge_time_us(const struct device *dev, const struct gpio_dt_spec *input)
{
	if (dev == NULL) {
		return (int64_t)k_ticks_to_us_floor64((uint64_t)k_uptime_ticks());
	}
	return ((const struct edge_time_driver_api *)dev->api)->get_us(dev, input);
}

#endif
