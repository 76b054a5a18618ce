/* SPDX-License-Identifier: Apache-2.0 */
/*
 * GPIO lines, by Zephyr's names and values.
 *
 * gpio_pin_get/set/toggle() are logical (1 = active), the …_raw forms physical. Calls: any context;
 * 0 (or the level) or -errno (-EINVAL: no such line, contradicting flags; -ENOTSUP: a flag that the
 * controller lacks).
 *
 * Interrupts: callbacks run in interrupt context, with the lines of this interrupt as a mask. Edges
 * that come while interrupts are locked are reported once. A level interrupt is reported when the
 * line enters the level, and when it is at the level as the interrupt is configured; the native
 * board does not repeat it.
 */
#ifndef ZEPHYR_DRIVERS_GPIO_H_
#define ZEPHYR_DRIVERS_GPIO_H_

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>

#include <zephyr/device.h>
#include <zephyr/dt-bindings/gpio/gpio.h>

#define GPIO_INPUT               (1u << 16)
#define GPIO_OUTPUT              (1u << 17)
#define GPIO_DISCONNECTED        0u
#define GPIO_OUTPUT_INIT_LOW     (1u << 18)
#define GPIO_OUTPUT_INIT_HIGH    (1u << 19)
/* the initial level is meant logically */
#define GPIO_OUTPUT_INIT_LOGICAL (1u << 20)

#define GPIO_OUTPUT_LOW      (GPIO_OUTPUT | GPIO_OUTPUT_INIT_LOW)
#define GPIO_OUTPUT_HIGH     (GPIO_OUTPUT | GPIO_OUTPUT_INIT_HIGH)
#define GPIO_OUTPUT_INACTIVE (GPIO_OUTPUT | GPIO_OUTPUT_INIT_LOW | GPIO_OUTPUT_INIT_LOGICAL)
#define GPIO_OUTPUT_ACTIVE   (GPIO_OUTPUT | GPIO_OUTPUT_INIT_HIGH | GPIO_OUTPUT_INIT_LOGICAL)

#define GPIO_INT_DISABLE        (1u << 21)
#define GPIO_INT_ENABLE         (1u << 22)
#define GPIO_INT_LEVELS_LOGICAL (1u << 23)
#define GPIO_INT_EDGE           (1u << 24)
#define GPIO_INT_LOW_0          (1u << 25)
#define GPIO_INT_HIGH_1         (1u << 26)

#define GPIO_INT_EDGE_RISING      (GPIO_INT_ENABLE | GPIO_INT_EDGE | GPIO_INT_HIGH_1)
#define GPIO_INT_EDGE_FALLING     (GPIO_INT_ENABLE | GPIO_INT_EDGE | GPIO_INT_LOW_0)
#define GPIO_INT_EDGE_BOTH        (GPIO_INT_ENABLE | GPIO_INT_EDGE | GPIO_INT_LOW_0 | GPIO_INT_HIGH_1)
#define GPIO_INT_LEVEL_LOW        (GPIO_INT_ENABLE | GPIO_INT_LOW_0)
#define GPIO_INT_LEVEL_HIGH       (GPIO_INT_ENABLE | GPIO_INT_HIGH_1)
#define GPIO_INT_EDGE_TO_INACTIVE (GPIO_INT_EDGE_FALLING | GPIO_INT_LEVELS_LOGICAL)
#define GPIO_INT_EDGE_TO_ACTIVE   (GPIO_INT_EDGE_RISING | GPIO_INT_LEVELS_LOGICAL)
#define GPIO_INT_LEVEL_INACTIVE   (GPIO_INT_LEVEL_LOW | GPIO_INT_LEVELS_LOGICAL)
#define GPIO_INT_LEVEL_ACTIVE     (GPIO_INT_LEVEL_HIGH | GPIO_INT_LEVELS_LOGICAL)

#define GPIO_MAX_PINS_PER_PORT 32

typedef uint8_t gpio_pin_t;
typedef uint16_t gpio_dt_flags_t;
typedef uint32_t gpio_flags_t;
typedef uint32_t gpio_port_pins_t;
typedef uint32_t gpio_port_value_t;

struct gpio_callback;

typedef void (*gpio_callback_handler_t)(const struct device *port, struct gpio_callback *cb,
                                        gpio_port_pins_t pins);

/* Belongs to the caller and must live as long as it is added. */
struct gpio_callback {
	struct gpio_callback *next;
	gpio_callback_handler_t handler;
	gpio_port_pins_t pin_mask;
};

