/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/inputs.h"

#include <zephyr/drivers/gpio.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>

#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/imc_light.h"
#include "threads/inbox.h"
#include "threads/startup.h"

LOG_MODULE_REGISTER(inputs);

/* The button's, as told over IMC. */
#define BUTTON_NUMBER 0

struct input {
	const struct gpio_dt_spec *spec;
	enum startup_step step;
	void (*changed)(bool active);
	struct gpio_callback callback;
	struct k_work_delayable settled;
	bool active;
};

static struct inputs_status status;

static void fault_changed(bool active)
{
	const unsigned int key = irq_lock();

	status.driver_fault = active;
	status.driver_faults += active ? 1 : 0;
	irq_unlock(key);
	inbox_wake();
	if (active) {
		LOG_ERR("the lamp's driver reports a fault");
	} else {
		LOG_INF("the lamp's driver is well again");
	}
}

/* In the command thread. */
static int toggle(struct pharos_device *device, void *argument)
{
	const struct device_who who = {.way = SECURITY_WAY_BUTTON};
	const struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_ON_OFF,
		.on_off = !device->lamps[0].illuminator.settings.enable,
	};

	return pharos_device_apply(device, clock_now_us(), &who, 0, &event, 1) == DEVICE_ACCEPTED
	               ? 0
	               : -EACCES;
}

/* In the command thread. */
static int tell(struct pharos_device *device, void *argument)
{
	imc_light_button(BUTTON_NUMBER, *(const bool *)argument);
	return 0;
}

static void button_changed(bool active)
{
	(void)inbox_call(tell, &active);
	if (!active) {
		return;
	}
	status.presses++;
	if (inbox_call(toggle, NULL) != 0) {
		LOG_WRN("the button was refused");
	}
}

static struct input inputs[] = {
	{.spec = &devices.driver_fault, .step = STARTUP_DRIVER_FAULT, .changed = fault_changed},
	{.spec = &devices.button, .step = STARTUP_BUTTON, .changed = button_changed},
};

static void settle(struct k_work *work)
{
	struct input *input = CONTAINER_OF(k_work_delayable_from_work(work), struct input, settled);
	const int level = gpio_pin_get_dt(input->spec);

	if (level >= 0 && input->active != (level > 0)) {
		input->active = level > 0;
		input->changed(input->active);
	}
}

static void edge(const struct device *port, struct gpio_callback *callback, gpio_port_pins_t pins)
{
	struct input *input = CONTAINER_OF(callback, struct input, callback);

	k_work_reschedule(&input->settled, K_MSEC(INPUTS_SETTLE_MS));
}

static int start(struct input *input)
{
	int error = gpio_pin_configure_dt(input->spec, GPIO_INPUT);

	k_work_init_delayable(&input->settled, settle);
	if (error == 0) {
		gpio_init_callback(&input->callback, edge, BIT(input->spec->pin));
		error = gpio_add_callback(input->spec->port, &input->callback);
	}
	if (error == 0) {
		error = gpio_pin_interrupt_configure_dt(input->spec, GPIO_INT_EDGE_BOTH);
	}
	if (error == 0) {
		k_work_reschedule(&input->settled, K_MSEC(INPUTS_SETTLE_MS));
	}
	return error;
}

void inputs_init(void)
{
	for (size_t i = 0; i < ARRAY_SIZE(inputs); i++) {
		if (startup_result(inputs[i].step) == 0) {
			startup_done(inputs[i].step, start(&inputs[i]));
		}
	}
	status.has_driver_fault = startup_result(STARTUP_DRIVER_FAULT) == 0;
}

struct inputs_status inputs_get(void)
{
	const unsigned int key = irq_lock();
	const struct inputs_status copy = status;

	irq_unlock(key);
	return copy;
}
