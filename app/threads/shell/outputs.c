/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell commands for what IMC actuates: power, display, outputs.
 */
#include <errno.h>
#include <string.h>

#include <zephyr/shell/shell.h>

#include "core/decimal.h"
#include "proto/imc/actuation_map.h"
#include "proto/imc/endpoint.h"
#include "threads/clock.h"
#include "threads/imc_light.h"
#include "threads/outputs.h"
#include "threads/shell/call.h"
#include "threads/shell/say.h"

/* Too large for the shell's stack; there is one shell, and it runs one command at a time. */
static struct {
	struct actuators actuators;
	uint32_t outcomes[IMC_ACTUATION_REFUSED + 1];
	uint32_t errors;
	int64_t now_us;
} now;

static int take_snapshot(struct pharos_device *device, void *argument)
{
	now.actuators = device->actuators;
	memcpy(now.outcomes, imc_light_endpoint()->actuation.stats.outcomes, sizeof(now.outcomes));
	now.errors = outputs_errors();
	now.now_us = clock_now_us();
	return 0;
}

/* --- power ------------------------------------------------------------------------------------ */

static const char *on_off(uint32_t mask, uint32_t number)
{
	return (mask & (1u << number)) != 0 ? "on" : "off";
}

/* ", on in 12.5 s"; nothing when it is not scheduled. */
static void print_timer(const struct shell *sh, const char *what, int64_t due_us)
{
	char text[DECIMAL_TEXT_MAX];

	if (due_us != TIME_NEVER_US) {
		(void)decimal_print(text, due_us - now.now_us, 6);
		shell_fprintf(sh, SHELL_NORMAL, ", %s in %s s", what, text);
	}
}

static int cmd_power_status(const struct shell *sh, size_t argc, char **argv)
{
	if (!shell_call(sh, take_snapshot, NULL, NULL)) {
		return -EAGAIN;
	}
	const struct power *const power = &now.actuators.power;

	for (uint32_t i = 0; i < imc_map_count; i++) {
		const struct imc_map_row *const row = &imc_map[i];

		if (row->space != IMC_MAP_POWER || (power->present & (1u << row->number)) == 0) {
			continue;
		}
		const struct power_timers *const timers = &power->timers[row->number];

		shell_fprintf(sh, SHELL_NORMAL, "%-14s%s, after a start %s", row->name,
		              on_off(power_outputs(power), row->number),
		              on_off(power->saved, row->number));
		print_timer(sh, "on", timers->on_us);
		print_timer(sh, "off", timers->off_us);
		print_timer(sh, "on again", timers->restart_us);
		shell_fprintf(sh, SHELL_NORMAL, "\n");
	}
	return 0;
}

struct power_request {
	uint8_t channel;
	uint32_t op;
};

static int switch_power(struct pharos_device *device, void *argument)
{
	const struct power_request *const request = argument;
	const struct actuators_event event = {
		.kind = ACTUATORS_EVENT_POWER,
		.number = request->channel,
		.timed = {.op = request->op},
	};

	return pharos_device_output(device, clock_now_us(), &shell_who, &event) == DEVICE_ACCEPTED
	               ? 0
	               : -EACCES;
}

static int power_command_of(const struct shell *sh, const char *name, uint32_t op)
{
	const struct imc_text text = {.bytes = name, .length = (uint16_t)strlen(name)};
	const struct imc_map_row *const row = imc_map_by_name(IMC_MAP_POWER, &text);
	struct power_request request = {.op = op};
	int error;

	if (row == NULL) {
		shell_error(sh, "no channel '%s' (see: power status)", name);
		return -EINVAL;
	}
	request.channel = row->number;
	if (!shell_call(sh, switch_power, &request, &error)) {
		return -EAGAIN;
	}
	if (error != 0) {
		shell_error(sh, "refused: not on this board, or the shell may not command now");
		return -EACCES;
	}
	shell_print(sh, "ok");
	return 0;
}

static int cmd_power_on(const struct shell *sh, size_t argc, char **argv)
{
	return power_command_of(sh, argv[1], POWER_OP_ON);
}

static int cmd_power_off(const struct shell *sh, size_t argc, char **argv)
{
	return power_command_of(sh, argv[1], POWER_OP_OFF);
}

