/* SPDX-License-Identifier: Apache-2.0 */
/* Device model, devicetree macros, PWM and watchdog devices. Values are those of native.dts. */
#include <string.h>

#include <zephyr/device.h>
#include <zephyr/devicetree.h>
#include <zephyr/drivers/auxdisplay.h>
#include <zephyr/drivers/gpio.h>
#include <zephyr/drivers/pwm.h>
#include <zephyr/drivers/watchdog.h>
#include <zephyr/kernel.h>
#include <zephyr/ztest.h>

#include "models/board.h"

/* --- devicetree: decided when this is compiled --- */

BUILD_ASSERT(DT_NODE_EXISTS(DT_ALIAS(light0)));
BUILD_ASSERT(!DT_NODE_EXISTS(DT_ALIAS(no_such_alias)));
BUILD_ASSERT(DT_NODE_HAS_STATUS(DT_NODELABEL(pwm0), okay));
BUILD_ASSERT(!DT_NODE_HAS_STATUS(DT_NODELABEL(pwm0), disabled));
BUILD_ASSERT(!DT_NODE_HAS_STATUS(DT_NODELABEL(no_such_label), okay));
BUILD_ASSERT(DT_SAME_NODE(DT_ALIAS(light0), DT_NODELABEL(light0)));
BUILD_ASSERT(DT_SAME_NODE(DT_PARENT(DT_NODELABEL(sync_input)), DT_INST(0, pharos_input_lines)));
BUILD_ASSERT(DT_NODE_HAS_COMPAT(DT_NODELABEL(thermistor_ntc), pharos_thermistor_ntc));
BUILD_ASSERT(DT_HAS_CHOSEN(zephyr_shell_uart));
BUILD_ASSERT(!DT_HAS_CHOSEN(zephyr_flash));
BUILD_ASSERT(DT_NUM_INST_STATUS_OKAY(pharos_uart_host) == 5);
BUILD_ASSERT(DT_NUM_INST_STATUS_OKAY(no_such_compat) == 0);
BUILD_ASSERT(DT_PROP(DT_NODELABEL(thermistor_ntc), beta_kelvin) == 3435);
BUILD_ASSERT(DT_PROP_OR(DT_NODELABEL(thermistor_ntc), beta_kelvin, 1) == 3435);
BUILD_ASSERT(DT_PROP_OR(DT_NODELABEL(thermistor_ntc), no_such_prop, 42) == 42);
BUILD_ASSERT(DT_NODE_HAS_PROP(DT_ALIAS(light0), enable_gpios));
BUILD_ASSERT(!DT_NODE_HAS_PROP(DT_ALIAS(light0), no_such_prop));
BUILD_ASSERT(DT_PWMS_PERIOD(DT_ALIAS(light0)) == 500000);
BUILD_ASSERT(DT_GPIO_PIN(DT_ALIAS(button0), gpios) == 2);
BUILD_ASSERT(DT_GPIO_FLAGS(DT_ALIAS(button0), gpios) == (GPIO_ACTIVE_LOW | GPIO_PULL_UP));
BUILD_ASSERT(DT_IO_CHANNELS_INPUT(DT_NODELABEL(thermistor_ntc)) == 0);

#define COUNT_ONE(node_id) +1
BUILD_ASSERT((0 DT_FOREACH_STATUS_OKAY(pharos_uart_host, COUNT_ONE)) == 5);
BUILD_ASSERT((0 DT_FOREACH_STATUS_OKAY(no_such_compat, COUNT_ONE)) == 0);
BUILD_ASSERT((0 DT_FOREACH_CHILD(DT_INST(0, pharos_input_lines), COUNT_ONE)) == 5);

ZTEST(device, test_strings)
{
	zassert_equal(strcmp(DT_PROP(DT_NODELABEL(uart2), wire), "uart2"), 0);
	zassert_equal(strcmp(DT_NODE_PATH(DT_NODELABEL(sync_input)), "/inputs/sync"), 0);
	zassert_equal(strcmp(DT_NODE_FULL_NAME(DT_NODELABEL(light0)), "light"), 0);
}

/* --- device model --- */

static int init_order;
static int good_at;
static int bad_at;

static int good_init(const struct device *dev)
{
	good_at = ++init_order;
	return 0;
}

static int bad_init(const struct device *dev)
{
	bad_at = ++init_order;
	return -EIO;
}

/* defined in this order, initialised by priority */
DEVICE_DEFINE(test_bad, "bad", bad_init, NULL, NULL, NULL, APPLICATION, 20, NULL);
DEVICE_DEFINE(test_good, "good", good_init, NULL, &init_order, NULL, APPLICATION, 10, NULL);

ZTEST(device, test_priority_orders_init)
{
	zassert_equal(good_at, 1);
	zassert_equal(bad_at, 2);
}

ZTEST(device, test_failed_init_is_not_ready)
{
	zassert_true(device_is_ready(DEVICE_GET(test_good)));
	zassert_false(device_is_ready(DEVICE_GET(test_bad)));
	zassert_equal(DEVICE_GET(test_bad)->state->init_res, EIO);
	zassert_false(device_is_ready(NULL));
	zassert_equal_ptr(DEVICE_GET(test_good)->data, &init_order);
}

ZTEST(device, test_binding_by_name)
{
	zassert_equal_ptr(device_get_binding("good"), DEVICE_GET(test_good));
	zassert_is_null(device_get_binding("bad"), "it is not ready");
	zassert_is_null(device_get_binding("no such device"));
	zassert_equal_ptr(device_get_binding("light"), DEVICE_DT_GET(DT_ALIAS(light0)));
}

