/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/strobe.h"

#include <zephyr/drivers/gpio.h>
#include <zephyr/kernel.h>

#include <pharos/drivers/edge_time.h>
#include <pharos/drivers/light.h>

#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/startup.h"

/* Changed by the timer's and the input's interrupts, and by threads under irq_lock(). */
static struct gate gate;
static bool was_lit;
static uint32_t level_ppm; /* as the light driver has it */
static struct gpio_callback sync_callback;

static void edge_due(struct k_timer *timer);
static K_TIMER_DEFINE(edge_timer, edge_due, NULL);

/* Interrupts are locked, or this is one. */
static void carry_out(bool lit)
{
	const uint32_t now_ppm = gate_level_ppm(&gate);

	if (now_ppm != level_ppm) {
		level_ppm = now_ppm;
		light_set_level(devices.light, now_ppm);
	}
	light_set_gate(devices.light, lit);
	was_lit = was_lit || (lit && now_ppm > 0);

	const int64_t deadline_us = gate_deadline_us(&gate);

	if (deadline_us == TIME_NEVER_US) {
		k_timer_stop(&edge_timer);
	} else {
		k_timer_start(&edge_timer, clock_timeout(deadline_us), K_NO_WAIT);
	}
}

static void edge_due(struct k_timer *timer)
{
	const unsigned int key = irq_lock();

	carry_out(gate_advance(&gate, clock_now_us()));
	irq_unlock(key);
}

static void sync_changed(const struct device *port, struct gpio_callback *callback,
                         gpio_port_pins_t pins)
{
	const unsigned int key = irq_lock();
	const bool level = gpio_pin_get_dt(&devices.sync_input) > 0;

	(void)gate_input(&gate,
	                 edge_time_us(startup_ready(STARTUP_EDGE_TIME, devices.edge_time),
	                              &devices.sync_input),
	                 level);
	/* an edge may be told late: what it gives by now counts */
	carry_out(gate_advance(&gate, clock_now_us()));
	irq_unlock(key);
}

static int sync_input_init(void)
{
	const struct gpio_dt_spec *const input = &devices.sync_input;
	int error = gpio_pin_configure_dt(input, GPIO_INPUT);

	if (error == 0) {
		gpio_init_callback(&sync_callback, sync_changed, BIT(input->pin));
		error = gpio_add_callback(input->port, &sync_callback);
	}
	if (error == 0) {
		error = gpio_pin_interrupt_configure_dt(input, GPIO_INT_EDGE_BOTH);
	}
	return error;
}

void strobe_timer_init(const struct sync_config *sync)
{
	const bool wired = startup_result(STARTUP_SYNC) == 0;
	const int error = wired ? sync_input_init() : 0;
	const unsigned int key = irq_lock();

	gate_init(&gate, clock_now_us(), sync,
	          wired && error == 0 && gpio_pin_get_dt(&devices.sync_input) > 0);
	carry_out(false);
	irq_unlock(key);
	if (wired) {
		startup_done(STARTUP_SYNC, error);
	}
}

void strobe_timer_set(const struct light_plan *plan)
{
	const unsigned int key = irq_lock();
	const bool lit = gate_set(&gate, clock_now_us(), plan);

	carry_out(lit);
	irq_unlock(key);
}

void strobe_timer_configure(const struct sync_config *sync)
{
	const unsigned int key = irq_lock();

	carry_out(gate_configure(&gate, clock_now_us(), sync));
	irq_unlock(key);
}

bool strobe_timer_was_lit(void)
{
	const unsigned int key = irq_lock();
	const bool lit = was_lit;
	struct light_state light;

	light_get(devices.light, &light);
	was_lit = light.output_ppm > 0;
	irq_unlock(key);
	return lit;
}
