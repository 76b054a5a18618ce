/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/outputs.h"

#include <string.h>

#include <zephyr/drivers/gpio.h>
#include <zephyr/drivers/pwm.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#ifdef CONFIG_AUXDISPLAY
#include <zephyr/drivers/auxdisplay.h>
#endif

#include "threads/devices.h"
#include "threads/storage.h"

LOG_MODULE_REGISTER(outputs);

#define LED_FULL  255u
#define NS_PER_US 1000u

/* Power channels that are on after a start until somebody saves another choice: all but aux. */
#define POWER_DEFAULT 0x07u

_Static_assert(ACTUATOR_POWER_CHANNELS <= POWER_CHANNELS_MAX, "the core has every channel");
_Static_assert(ACTUATOR_GPIO_OUTPUTS <= ACTUATORS_GPIOS_MAX &&
                       ACTUATOR_GPIO_INPUTS <= ACTUATORS_GPIOS_MAX,
               "and every line");
_Static_assert(ACTUATOR_PWMS <= ACTUATORS_PWMS_MAX && ACTUATOR_LEDS <= ACTUATORS_LEDS_MAX,
               "and every PWM output and LED");

static struct actuators_outputs done; /* what the hardware does */
static uint32_t errors;

/* --- start ------------------------------------------------------------------------------------ */

static uint32_t present_lines(const struct gpio_dt_spec *lines, size_t count)
{
	uint32_t present = 0;

	for (size_t i = 0; i < count; i++) {
		present |= lines[i].port != NULL && device_is_ready(lines[i].port) ? BIT(i) : 0;
	}
	return present;
}

static bool is_present_pwm(const struct pwm_dt_spec *pwm)
{
	return pwm->dev != NULL && device_is_ready(pwm->dev);
}

static uint32_t present_pwms(const struct pwm_dt_spec *pwms, size_t count)
{
	uint32_t present = 0;

	for (size_t i = 0; i < count; i++) {
		present |= is_present_pwm(&pwms[i]) ? BIT(i) : 0;
	}
	return present;
}

static void start_line(const struct gpio_dt_spec *line, gpio_flags_t flags)
{
	const int error = gpio_pin_configure_dt(line, flags);

	if (error != 0) {
		errors++;
		LOG_ERR("%s line %u: error %d", line->port->name, line->pin, error);
	}
}

static void start_lines(const struct gpio_dt_spec *lines, uint32_t present, uint32_t levels,
                        bool input)
{
	for (uint32_t i = 0; (present >> i) != 0; i++) {
		const gpio_flags_t output =
			(levels & BIT(i)) != 0 ? GPIO_OUTPUT_ACTIVE : GPIO_OUTPUT_INACTIVE;

		if ((present & BIT(i)) != 0) {
			start_line(&lines[i], input ? GPIO_INPUT : output);
		}
	}
}

void outputs_config(struct actuators_config *config)
{
	*config = (struct actuators_config){
		.power = present_lines(actuator_devices.power, ACTUATOR_POWER_CHANNELS),
		.power_on = storage_load_power(POWER_DEFAULT),
		.pwms = present_pwms(actuator_devices.pwms, ACTUATOR_PWMS),
		.leds = present_pwms(actuator_devices.leds, ACTUATOR_LEDS),
		.gpio_outputs = present_lines(actuator_devices.gpio_outputs, ACTUATOR_GPIO_OUTPUTS),
		.gpio_inputs = present_lines(actuator_devices.gpio_inputs, ACTUATOR_GPIO_INPUTS),
		.thruster = is_present_pwm(&actuator_devices.thruster),
		.focus = present_lines(&actuator_devices.focus_in, 1) != 0 &&
	                 present_lines(&actuator_devices.focus_out, 1) != 0,
		.display = actuator_devices.display != NULL &&
	                   device_is_ready(actuator_devices.display),
	};
}

void outputs_start(const struct actuators *actuators)
{
	const struct actuators_config *const config = &actuators->config;
	const uint32_t focus = config->focus ? 1 : 0;

	done.power = actuators->power.on;
	start_lines(actuator_devices.power, config->power, done.power, false);
	start_lines(actuator_devices.gpio_outputs, config->gpio_outputs, 0, false);
	start_lines(actuator_devices.gpio_inputs, config->gpio_inputs, 0, true);
	start_lines(&actuator_devices.focus_in, focus, 0, false);
	start_lines(&actuator_devices.focus_out, focus, 0, false);
	outputs_perform(actuators);
}

uint32_t outputs_read_inputs(const struct actuators *actuators)
{
	uint32_t levels = 0;

	for (uint32_t i = 0; i < ACTUATOR_GPIO_INPUTS; i++) {
		if ((actuators->config.gpio_inputs & BIT(i)) != 0 &&
		    gpio_pin_get_dt(&actuator_devices.gpio_inputs[i]) > 0) {
			levels |= BIT(i);
		}
	}
	return levels;
}

/* --- outputs ---------------------------------------------------------------------------------- */

