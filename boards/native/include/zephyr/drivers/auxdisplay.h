/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Text displays, by Zephyr's names: on, off, clear, where to write, and writing. Thread context. 0
 * or -errno (-ENOSYS: the driver lacks it; -EINVAL: beyond the display, or a position that the
 * driver doesn't know).
 */
#ifndef ZEPHYR_DRIVERS_AUXDISPLAY_H_
#define ZEPHYR_DRIVERS_AUXDISPLAY_H_

#include <errno.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/device.h>

enum auxdisplay_position {
	AUXDISPLAY_POSITION_ABSOLUTE = 0,
};

struct auxdisplay_driver_api {
	int (*display_on)(const struct device *dev);
	int (*display_off)(const struct device *dev);
	int (*cursor_position_set)(const struct device *dev, enum auxdisplay_position type,
	                           int16_t x, int16_t y);
	int (*clear)(const struct device *dev);
	int (*write)(const struct device *dev, const uint8_t *data, uint16_t len);
};

static inline int auxdisplay_display_on(const struct device *dev)
{
	const struct auxdisplay_driver_api *api = dev->api;

	return api->display_on == NULL ? -ENOSYS : api->display_on(dev);
}

static inline int auxdisplay_display_off(const struct device *dev)
{
	const struct auxdisplay_driver_api *api = dev->api;

	return api->display_off == NULL ? -ENOSYS : api->display_off(dev);
}

static inline int auxdisplay_cursor_position_set(const struct device *dev,
                                                 enum auxdisplay_position type, int16_t x,
                                                 int16_t y)
{
	const struct auxdisplay_driver_api *api = dev->api;

	return api->cursor_position_set == NULL ? -ENOSYS
	                                        : api->cursor_position_set(dev, type, x, y);
}

static inline int auxdisplay_clear(const struct device *dev)
{
	const struct auxdisplay_driver_api *api = dev->api;

	return api->clear == NULL ? -ENOSYS : api->clear(dev);
}

static inline int auxdisplay_write(const struct device *dev, const uint8_t *data, uint16_t len)
{
	const struct auxdisplay_driver_api *api = dev->api;

	return api->write(dev, data, len);
}

#endif
