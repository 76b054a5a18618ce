/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Watchdog, by Zephyr's names: install time-outs, set up, then feed each channel before its
 * window's max. A bite resets the board, the lamp dark first (the callback runs before, in
 * interrupt context). Any context. 0 (install: the channel) or -errno (-EBUSY: set up already;
 * -EINVAL: bad window or channel; -ENOMEM: no channel left; -ENOTSUP: a window's min, a flag or an
 * option that the controller lacks; -EFAULT: disabling one that isn't set up).
 */
#ifndef ZEPHYR_DRIVERS_WATCHDOG_H_
#define ZEPHYR_DRIVERS_WATCHDOG_H_

#include <stdint.h>

#include <zephyr/device.h>

#define WDT_OPT_PAUSE_IN_SLEEP      (1u << 0)
#define WDT_OPT_PAUSE_HALTED_BY_DBG (1u << 1)

#define WDT_FLAG_RESET_NONE     0u
#define WDT_FLAG_RESET_CPU_CORE 1u
#define WDT_FLAG_RESET_SOC      2u

struct wdt_window {
	uint32_t min; /* ms */
	uint32_t max; /* ms */
};

typedef void (*wdt_callback_t)(const struct device *dev, int channel_id);

struct wdt_timeout_cfg {
	struct wdt_window window;
	wdt_callback_t callback;
	uint8_t flags;
};

struct wdt_driver_api {
	int (*setup)(const struct device *dev, uint8_t options);
	int (*disable)(const struct device *dev);
	int (*install_timeout)(const struct device *dev, const struct wdt_timeout_cfg *cfg);
	int (*feed)(const struct device *dev, int channel_id);
};

static inline int wdt_setup(const struct device *dev, uint8_t options)
{
	return ((const struct wdt_driver_api *)dev->api)->setup(dev, options);
}

static inline int wdt_disable(const struct device *dev)
{
	return ((const struct wdt_driver_api *)dev->api)->disable(dev);
}

static inline int wdt_install_timeout(const struct device *dev, const struct wdt_timeout_cfg *cfg)
{
	return ((const struct wdt_driver_api *)dev->api)->install_timeout(dev, cfg);
}

static inline int wdt_feed(const struct device *dev, int channel_id)
{
	return ((const struct wdt_driver_api *)dev->api)->feed(dev, channel_id);
}

#endif