struct gpio_dt_spec {
	const struct device *port;
	gpio_pin_t pin;
	gpio_dt_flags_t dt_flags;
};

struct gpio_driver_api {
	int (*pin_configure)(const struct device *port, gpio_pin_t pin, gpio_flags_t flags);
	int (*port_get_raw)(const struct device *port, gpio_port_value_t *value);
	int (*port_set_masked_raw)(const struct device *port, gpio_port_pins_t mask,
	                           gpio_port_value_t value);
	int (*pin_interrupt_configure)(const struct device *port, gpio_pin_t pin,
	                               gpio_flags_t flags);
	int (*manage_callback)(const struct device *port, struct gpio_callback *cb, bool set);
};

/* First in every controller's data: which lines are active-low. */
struct gpio_driver_data {
	gpio_port_pins_t invert;
};

#define GPIO_DT_SPEC_GET_BY_IDX(node_id, prop, idx)                                                \
	{                                                                                          \
		.port = DEVICE_DT_GET(DT_GPIO_CTLR_BY_IDX(node_id, prop, idx)),                    \
		.pin = DT_GPIO_PIN_BY_IDX(node_id, prop, idx),                                     \
		.dt_flags = DT_GPIO_FLAGS_BY_IDX(node_id, prop, idx),                              \
	}
#define GPIO_DT_SPEC_GET(node_id, prop) GPIO_DT_SPEC_GET_BY_IDX(node_id, prop, 0)
#define GPIO_DT_SPEC_GET_OR(node_id, prop, default_value)                                          \
	NATIVE_DT_IF(NATIVE_DT_CAT4(node_id, _P_, prop, _EXISTS),                                  \
	             (GPIO_DT_SPEC_GET(node_id, prop)), (default_value))
#define GPIO_DT_SPEC_INST_GET(inst, prop) GPIO_DT_SPEC_GET(DT_DRV_INST(inst), prop)
#define GPIO_DT_SPEC_INST_GET_OR(inst, prop, default_value)                                        \
	GPIO_DT_SPEC_GET_OR(DT_DRV_INST(inst), prop, default_value)

int gpio_pin_configure(const struct device *port, gpio_pin_t pin, gpio_flags_t flags);
int gpio_pin_interrupt_configure(const struct device *port, gpio_pin_t pin, gpio_flags_t flags);
int gpio_pin_get_raw(const struct device *port, gpio_pin_t pin);
int gpio_pin_get(const struct device *port, gpio_pin_t pin);
int gpio_pin_set_raw(const struct device *port, gpio_pin_t pin, int value);
int gpio_pin_set(const struct device *port, gpio_pin_t pin, int value);
int gpio_pin_toggle(const struct device *port, gpio_pin_t pin);

static inline int gpio_pin_configure_dt(const struct gpio_dt_spec *spec, gpio_flags_t extra_flags)
{
	return gpio_pin_configure(spec->port, spec->pin, spec->dt_flags | extra_flags);
}

static inline int gpio_pin_interrupt_configure_dt(const struct gpio_dt_spec *spec,
                                                  gpio_flags_t flags)
{
	return gpio_pin_interrupt_configure(spec->port, spec->pin, flags);
}

static inline int gpio_pin_get_dt(const struct gpio_dt_spec *spec)
{
	return gpio_pin_get(spec->port, spec->pin);
}

static inline int gpio_pin_set_dt(const struct gpio_dt_spec *spec, int value)
{
	return gpio_pin_set(spec->port, spec->pin, value);
}

static inline int gpio_pin_toggle_dt(const struct gpio_dt_spec *spec)
{
	return gpio_pin_toggle(spec->port, spec->pin);
}

static inline void gpio_init_callback(struct gpio_callback *cb, gpio_callback_handler_t handler,
                                      gpio_port_pins_t pin_mask)
{
	cb->handler = handler;
	cb->pin_mask = pin_mask;
}

/* Adding a callback that is there already moves it to the front. */
static inline int gpio_add_callback(const struct device *port, struct gpio_callback *cb)
{
	return ((const struct gpio_driver_api *)port->api)->manage_callback(port, cb, true);
}

/* -EINVAL: was not there */
static inline int gpio_remove_callback(const struct device *port, struct gpio_callback *cb)
{
	return ((const struct gpio_driver_api *)port->api)->manage_callback(port, cb, false);
}

#endif
