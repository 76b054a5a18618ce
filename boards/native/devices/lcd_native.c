/* SPDX-License-Identifier: Apache-2.0 */
/* The display of models/board.h as an auxiliary display. */
#define DT_DRV_COMPAT pharos_lcd_native

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/drivers/auxdisplay.h>
#include <zephyr/toolchain.h>

#include "models/board.h"

static int lcd_native_on(const struct device *dev)
{
	board.lcd.on = true;
	return 0;
}

static int lcd_native_off(const struct device *dev)
{
	board.lcd.on = false;
	return 0;
}

static int lcd_native_clear(const struct device *dev)
{
	lcd_clear(&board.lcd);
	return 0;
}

static int lcd_native_move(const struct device *dev, enum auxdisplay_position type, int16_t x,
                           int16_t y)
{
	if (type != AUXDISPLAY_POSITION_ABSOLUTE) {
		return -EINVAL;
	}
	return lcd_move(&board.lcd, x, y) ? 0 : -EINVAL;
}

static int lcd_native_write(const struct device *dev, const uint8_t *data, uint16_t length)
{
	lcd_write(&board.lcd, data, length);
	return 0;
}

static int lcd_native_init(const struct device *dev)
{
	return 0;
}

static const struct auxdisplay_driver_api lcd_native_api = {
	.display_on = lcd_native_on,
	.display_off = lcd_native_off,
	.cursor_position_set = lcd_native_move,
	.clear = lcd_native_clear,
	.write = lcd_native_write,
};

#define LCD_NATIVE_DEFINE(inst)                                                                    \
	DEVICE_DT_INST_DEFINE(inst, lcd_native_init, NULL, NULL, NULL, POST_KERNEL, 40,            \
	                      &lcd_native_api);

DT_INST_FOREACH_STATUS_OKAY(LCD_NATIVE_DEFINE)
