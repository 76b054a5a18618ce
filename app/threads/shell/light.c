/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command for the lamp: light.
 *
 * A command's function runs in the shell's thread; what touches the light runs in the command
 * thread through inbox_call(). Numbers are read and printed without floating point.
 */
#include <errno.h>

#include <zephyr/shell/shell.h>

#include <pharos/drivers/light.h>
#include <pharos/drivers/thermistor.h>

#include "core/decimal.h"
#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/inputs.h"
#include "threads/shell/call.h"
#include "threads/shell/names.h"
#include "threads/shell/say.h"

#define LAMP 0

enum setting {
	SETTING_ENABLE,
	SETTING_MODE,
	SETTING_BRIGHTNESS,
	SETTING_PERIOD,
	SETTING_DUTY,
};

/* One setting, and what became of it. */
struct light_request {
	enum setting setting;
	uint32_t value;
	enum device_result result;
	uint32_t min_period_us;
	uint32_t max_period_us;
};

/* The event that changes the one setting of those in force now. */
static struct illuminator_event event_of(const struct illuminator_settings *now,
                                         const struct light_request *request)
{
	struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_CONFIGURE,
		.configure =
			{
				.mode = now->mode,
				.brightness_ppm = now->brightness_ppm,
				.strobe_period_us = now->strobe_period_us,
				.duty_ppm = now->duty_ppm,
			},
	};

	switch (request->setting) {
	case SETTING_ENABLE:
		event.kind = ILLUMINATOR_EVENT_ON_OFF;
		event.on_off = request->value != 0;
		break;
	case SETTING_MODE:
		event.configure.mode = request->value;
		break;
	case SETTING_BRIGHTNESS:
		event.configure.brightness_ppm = request->value;
		break;
	case SETTING_PERIOD:
		event.configure.strobe_period_us = request->value;
		break;
	case SETTING_DUTY:
		event.configure.duty_ppm = request->value;
		break;
	}
	return event;
}

/* In the command thread, so that nobody's change comes between reading and writing. */
static int apply(struct pharos_device *device, void *argument)
{
	struct light_request *const request = argument;
	const struct illuminator *const light = &device->lamps[LAMP].illuminator;
	const struct illuminator_event event = event_of(&light->settings, request);

	request->result = pharos_device_apply(device, clock_now_us(), &shell_who, LAMP, &event, 1);
	request->min_period_us = light->config.min_period_us;
	request->max_period_us = light->config.max_period_us;
	return 0;
}

static void say_ranges(const struct shell *sh, const struct light_request *request)
{
	char shortest[DECIMAL_TEXT_MAX];
	char longest[DECIMAL_TEXT_MAX];

	(void)decimal_print(shortest, request->min_period_us, US_DECIMALS);
	(void)decimal_print(longest, request->max_period_us, US_DECIMALS);
	shell_error(sh, "out of range; nothing changed (0 to 100 %%, period 0 or %s to %s s)",
	            shortest, longest);
}

/* Changes the setting and says what became of it. */
static int light_command(const struct shell *sh, enum setting setting, uint32_t value)
{
	struct light_request request = {.setting = setting, .value = value};

	if (!shell_call(sh, apply, &request, NULL)) {
		return -EAGAIN;
	}
	if (request.result == DEVICE_DENIED) {
		say_ranges(sh, &request);
		return -EINVAL;
	}
	if (request.result == DEVICE_FAILED) {
		shell_error(sh, "not now: over temperature (see: thermal), without power, or "
		                "not started (see: startup)");
		return -EAGAIN;
	}
	return say_result(sh, request.result, "light status");
}

static int cmd_light_on(const struct shell *sh, size_t argc, char **argv)
{
	return light_command(sh, SETTING_ENABLE, 1);
}

static int cmd_light_off(const struct shell *sh, size_t argc, char **argv)
{
	return light_command(sh, SETTING_ENABLE, 0);
}

/* argv[1], a number, scaled by 10^decimals. */
static int number_command(const struct shell *sh, char **argv, unsigned int decimals,
                          const char *unit, enum setting setting)
{
	int64_t parsed;

	if (!decimal_parse_exact(argv[1], decimals, &parsed) || parsed < 0 || parsed > UINT32_MAX) {
		shell_error(sh, "%s: '%s' is not a number of %s, such as 40 or 0.5", argv[0],
		            argv[1], unit);
		return -EINVAL;
	}
	return light_command(sh, setting, (uint32_t)parsed);
}

static int cmd_light_brightness(const struct shell *sh, size_t argc, char **argv)
{
	return number_command(sh, argv, PPM_PER_PERCENT_DECIMALS, "percent", SETTING_BRIGHTNESS);
}

static int cmd_light_period(const struct shell *sh, size_t argc, char **argv)
{
	return number_command(sh, argv, US_DECIMALS, "seconds", SETTING_PERIOD);
}

static int cmd_light_duty(const struct shell *sh, size_t argc, char **argv)
{
	return number_command(sh, argv, PPM_PER_PERCENT_DECIMALS, "percent", SETTING_DUTY);
}

static int cmd_light_mode(const struct shell *sh, size_t argc, char **argv)
{
	if (names_equal("internal", argv[1])) {
		return light_command(sh, SETTING_MODE, ILLUMINATOR_MODE_INTERNAL);
	}
	if (names_equal("sync", argv[1])) {
		return light_command(sh, SETTING_MODE, ILLUMINATOR_MODE_SYNC);
	}
	shell_error(sh, "mode: '%s' is neither internal nor sync", argv[1]);
	return -EINVAL;
}

static int set_program(struct pharos_device *device, void *argument)
{
	return (int)pharos_device_set_param(device, clock_now_us(), &shell_who, PARAM_LGT_PROGRAM,
	                                    *(const enum program_kind *)argument);
}

