/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The board's devices, by what the application uses them for. devices.c is the one file of the
 * application with devicetree names: a port to another board is an overlay with these aliases.
 */
#ifndef PHAROS_THREADS_DEVICES_H
#define PHAROS_THREADS_DEVICES_H

#include <zephyr/device.h>
#include <zephyr/drivers/gpio.h>
#include <zephyr/drivers/pwm.h>

#include "threads/limits.h"

struct devices {
	const struct device *light;
	const struct device *thermistor;
	const struct device *watchdog;
	const struct device *servo_pan;                  /* NULL: the board has none */
	const struct device *servo_tilt;                 /* the same */
	const struct device *probe;                      /* NULL: the board has none */
	const struct device *uart_links[UART_LINKS_MAX]; /* NULL: not on this board */
	uint32_t uart_bauds[UART_LINKS_MAX];             /* the devicetree's, 0: not said there */
	const struct device *can_link;                   /* NULL: the board has none */
	const struct device *edge_time;                  /* NULL: the board has none */
	const struct device *imc_datagrams;              /* NULL: the board has none */
	const struct device *strap;                      /* NULL: the board has none */
	struct gpio_dt_spec sync_input;                  /* .port NULL: not on this board */
	struct gpio_dt_spec button;                      /* the same */
	struct gpio_dt_spec driver_fault;                /* the same */
};

extern const struct devices devices;

#ifdef CONFIG_PHAROS_IMC
/* What IMC actuates, by its number (proto/imc/actuation_map.h). .port or .dev NULL: not on this
 * board.
 */
struct actuator_devices {
	struct gpio_dt_spec power[ACTUATOR_POWER_CHANNELS];
	struct gpio_dt_spec gpio_outputs[ACTUATOR_GPIO_OUTPUTS];
	struct gpio_dt_spec gpio_inputs[ACTUATOR_GPIO_INPUTS];
	struct pwm_dt_spec pwms[ACTUATOR_PWMS];
	struct pwm_dt_spec leds[ACTUATOR_LEDS];
	struct pwm_dt_spec thruster;
	struct gpio_dt_spec focus_in;
	struct gpio_dt_spec focus_out;
	const struct device *display; /* NULL: not on this board */
};

extern const struct actuator_devices actuator_devices;
#endif

#ifdef CONFIG_PHAROS_FIRMWARE_UPDATE
/* The flash area for a new image, and its bytes. */
uint8_t devices_update_slot(void);
uint32_t devices_update_slot_size(void);
#endif

/* The result of each device's own start, to threads/startup.h. */
void devices_start(void);

#endif
