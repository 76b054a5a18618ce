/* SPDX-License-Identifier: Apache-2.0 */
/* The GPIO device: Zephyr's semantics of active-low, initial levels, and interrupts. */
#include <zephyr/devicetree.h>
#include <zephyr/drivers/gpio.h>
#include <zephyr/kernel.h>
#include <zephyr/ztest.h>

#include "host/clock.h"
#include "models/board.h"

static const struct device *const port = DEVICE_DT_GET(DT_NODELABEL(gpio0));
static const struct gpio_dt_spec button = GPIO_DT_SPEC_GET(DT_ALIAS(button0), gpios);

#define LINE BOARD_LINE_OUT0

static struct gpio_callback callback;
static int calls;
static gpio_port_pins_t called_pins;
static int level_in_call;
static bool in_isr;

static void called(const struct device *dev, struct gpio_callback *cb, gpio_port_pins_t pins)
{
	zassert_equal_ptr(dev, port);
	zassert_equal_ptr(cb, &callback);
	calls++;
	called_pins = pins;
	level_in_call = gpio_pin_get_raw(port, LINE);
	in_isr = k_is_in_isr();
}

static void drive(uint32_t line, bool level)
{
	board_line_drive((int64_t)clock_board_us(), line, level);
}

static void before(void *fixture)
{
	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_DISABLE));
	(void)gpio_remove_callback(port, &callback);
	drive(LINE, false);
	zassert_ok(gpio_pin_configure(port, LINE, GPIO_INPUT));
	gpio_init_callback(&callback, called, BIT(LINE));
	zassert_ok(gpio_add_callback(port, &callback));
	calls = 0;
}

ZTEST(gpio, test_input_is_logical)
{
	board_line_release((int64_t)clock_board_us(), BOARD_LINE_BUTTON);
	zassert_ok(gpio_pin_configure_dt(&button, GPIO_INPUT));
	zassert_equal(gpio_pin_get_raw(port, button.pin), 1, "pulled up");
	zassert_equal(gpio_pin_get_dt(&button), 0);
	drive(BOARD_LINE_BUTTON, false);
	zassert_equal(gpio_pin_get_dt(&button), 1);
}

ZTEST(gpio, test_output_is_logical)
{
	zassert_ok(gpio_pin_configure(port, LINE, GPIO_OUTPUT_INACTIVE | GPIO_ACTIVE_LOW));
	zassert_equal(gpio_pin_get_raw(port, LINE), 1);
	zassert_ok(gpio_pin_set(port, LINE, 1));
	zassert_equal(gpio_pin_get_raw(port, LINE), 0);
	zassert_ok(gpio_pin_set_raw(port, LINE, 1));
	zassert_equal(gpio_pin_get(port, LINE), 0);
	zassert_ok(gpio_pin_toggle(port, LINE));
	zassert_equal(gpio_pin_get(port, LINE), 1);
	zassert_ok(gpio_pin_configure(port, LINE, GPIO_OUTPUT_HIGH | GPIO_ACTIVE_LOW));
	zassert_equal(gpio_pin_get_raw(port, LINE), 1, "HIGH is physical");
}

ZTEST(gpio, test_wrong_pins_and_flags_are_refused)
{
	zassert_equal(gpio_pin_configure(port, BOARD_LINE_COUNT, GPIO_INPUT), -EINVAL);
	zassert_equal(gpio_pin_configure(port, 40, GPIO_INPUT), -EINVAL);
	zassert_equal(gpio_pin_configure(port, LINE, GPIO_INPUT | GPIO_OUTPUT_INIT_LOW), -EINVAL);
	zassert_equal(gpio_pin_configure(port, LINE, GPIO_INPUT | GPIO_PULL_UP | GPIO_PULL_DOWN),
	              -EINVAL);
	zassert_equal(gpio_pin_set(port, 40, 1), -EINVAL);
	zassert_equal(gpio_pin_get(port, 40), -EINVAL);
	zassert_equal(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_ENABLE), -EINVAL);
	zassert_equal(gpio_remove_callback(port, &callback), 0);
	zassert_equal(gpio_remove_callback(port, &callback), -EINVAL);
}

ZTEST(gpio, test_edges)
{
	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_EDGE_BOTH));
	drive(LINE, true);
	zassert_equal(calls, 1);
	zassert_equal(called_pins, BIT(LINE));
	zassert_equal(level_in_call, 1);
	zassert_true(in_isr);
	drive(LINE, true);
	zassert_equal(calls, 1, "no edge");
	drive(LINE, false);
	zassert_equal(calls, 2);
	zassert_equal(level_in_call, 0);

	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_EDGE_RISING));
	drive(LINE, true);
	zassert_equal(calls, 3);
	drive(LINE, false);
	zassert_equal(calls, 3);

	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_EDGE_FALLING));
	drive(LINE, true);
	zassert_equal(calls, 3);
	drive(LINE, false);
	zassert_equal(calls, 4);

	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_DISABLE));
	drive(LINE, true);
	zassert_equal(calls, 4);
}

ZTEST(gpio, test_edge_to_active_of_an_active_low_line)
{
	drive(LINE, true);
	zassert_ok(gpio_pin_configure(port, LINE, GPIO_INPUT | GPIO_ACTIVE_LOW));
	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_EDGE_TO_ACTIVE));
	drive(LINE, false);
	zassert_equal(calls, 1);
	drive(LINE, true);
	zassert_equal(calls, 1);
}

ZTEST(gpio, test_level)
{
	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_LEVEL_HIGH));
	zassert_equal(calls, 0);
	drive(LINE, true);
	zassert_equal(calls, 1);
	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_LEVEL_HIGH));
	zassert_equal(calls, 2, "it is at the level already");
}

ZTEST(gpio, test_edges_while_locked_come_once_and_afterwards)
{
	unsigned int key;

	zassert_ok(gpio_pin_interrupt_configure(port, LINE, GPIO_INT_EDGE_BOTH));
	key = irq_lock();
	drive(LINE, true);
	drive(LINE, false);
	drive(LINE, true);
	zassert_equal(calls, 0);
	irq_unlock(key);
	zassert_equal(calls, 1);
	zassert_equal(level_in_call, 1);
}

ZTEST_SUITE(gpio, NULL, NULL, before, NULL, NULL);