static bool find_program(const char *name, enum program_kind *kind)
{
	for (uint32_t i = 0; i < PROGRAM_KINDS; i++) {
		*kind = (enum program_kind)i;
		if (names_equal(program_name(*kind), name)) {
			return true;
		}
	}
	return false;
}

/* For the Tab key. */
static void program_get(size_t index, struct shell_static_entry *entry)
{
	*entry = (struct shell_static_entry){
		.syntax = index < PROGRAM_KINDS ? program_name((enum program_kind)index) : NULL,
	};
}

SHELL_DYNAMIC_CMD_CREATE(program_names, program_get);

static int cmd_light_program(const struct shell *sh, size_t argc, char **argv)
{
	enum program_kind kind;

	if (!find_program(argv[1], &kind)) {
		shell_error(sh, "no program '%s'; there are: %s, %s, %s, %s, %s", argv[1],
		            program_name(PROGRAM_NONE), program_name(PROGRAM_ANTI_COLLISION),
		            program_name(PROGRAM_DOUBLE_FLASH), program_name(PROGRAM_FADE),
		            program_name(PROGRAM_SOS));
		return -EINVAL;
	}
	int result;

	if (!shell_call(sh, set_program, &kind, &result)) {
		return -EAGAIN;
	}
	return say_result(sh, result == PARAMS_OK ? DEVICE_ACCEPTED : DEVICE_EXCLUDED,
	                  "light status");
}

/* What the shell's thread prints, copied in the command thread. */
struct light_view {
	struct illuminator illuminator;
	enum arbiter_source commander;
};

static int copy_light(struct pharos_device *device, void *argument)
{
	struct light_view *const view = argument;

	view->illuminator = device->lamps[LAMP].illuminator;
	view->commander = device->lamps[LAMP].arbiter.commander;
	return 0;
}

static int cmd_light_status(const struct shell *sh, size_t argc, char **argv)
{
	const struct inputs_status inputs = inputs_get();
	struct light_view view;
	const struct illuminator *const now = &view.illuminator;
	struct light_state light;

	if (!shell_call(sh, copy_light, &view, NULL)) {
		return -EAGAIN;
	}
	light_get(devices.light, &light);
	shell_print(sh, "%-14s%s", "enable", now->settings.enable ? "on" : "off");
	shell_print(sh, "%-14s%s", "mode",
	            now->settings.mode == ILLUMINATOR_MODE_INTERNAL ? "internal" : "external sync");
	say_fixed(sh, "brightness", now->settings.brightness_ppm, PPM_PER_PERCENT_DECIMALS, "%");
	if (now->settings.strobe_period_us == 0) {
		shell_print(sh, "%-14snone", "strobe");
	} else {
		say_fixed(sh, "strobe period", now->settings.strobe_period_us, US_DECIMALS, "s");
		say_fixed(sh, "strobe duty", now->settings.duty_ppm, PPM_PER_PERCENT_DECIMALS, "%");
	}
	shell_print(sh, "%-14s%s%s", "program", program_name(now->config.program.kind),
	            now->config.program.kind != PROGRAM_NONE && now->plan.on &&
	                            now->plan.program.kind == PROGRAM_NONE
	                    ? ", but a strobe or external sync is commanded"
	                    : "");
	shell_print(sh, "%-14s%s", "commander", arbiter_source_name(view.commander));
	say_fixed(sh, "limit", light.limit_ppm, PPM_PER_PERCENT_DECIMALS, "% of full power");
	say_fixed(sh, "output now", light.output_ppm, PPM_PER_PERCENT_DECIMALS, "% of full power");
	if (light.errors > 0) {
		shell_print(sh, "%-14s%u that failed, last %d", "writes", light.errors,
		            light.error);
	}
	if (thermistor_is_simulated(devices.thermistor)) {
		shell_print(sh, "%-14sSIMULATED: nothing protects the lamp from heat", "sensor");
	}
	if (inputs.has_driver_fault) {
		shell_print(sh, "%-14s%s, %u faults", "driver",
		            inputs.driver_fault ? "FAULT" : "ok", inputs.driver_faults);
	}
	return 0;
}

SHELL_STATIC_SUBCMD_SET_CREATE(
	light_set_commands,
	SHELL_CMD_ARG(brightness, NULL, "PERCENT  0 to 100", cmd_light_brightness, 2, 0),
	SHELL_CMD_ARG(duty, NULL, "PERCENT  lit part of a strobe period; 100: always, 0: no strobe",
		      cmd_light_duty, 2, 0),
	SHELL_CMD_ARG(mode, NULL, "internal|sync", cmd_light_mode, 2, 0),
	SHELL_CMD_ARG(period, NULL, "SECONDS  of the strobe; 0: none", cmd_light_period, 2, 0),
	SHELL_SUBCMD_SET_END);

SHELL_STATIC_SUBCMD_SET_CREATE(
	light_commands, SHELL_CMD_ARG(off, NULL, "Lamp off", cmd_light_off, 1, 0),
	SHELL_CMD_ARG(on, NULL, "Lamp on", cmd_light_on, 1, 0),
	SHELL_CMD_ARG(program, &program_names,
		      "none|anti-collision|double-flash|fade|sos  what it shows while on without a "
		      "strobe",
		      cmd_light_program, 2, 0),
	SHELL_CMD(set, &light_set_commands, "Change one setting", NULL),
	SHELL_CMD_ARG(status, NULL, "What was commanded, and what the lamp does",
		      cmd_light_status, 1, 0),
	SHELL_SUBCMD_SET_END);

SHELL_CMD_REGISTER(light, &light_commands, "The lamp", NULL);