static int cmd_power_save(const struct shell *sh, size_t argc, char **argv)
{
	return power_command_of(sh, argv[1], POWER_OP_SAVE);
}

SHELL_STATIC_SUBCMD_SET_CREATE(
	power_commands, SHELL_CMD_ARG(off, NULL, "CHANNEL", cmd_power_off, 2, 0),
	SHELL_CMD_ARG(on, NULL, "CHANNEL", cmd_power_on, 2, 0),
	SHELL_CMD_ARG(save, NULL, "CHANNEL  as it is now, so after a start", cmd_power_save, 2, 0),
	SHELL_CMD_ARG(status, NULL, "Every channel, and what is scheduled", cmd_power_status, 1, 0),
	SHELL_SUBCMD_SET_END);

SHELL_CMD_REGISTER(power, &power_commands, "Power channels", NULL);

/* --- display, outputs ------------------------------------------------------------------------- */

static int cmd_display(const struct shell *sh, size_t argc, char **argv)
{
	if (!shell_call(sh, take_snapshot, NULL, NULL)) {
		return -EAGAIN;
	}
	const struct display *const display = &now.actuators.display;

	if (!now.actuators.config.display) {
		shell_error(sh, "this board has no display");
		return -ENODEV;
	}
	shell_print(sh, "%s", display->on ? "on" : "off");
	for (size_t line = 0; line < DISPLAY_LINES; line++) {
		shell_print(sh, "|%.*s|", (int)DISPLAY_COLUMNS, display->lines[line]);
	}
	return 0;
}

SHELL_CMD_ARG_REGISTER(display, NULL, "What stands on the display", cmd_display, 1, 0);

static void print_row(const struct shell *sh, const struct imc_map_row *row)
{
	const struct actuators *const actuators = &now.actuators;
	char text[DECIMAL_TEXT_MAX];

	switch (row->thing) {
	case IMC_THING_LED:
		shell_print(sh, "%-14sLED %u of 255", row->name, actuators->leds[row->number]);
		break;
	case IMC_THING_GPIO_OUTPUT:
		shell_print(sh, "%-14s%s", row->name, on_off(actuators->gpio_outputs, row->number));
		break;
	case IMC_THING_PWM:
		shell_print(sh, "%-14s%u of %u us", row->name, actuators->pwms[row->number].duty_us,
		            actuators->pwms[row->number].period_us);
		break;
	case IMC_THING_THRUSTER:
		shell_print(sh, "%-14s%u us", row->name, thruster_pulse_us(&actuators->thruster));
		break;
	case IMC_THING_FOCUS:
		(void)decimal_print(text, focus_position_ppm(&actuators->focus, now.now_us), 4);
		shell_print(sh, "%-14s%s %% of the way to spot", row->name, text);
		break;
	case IMC_THING_POWER_CHANNEL:
	case IMC_THING_LAMP:
	case IMC_THING_GPIO_INPUT:
	case IMC_THING_PAN:
	case IMC_THING_TILT:
		break; /* have commands of their own, or are no outputs */
	}
}

static int cmd_outputs(const struct shell *sh, size_t argc, char **argv)
{
	if (!shell_call(sh, take_snapshot, NULL, NULL)) {
		return -EAGAIN;
	}
	const struct imc_actuation *const service = &imc_light_endpoint()->actuation;
	const uint32_t *const outcomes = now.outcomes;

	for (uint32_t i = 0; i < imc_map_count; i++) {
		/* servos are PWM outputs under another number */
		if (imc_map[i].space != IMC_MAP_SERVO && imc_actuation_has(service, &imc_map[i])) {
			print_row(sh, &imc_map[i]);
		}
	}
	shell_print(sh, "%-14s%s", "device",
	            actuators_is_up(&now.actuators) ? "up" : "powered down");
	shell_print(sh, "%-14s%u done, %u unknown, %u out of range, %u refused, %u write errors",
	            "commands", outcomes[IMC_ACTUATION_DONE], outcomes[IMC_ACTUATION_UNKNOWN],
	            outcomes[IMC_ACTUATION_OUT_OF_RANGE], outcomes[IMC_ACTUATION_REFUSED],
	            now.errors);
	return 0;
}

SHELL_CMD_ARG_REGISTER(outputs, NULL, "PWM, LEDs, lines and motors", cmd_outputs, 1, 0);
