/* SPDX-License-Identifier: Apache-2.0 */
/* The lines of models/lines.h as a GPIO controller. Interrupts come from the world's side only. */
#define DT_DRV_COMPAT pharos_gpio_native

#include <zephyr/device.h>
#include <zephyr/drivers/gpio.h>
#include <zephyr/irq.h>
#include <zephyr/sys/util.h>

#include <native/irq.h>

#include "devices/fault.h"
#include "host/clock.h"
#include "host/hardware.h"
#include "models/board.h"

#define SUPPORTED                                                                                  \
	(GPIO_ACTIVE_LOW | GPIO_PULL_UP | GPIO_PULL_DOWN | GPIO_INPUT | GPIO_OUTPUT |              \
	 GPIO_OUTPUT_INIT_LOW | GPIO_OUTPUT_INIT_HIGH)

struct gpio_native_data {
	struct gpio_driver_data common;
	uint32_t output;
	uint32_t level;
	uint32_t pull_up;
	uint32_t on_rise; /* lines whose interrupt that is */
	uint32_t on_fall;
	uint32_t pending;
	struct gpio_callback *callbacks;
	struct native_irq irq;
};

static struct gpio_native_data gpio_native_data;

static uint32_t with_bit(uint32_t mask, gpio_pin_t pin, bool set)
{
	return set ? mask | BIT(pin) : mask & ~BIT(pin);
}

static void write_lines(const struct gpio_native_data *data)
{
	board_lines_configure((int64_t)clock_board_us(), data->output, data->level, data->pull_up);
}

static int gpio_native_pin_configure(const struct device *port, gpio_pin_t pin, gpio_flags_t flags)
{
	struct gpio_native_data *data = port->data;
	const int fault = fault_pass(BOARD_CHIP_GPIO);
	unsigned int key;

	if (fault != 0) {
		return fault;
	}
	if (pin >= BOARD_LINE_COUNT) {
		return -EINVAL;
	}
	if ((flags & ~SUPPORTED) != 0) {
		return -ENOTSUP;
	}
	if (pin == BOARD_LINE_LAMP_ENABLE && !hardware_allows_light()) {
		return -EPERM;
	}
	key = irq_lock();
	data->output = with_bit(data->output, pin, (flags & GPIO_OUTPUT) != 0);
	data->pull_up = with_bit(data->pull_up, pin, (flags & GPIO_PULL_UP) != 0);
	if ((flags & (GPIO_OUTPUT_INIT_LOW | GPIO_OUTPUT_INIT_HIGH)) != 0) {
		data->level = with_bit(data->level, pin, (flags & GPIO_OUTPUT_INIT_HIGH) != 0);
	}
	write_lines(data);
	irq_unlock(key);
	return 0;
}

static int gpio_native_port_get_raw(const struct device *port, gpio_port_value_t *value)
{
	*value = board_lines_read();
	return fault_pass(BOARD_CHIP_GPIO);
}

static int gpio_native_port_set_masked_raw(const struct device *port, gpio_port_pins_t mask,
                                           gpio_port_value_t value)
{
	struct gpio_native_data *data = port->data;
	const int fault = fault_pass(BOARD_CHIP_GPIO);
	unsigned int key;

	if (fault != 0) {
		return fault;
	}
	if ((mask & ~BIT_MASK(BOARD_LINE_COUNT)) != 0) {
		return -EINVAL;
	}
	key = irq_lock();
	data->level = (data->level & ~mask) | (value & mask);
	write_lines(data);
	irq_unlock(key);
	return 0;
}

static void isr(void *arg)
{
	const struct device *port = arg;
	struct gpio_native_data *data = port->data;
	const uint32_t pins = data->pending;
	struct gpio_callback *next;

	data->pending = 0;
	/* a callback may remove itself */
	for (struct gpio_callback *cb = data->callbacks; cb != NULL; cb = next) {
		next = cb->next;
		if ((cb->pin_mask & pins) != 0) {
			cb->handler(port, cb, cb->pin_mask & pins);
		}
	}
}

static void raise_pins(uint32_t pins)
{
	struct gpio_native_data *data = &gpio_native_data;

	if (pins != 0) {
		data->pending |= pins;
		native_irq_raise(&data->irq);
	}
}

static void lines_interrupt(uint32_t before, uint32_t after)
{
	const struct gpio_native_data *data = &gpio_native_data;

	raise_pins((~before & after & data->on_rise) | (before & ~after & data->on_fall));
}

static int gpio_native_pin_interrupt_configure(const struct device *port, gpio_pin_t pin,
                                               gpio_flags_t flags)
{
	struct gpio_native_data *data = port->data;
	const bool enable = (flags & GPIO_INT_ENABLE) != 0;
	const bool rise = enable && (flags & GPIO_INT_HIGH_1) != 0;
	const bool fall = enable && (flags & GPIO_INT_LOW_0) != 0;
	unsigned int key;

	if (pin >= BOARD_LINE_COUNT) {
		return -EINVAL;
	}
	key = irq_lock();
	data->on_rise = with_bit(data->on_rise, pin, rise);
	data->on_fall = with_bit(data->on_fall, pin, fall);
	data->pending &= ~BIT(pin);
	if (enable && (flags & GPIO_INT_EDGE) == 0) {
		const bool high = (board_lines_read() & BIT(pin)) != 0;

		raise_pins(high == rise ? BIT(pin) : 0);
	}
	irq_unlock(key);
	return 0;
}

static int gpio_native_manage_callback(const struct device *port, struct gpio_callback *cb,
                                       bool set)
{
	struct gpio_native_data *data = port->data;
	const unsigned int key = irq_lock();
	struct gpio_callback **link = &data->callbacks;
	bool found;

	while (*link != NULL && *link != cb) {
		link = &(*link)->next;
	}
	found = *link != NULL;
	if (found) {
		*link = cb->next;
	}
	if (set) {
		cb->next = data->callbacks;
		data->callbacks = cb;
	}
	irq_unlock(key);
	return set || found ? 0 : -EINVAL;
}

static int gpio_native_init(const struct device *port)
{
	struct gpio_native_data *data = port->data;

	data->irq.isr = isr;
	data->irq.arg = (void *)port;
	board_lines_interrupt = lines_interrupt;
	return fault_start(BOARD_CHIP_GPIO);
}

static const struct gpio_driver_api gpio_native_api = {
	.pin_configure = gpio_native_pin_configure,
	.port_get_raw = gpio_native_port_get_raw,
	.port_set_masked_raw = gpio_native_port_set_masked_raw,
	.pin_interrupt_configure = gpio_native_pin_interrupt_configure,
	.manage_callback = gpio_native_manage_callback,
};

BUILD_ASSERT(DT_NUM_INST_STATUS_OKAY(DT_DRV_COMPAT) == 1, "the board has one GPIO controller");
BUILD_ASSERT(DT_INST_PROP(0, ngpios) == BOARD_LINE_COUNT, "as models/board.h says");

DEVICE_DT_INST_DEFINE(0, gpio_native_init, NULL, &gpio_native_data, NULL, PRE_KERNEL_1, 40,
                      &gpio_native_api);
