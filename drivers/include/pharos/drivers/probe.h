/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shows internal values to a simulated board, for its recording (--record) and its control socket.
 * It exists where the devicetree has a "pharos,probe" node (alias probe0); elsewhere the device is
 * NULL (DEVICE_DT_GET_OR_NULL) and nothing happens. Nothing can be read back: behaviour never
 * depends on it.
 */
#ifndef PHAROS_DRIVERS_PROBE_H_
#define PHAROS_DRIVERS_PROBE_H_

#include <stdint.h>

#include <zephyr/device.h>

enum probe_channel {
	/* by the light driver */
	PROBE_LEVEL_PPM,
	PROBE_LIMIT_PPM,
	PROBE_GATE,
	/* by the app: what was commanded, and what the supervisor thinks */
	PROBE_ENABLE,
	PROBE_MODE,
	PROBE_BRIGHTNESS_PPM,
	PROBE_STROBE_PERIOD_US,
	PROBE_STROBE_DUTY_PPM,
	PROBE_THERMAL_STATE,
	PROBE_TEMPERATURE_MDEGC, /* as measured */
	PROBE_COMMAND, /* a protocol's command number, each time that one is carried out */
	PROBE_COUNT,
};

struct probe_driver_api {
	void (*set)(const struct device *dev, enum probe_channel channel, int64_t value);
};

/* Any context. dev may be NULL. */
static inline void probe_set(const struct device *dev, enum probe_channel channel, int64_t value)
{
	if (dev != NULL) {
		((const struct probe_driver_api *)dev->api)->set(dev, channel, value);
	}
}

#endif