ZTEST(device, test_get_or_null)
{
	zassert_equal_ptr(DEVICE_DT_GET_OR_NULL(DT_NODELABEL(pwm0)),
	                  DEVICE_DT_GET(DT_NODELABEL(pwm0)));
	zassert_is_null(DEVICE_DT_GET_OR_NULL(DT_ALIAS(no_such_alias)));
	zassert_equal_ptr(DEVICE_DT_GET_ANY(pharos_pwm_native), DEVICE_DT_GET(DT_NODELABEL(pwm0)));
	zassert_is_null(DEVICE_DT_GET_ANY(no_such_compat));
}

/* --- PWM --- */

ZTEST(device, test_pwm_times_and_refusals)
{
	const struct device *const pwm = DEVICE_DT_GET(DT_NODELABEL(pwm0));
	const struct board_pwm *const servo = &board.pwm[BOARD_PWM_SERVO_PAN];

	zassert_ok(pwm_set(pwm, BOARD_PWM_SERVO_PAN, PWM_MSEC(20), PWM_USEC(1500), 0));
	zassert_equal(servo->period_ns, 20000000);
	zassert_equal(servo->pulse_ns, 1500000);
	zassert_ok(pwm_set(pwm, BOARD_PWM_SERVO_PAN, PWM_MSEC(20), PWM_USEC(1500),
	                   PWM_POLARITY_INVERTED));
	zassert_equal(servo->pulse_ns, 18500000);
	zassert_equal(pwm_set(pwm, BOARD_PWM_SERVO_PAN, 1000, 1001, 0), -EINVAL);
	zassert_equal(pwm_set(pwm, BOARD_PWM_COUNT, 1000, 500, 0), -EINVAL);
	zassert_equal(pwm_set_cycles(pwm, BOARD_PWM_SERVO_PAN, 0, 0, 0), -EINVAL);
	zassert_equal(pwm_set_cycles(pwm, BOARD_PWM_SERVO_PAN, 10, 5, 1u << 9), -ENOTSUP);
	/* 4 s at 2 GHz are more cycles than 32 bits hold */
	zassert_equal(pwm_set(pwm, BOARD_PWM_SERVO_PAN, 4000000000u, 0, 0), -ENOTSUP);
	zassert_equal(servo->pulse_ns, 18500000, "a refusal changes nothing");
}

/* --- watchdog; that it bites is a system test's business: it would reset this process --- */

ZTEST(device, test_watchdog_is_quiet_while_fed_and_when_disabled)
{
	const struct device *const wdt = DEVICE_DT_GET(DT_ALIAS(watchdog0));
	struct wdt_timeout_cfg config = {
		.window = {.max = 100},
		.flags = WDT_FLAG_RESET_SOC,
	};
	int channel;

	zassert_equal(wdt_feed(wdt, 0), -EINVAL);
	zassert_equal(wdt_disable(wdt), -EFAULT);
	config.window.max = 0;
	zassert_equal(wdt_install_timeout(wdt, &config), -EINVAL);
	config.window.max = 100;
	config.window.min = 1;
	zassert_equal(wdt_install_timeout(wdt, &config), -ENOTSUP);
	config.window.min = 0;
	channel = wdt_install_timeout(wdt, &config);
	zassert_equal(channel, 0);
	zassert_equal(wdt_setup(wdt, WDT_OPT_PAUSE_IN_SLEEP), -ENOTSUP);
	zassert_ok(wdt_setup(wdt, WDT_OPT_PAUSE_HALTED_BY_DBG));
	zassert_equal(wdt_setup(wdt, 0), -EBUSY);
	zassert_equal(wdt_install_timeout(wdt, &config), -EBUSY);
	zassert_equal(wdt_feed(wdt, 1), -EINVAL);
	for (int i = 0; i < 50; i++) {
		k_msleep(90);
		zassert_ok(wdt_feed(wdt, channel));
	}
	zassert_ok(wdt_disable(wdt));
	k_msleep(1000);
}

ZTEST(device, test_display_shows_what_is_written_where)
{
	const struct device *const lcd = DEVICE_DT_GET(DT_NODELABEL(lcd0));

	zassert_ok(auxdisplay_clear(lcd));
	zassert_ok(auxdisplay_display_on(lcd));
	zassert_true(board.lcd.on);
	zassert_ok(auxdisplay_cursor_position_set(lcd, AUXDISPLAY_POSITION_ABSOLUTE, 14, 1));
	zassert_ok(auxdisplay_write(lcd, (const uint8_t *)"abc", 3));
	zassert_mem_equal(board.lcd.text[1], "              ab", LCD_COLUMNS);
	zassert_mem_equal(board.lcd.text[0], "                ", LCD_COLUMNS);
	zassert_equal(auxdisplay_cursor_position_set(lcd, AUXDISPLAY_POSITION_ABSOLUTE, 0, 2),
	              -EINVAL);
	zassert_equal(auxdisplay_cursor_position_set(lcd, AUXDISPLAY_POSITION_ABSOLUTE, 16, 0),
	              -EINVAL);
	zassert_ok(auxdisplay_display_off(lcd));
	zassert_false(board.lcd.on);
}

ZTEST_SUITE(device, NULL, NULL, NULL, NULL, NULL);