/* True: it is in force. */
static bool check(int error, const char *what)
{
	if (error != 0) {
		errors++;
		LOG_ERR("%s: error %d", what, error);
	}
	return error == 0;
}

static void perform_lines(const struct gpio_dt_spec *lines, uint32_t *now, uint32_t wanted,
                          const char *what)
{
	for (uint32_t i = 0; ((*now ^ wanted) >> i) != 0; i++) {
		const uint32_t bit = BIT(i);

		if (((*now ^ wanted) & bit) != 0 &&
		    check(gpio_pin_set_dt(&lines[i], (wanted & bit) != 0), what)) {
			*now ^= bit;
		}
	}
}

static void perform_pwms(const struct actuators_outputs *wanted)
{
	for (size_t i = 0; i < ACTUATOR_PWMS; i++) {
		const struct pwm_dt_spec *const spec = &actuator_devices.pwms[i];
		const struct actuators_pwm *const pwm = &wanted->pwms[i];
		const uint32_t period_ns =
			pwm->period_us == 0 ? spec->period : pwm->period_us * NS_PER_US;

		if (memcmp(pwm, &done.pwms[i], sizeof(*pwm)) != 0 &&
		    check(pwm_set_dt(spec, period_ns, pwm->duty_us * NS_PER_US), "PWM")) {
			done.pwms[i] = *pwm;
		}
	}
}

static void perform_leds(const struct actuators_outputs *wanted)
{
	for (size_t i = 0; i < ACTUATOR_LEDS; i++) {
		const struct pwm_dt_spec *const spec = &actuator_devices.leds[i];
		const uint32_t pulse_ns =
			(uint32_t)((uint64_t)spec->period * wanted->leds[i] / LED_FULL);

		if (wanted->leds[i] != done.leds[i] &&
		    check(pwm_set_pulse_dt(spec, pulse_ns), "LED")) {
			done.leds[i] = wanted->leds[i];
		}
	}
}

static void perform_motors(const struct actuators_outputs *wanted)
{
	if (wanted->thruster_pulse_us != done.thruster_pulse_us &&
	    check(pwm_set_pulse_dt(&actuator_devices.thruster,
	                           wanted->thruster_pulse_us * NS_PER_US),
	          "thruster")) {
		done.thruster_pulse_us = wanted->thruster_pulse_us;
	}
	if (wanted->focus == done.focus) {
		return;
	}
	const int in = gpio_pin_set_dt(&actuator_devices.focus_in, wanted->focus == FOCUS_MOTOR_IN);
	const int out =
		gpio_pin_set_dt(&actuator_devices.focus_out, wanted->focus == FOCUS_MOTOR_OUT);

	if (check(in != 0 ? in : out, "zoom")) {
		done.focus = wanted->focus;
	}
}

#ifdef CONFIG_AUXDISPLAY
/* A display on a slow bus keeps nobody waiting but the work queue. */
static struct display shown; /* changed under irq_lock() */

static int show_line(const struct display *display, uint32_t line)
{
	const struct device *const device = actuator_devices.display;
	const int error = auxdisplay_cursor_position_set(device, AUXDISPLAY_POSITION_ABSOLUTE, 0,
	                                                 (int16_t)line);

	return error != 0 ? error
	                  : auxdisplay_write(device, (const uint8_t *)display->lines[line],
	                                     DISPLAY_COLUMNS);
}

static void show(struct k_work *work)
{
	const unsigned int key = irq_lock();
	const struct display display = shown;
	int error;

	irq_unlock(key);
	error = display.on ? auxdisplay_display_on(actuator_devices.display)
	                   : auxdisplay_display_off(actuator_devices.display);
	for (uint32_t line = 0; line < DISPLAY_LINES && error == 0; line++) {
		error = show_line(&display, line);
	}
	if (error != 0) {
		LOG_ERR("display: error %d", error);
	}
}

static K_WORK_DEFINE(show_work, show);

static void perform_display(const struct display *wanted)
{
	if (memcmp(wanted, &done.display, sizeof(*wanted)) != 0) {
		const unsigned int key = irq_lock();

		shown = *wanted;
		done.display = *wanted;
		irq_unlock(key);
		k_work_submit(&show_work);
	}
}
#else
static void perform_display(const struct display *wanted)
{
}
#endif

void outputs_perform(const struct actuators *actuators)
{
	struct actuators_outputs wanted;

	actuators_outputs(actuators, &wanted);
	perform_lines(actuator_devices.power, &done.power, wanted.power, "power");
	perform_lines(actuator_devices.gpio_outputs, &done.gpio_outputs, wanted.gpio_outputs,
	              "GPIO");
	perform_pwms(&wanted);
	perform_leds(&wanted);
	perform_motors(&wanted);
	if (actuators->config.display) {
		perform_display(&wanted.display);
	}
	storage_save_power((uint8_t)actuators->power.saved); /* if it is another one */
}

uint32_t outputs_errors(void)
{
	return errors;
}
