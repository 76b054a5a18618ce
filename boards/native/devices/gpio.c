/* SPDX-License-Identifier: Apache-2.0 */
/* What is the same for every GPIO controller: logical levels over physical ones. */
#include <zephyr/drivers/gpio.h>
#include <zephyr/sys/util.h>

#define INIT_FLAGS (GPIO_OUTPUT_INIT_LOW | GPIO_OUTPUT_INIT_HIGH)

static const struct gpio_driver_api *api_of(const struct device *port)
{
	return port->api;
}

static bool inverted(const struct device *port, gpio_pin_t pin)
{
	const struct gpio_driver_data *data = port->data;

	return (data->invert & BIT(pin)) != 0;
}

int gpio_pin_configure(const struct device *port, gpio_pin_t pin, gpio_flags_t flags)
{
	struct gpio_driver_data *data = port->data;
	int rc;

	if (pin >= GPIO_MAX_PINS_PER_PORT || (flags & INIT_FLAGS) == INIT_FLAGS ||
	    ((flags & INIT_FLAGS) != 0 && (flags & GPIO_OUTPUT) == 0) ||
	    ((flags & GPIO_PULL_UP) != 0 && (flags & GPIO_PULL_DOWN) != 0)) {
		return -EINVAL;
	}
	if ((flags & GPIO_OUTPUT_INIT_LOGICAL) != 0 && (flags & GPIO_ACTIVE_LOW) != 0) {
		flags ^= INIT_FLAGS;
	}
	rc = api_of(port)->pin_configure(port, pin, flags & ~GPIO_OUTPUT_INIT_LOGICAL);
	if (rc == 0) {
		data->invert = (flags & GPIO_ACTIVE_LOW) != 0 ? data->invert | BIT(pin)
		                                              : data->invert & ~BIT(pin);
	}
	return rc;
}

int gpio_pin_interrupt_configure(const struct device *port, gpio_pin_t pin, gpio_flags_t flags)
{
	const gpio_flags_t levels = GPIO_INT_LOW_0 | GPIO_INT_HIGH_1;
	const bool enable = (flags & GPIO_INT_ENABLE) != 0;

	if (pin >= GPIO_MAX_PINS_PER_PORT || enable == ((flags & GPIO_INT_DISABLE) != 0) ||
	    (enable && (flags & levels) == 0) ||
	    ((flags & GPIO_INT_EDGE) == 0 && (flags & levels) == levels)) {
		return -EINVAL;
	}
	if ((flags & GPIO_INT_LEVELS_LOGICAL) != 0 && inverted(port, pin) &&
	    (flags & levels) != levels) {
		flags ^= levels;
	}
	return api_of(port)->pin_interrupt_configure(port, pin, flags & ~GPIO_INT_LEVELS_LOGICAL);
}

int gpio_pin_get_raw(const struct device *port, gpio_pin_t pin)
{
	gpio_port_value_t value = 0;
	const int rc =
		pin < GPIO_MAX_PINS_PER_PORT ? api_of(port)->port_get_raw(port, &value) : -EINVAL;

	return rc != 0 ? rc : (value & BIT(pin)) != 0;
}

int gpio_pin_get(const struct device *port, gpio_pin_t pin)
{
	const int level = gpio_pin_get_raw(port, pin);

	return level < 0 ? level : level != inverted(port, pin);
}

int gpio_pin_set_raw(const struct device *port, gpio_pin_t pin, int value)
{
	if (pin >= GPIO_MAX_PINS_PER_PORT) {
		return -EINVAL;
	}
	return api_of(port)->port_set_masked_raw(port, BIT(pin), value != 0 ? BIT(pin) : 0);
}

int gpio_pin_set(const struct device *port, gpio_pin_t pin, int value)
{
	if (pin >= GPIO_MAX_PINS_PER_PORT) {
		return -EINVAL;
	}
	return gpio_pin_set_raw(port, pin, (value != 0) != inverted(port, pin));
}

int gpio_pin_toggle(const struct device *port, gpio_pin_t pin)
{
	const int level = gpio_pin_get_raw(port, pin);

	return level < 0 ? level : gpio_pin_set_raw(port, pin, !level);
}
