/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The device's own shell commands: light, thermal, link, reset, version.
 *
 * A command's function runs in the shell's thread; what touches the light runs in the command
 * thread through command_call(). Numbers are read and printed without floating point.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/shell/shell.h>
#include <zephyr/sys/reboot.h>

#include <pharos/drivers/light.h>

#include "threads/clock.h"
#include "threads/command.h"
#include "threads/devices.h"
#include "threads/fixed.h"
#include "threads/inputs.h"
#include "threads/link.h"
#include "threads/reset_cause.h"
#include "threads/shell_call.h"
#include "threads/shell_can.h"
#include "threads/strobe.h"
#include "threads/thermal.h"
#include "version.h"

#define PPM_PER_PERCENT_DECIMALS 4 /* 1 % = 10 000 ppm */
#define US_PER_S_DECIMALS        6

/* --- light ------------------------------------------------------------------------------------ */

struct light_request {
	struct illuminator_event event;
	enum illuminator_result result;
	enum arbiter_verdict verdict;
	uint32_t min_period_us;
	uint32_t max_period_us;
};

static int apply(struct command *command, void *argument)
{
	struct light_request *const request = argument;

	request->verdict =
		command_apply(command, ARBITER_SOURCE_SHELL, &request->event, &request->result);
	request->min_period_us = command->illuminator.config.min_period_us;
	request->max_period_us = command->illuminator.config.max_period_us;
	return 0;
}

static void say_ranges(const struct shell *sh, const struct light_request *request)
{
	char shortest[FIXED_TEXT_MAX];
	char longest[FIXED_TEXT_MAX];

	fixed_format(shortest, request->min_period_us, US_PER_S_DECIMALS);
	fixed_format(longest, request->max_period_us, US_PER_S_DECIMALS);
	shell_error(sh, "out of range; nothing changed (0 to 100 %%, period 0 or %s to %s s)",
	            shortest, longest);
}

/* Carries the event out and says what became of it. */
static int light_command(const struct shell *sh, const struct illuminator_event *event)
{
	struct light_request request = {.event = *event};

	if (!shell_call(sh, apply, &request, NULL)) {
		return -EAGAIN;
	}
	if (request.verdict == ARBITER_EXCLUDED) {
		shell_error(sh, "the shell may not command (see: param get LGT_SRC_EXCL)");
		return -EACCES;
	}
	if (request.verdict == ARBITER_OUTRANKED) {
		shell_error(sh, "not now: another source is in command (see: light status)");
		return -EBUSY;
	}
	switch (request.result) {
	case ILLUMINATOR_ACCEPTED:
		shell_print(sh, "ok");
		return 0;
	case ILLUMINATOR_DENIED:
		say_ranges(sh, &request);
		return -EINVAL;
	case ILLUMINATOR_FAILED:
		shell_error(sh, "not now: over temperature (see: thermal), without power, or "
		                "not started (see: startup)");
		return -EAGAIN;
	}
	return -EINVAL;
}

static int cmd_light_on(const struct shell *sh, size_t argc, char **argv)
{
	const struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_ON_OFF, .on_off = true};

	return light_command(sh, &event);
}

static int cmd_light_off(const struct shell *sh, size_t argc, char **argv)
{
	const struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_ON_OFF, .on_off = false};

	return light_command(sh, &event);
}

static int copy_illuminator(struct command *command, void *argument)
{
	*(struct illuminator *)argument = command->illuminator;
	return 0;
}

static int commander(struct command *command, void *argument)
{
	return (int)command->arbiter.commander;
}

/* The CONFIGURE event that keeps everything as it is. */
static bool configure_as_is(const struct shell *sh, struct illuminator_event *event)
{
	struct illuminator now;

	if (!shell_call(sh, copy_illuminator, &now, NULL)) {
		return false;
	}
	*event = (struct illuminator_event){
		.kind = ILLUMINATOR_EVENT_CONFIGURE,
		.configure =
			{
				.mode = now.settings.mode,
				.brightness_ppm = now.settings.brightness_ppm,
				.strobe_period_us = now.settings.strobe_period_us,
				.duty_ppm = now.settings.duty_ppm,
			},
	};
	return true;
}

/* One number of `light set`: argv[1] into *value, scaled by 10^decimals. */
static int parse_value(const struct shell *sh, char **argv, unsigned int decimals, const char *unit,
                       uint32_t *value)
{
	int64_t parsed;

	if (!fixed_parse(argv[1], decimals, &parsed) || parsed < 0 || parsed > UINT32_MAX) {
		shell_error(sh, "%s: '%s' is not a number of %s, such as 40 or 0.5", argv[0],
		            argv[1], unit);
		return -EINVAL;
	}
	*value = (uint32_t)parsed;
	return 0;
}

static int cmd_light_brightness(const struct shell *sh, size_t argc, char **argv)
{
	struct illuminator_event event;

	if (!configure_as_is(sh, &event)) {
		return -EAGAIN;
	}
	const int error = parse_value(sh, argv, PPM_PER_PERCENT_DECIMALS, "percent",
	                              &event.configure.brightness_ppm);

	return error != 0 ? error : light_command(sh, &event);
}

static int cmd_light_period(const struct shell *sh, size_t argc, char **argv)
{
	struct illuminator_event event;

	if (!configure_as_is(sh, &event)) {
		return -EAGAIN;
	}
	const int error = parse_value(sh, argv, US_PER_S_DECIMALS, "seconds",
	                              &event.configure.strobe_period_us);

	return error != 0 ? error : light_command(sh, &event);
}

static int cmd_light_duty(const struct shell *sh, size_t argc, char **argv)
{
	struct illuminator_event event;

	if (!configure_as_is(sh, &event)) {
		return -EAGAIN;
	}
	const int error = parse_value(sh, argv, PPM_PER_PERCENT_DECIMALS, "percent",
	                              &event.configure.duty_ppm);

	return error != 0 ? error : light_command(sh, &event);
}

static int cmd_light_mode(const struct shell *sh, size_t argc, char **argv)
{
	struct illuminator_event event;

	if (!configure_as_is(sh, &event)) {
		return -EAGAIN;
	}
	if (strcmp(argv[1], "internal") == 0) {
		event.configure.mode = ILLUMINATOR_MODE_INTERNAL;
	} else if (strcmp(argv[1], "sync") == 0) {
		event.configure.mode = ILLUMINATOR_MODE_SYNC;
	} else {
		shell_error(sh, "mode: '%s' is neither internal nor sync", argv[1]);
		return -EINVAL;
	}
	return light_command(sh, &event);
}

static int set_program(struct command *command, void *argument)
{
	static const char name[] = "LGT_PROGRAM";

	return (int)command_set_param(command, name, sizeof(name) - 1,
	                              *(const enum program_kind *)argument);
}

static int cmd_light_program(const struct shell *sh, size_t argc, char **argv)
{
	enum program_kind kind;

	if (!program_find(argv[1], &kind)) {
		shell_error(sh, "no program '%s'; there are: %s, %s, %s, %s, %s", argv[1],
		            program_name(PROGRAM_NONE), program_name(PROGRAM_ANTI_COLLISION),
		            program_name(PROGRAM_DOUBLE_FLASH), program_name(PROGRAM_FADE),
		            program_name(PROGRAM_SOS));
		return -EINVAL;
	}
	if (!shell_call(sh, set_program, &kind, NULL)) {
		return -EAGAIN;
	}
	shell_print(sh, "ok");
	return 0;
}

/* "label  12.5 unit", without trailing zeros. */
static void print_fixed(const struct shell *sh, const char *label, int64_t value,
                        unsigned int decimals, const char *unit)
{
	char text[FIXED_TEXT_MAX];

	fixed_format(text, value, decimals);
	shell_print(sh, "%-14s%s %s", label, text, unit);
}

static int cmd_light_status(const struct shell *sh, size_t argc, char **argv)
{
	const struct inputs_status inputs = inputs_get();
	struct illuminator now;
	struct light_state light;
	int source;

	if (!shell_call(sh, commander, NULL, &source) ||
	    !shell_call(sh, copy_illuminator, &now, NULL)) {
		return -EAGAIN;
	}
	light_get(devices.light, &light);
	shell_print(sh, "%-14s%s", "enable", now.settings.enable ? "on" : "off");
	shell_print(sh, "%-14s%s", "mode",
	            now.settings.mode == ILLUMINATOR_MODE_INTERNAL ? "internal" : "external sync");
	print_fixed(sh, "brightness", now.settings.brightness_ppm, PPM_PER_PERCENT_DECIMALS, "%");
	if (now.settings.strobe_period_us == 0) {
		shell_print(sh, "%-14snone", "strobe");
	} else {
		print_fixed(sh, "strobe period", now.settings.strobe_period_us, US_PER_S_DECIMALS,
		            "s");
		print_fixed(sh, "strobe duty", now.settings.duty_ppm, PPM_PER_PERCENT_DECIMALS,
		            "%");
	}
	shell_print(sh, "%-14s%s%s", "program", program_name(now.config.program.kind),
	            now.config.program.kind != PROGRAM_NONE && now.plan.on &&
	                            now.plan.program.kind == PROGRAM_NONE
	                    ? ", but a strobe or external sync is commanded"
	                    : "");
	shell_print(sh, "%-14s%s", "commander", arbiter_source_name((enum arbiter_source)source));
	print_fixed(sh, "limit", light.limit_ppm, PPM_PER_PERCENT_DECIMALS, "% of full power");
	print_fixed(sh, "output now", light.output_ppm, PPM_PER_PERCENT_DECIMALS,
	            "% of full power");
	if (light.errors > 0) {
		shell_print(sh, "%-14s%u that failed, last %d", "writes", light.errors,
		            light.error);
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
	SHELL_CMD_ARG(program, NULL,
		      "none|anti-collision|double-flash|fade|sos  what it shows while on without a "
		      "strobe",
		      cmd_light_program, 2, 0),
	SHELL_CMD(set, &light_set_commands, "Change one setting", NULL),
	SHELL_CMD_ARG(status, NULL, "What was commanded, and what the lamp does",
		      cmd_light_status, 1, 0),
	SHELL_SUBCMD_SET_END);

SHELL_CMD_REGISTER(light, &light_commands, "The lamp", NULL);

/* --- thermal ---------------------------------------------------------------------------------- */

static int cmd_thermal(const struct shell *sh, size_t argc, char **argv)
{
	struct thermal thermal;

	thermal_thread_get(&thermal);
	const struct thermal_report *const report = &thermal.report;

	shell_print(sh, "%-14s%s", "state", thermal_state_name(report->state));
	if (report->temp_valid) {
		print_fixed(sh, "temperature", report->temp_mdegc, 3, "degC");
		shell_print(sh, "%-14sok", "sensor");
	} else {
		shell_print(sh, "%-14s%s", "sensor",
		            report->sensor == THERMAL_SENSOR_WAITING
		                    ? "waiting"
		                    : thermal_fault_name(report->fault));
	}
	print_fixed(sh, "limit", report->limit_ppm, PPM_PER_PERCENT_DECIMALS, "% of full power");
	print_fixed(sh, "throttle at", thermal.config.throttle_mdegc, 3, "degC");
	print_fixed(sh, "shutdown at", thermal.config.shutdown_mdegc, 3, "degC");
	print_fixed(sh, "recover below", thermal.config.recover_mdegc, 3, "degC");
	shell_print(sh, "%-14s%u (%u bad), %u sensor failures, %u shutdowns", "samples",
	            thermal.stats.samples, thermal.stats.bad_samples, thermal.stats.sensor_failures,
	            thermal.stats.shutdowns);
	return 0;
}

SHELL_CMD_ARG_REGISTER(thermal, NULL, "Temperature, limit and thresholds", cmd_thermal, 1, 0);

/* --- link ------------------------------------------------------------------------------------- */

static void print_link(const struct shell *sh, uint8_t link)
{
	struct link_stats stats;

	if (link_stats_get(link, &stats) != 0) {
		return;
	}
	shell_print(sh,
	            "%-7s rx %u frames, %u bytes; overruns %u, line errors %u, bad frames %u, "
	            "skipped bytes %u",
	            link_name(link), stats.rx_frames, stats.rx_bytes, stats.rx_overruns,
	            stats.rx_errors, stats.framing.crc_errors, stats.framing.skipped_bytes);
	shell_print(sh, "%-7s tx %u frames, %u bytes; dropped %u; forwarded %u, dropped %u", "",
	            stats.tx_frames, stats.tx_bytes, stats.tx_dropped, stats.forwarded,
	            stats.forward_dropped);
}

static int cmd_link_stats(const struct shell *sh, size_t argc, char **argv)
{
	for (uint8_t link = 0; link < LINKS_MAX; link++) {
		print_link(sh, link);
	}
	shell_can_print(sh);
	const struct command_stats stats = command_stats_get();

	shell_print(sh,
	            "command frames %u, CAN frames %u, thermal reports %u (%u dropped), calls %u",
	            stats.frames, stats.can_frames, stats.thermal_reports, stats.reports_dropped,
	            stats.calls);
	return 0;
}

SHELL_STATIC_SUBCMD_SET_CREATE(
	link_commands,
	SHELL_CMD_ARG(stats, NULL, "Counters of every link", cmd_link_stats, 1, 0),
	SHELL_SUBCMD_SET_END);

SHELL_CMD_REGISTER(link, &link_commands, "Links", NULL);

/* --- reset, version --------------------------------------------------------------------------- */

static int cmd_reset_cause(const struct shell *sh, size_t argc, char **argv)
{
	char text[RESET_CAUSE_TEXT_MAX];

	reset_cause_text(text);
	shell_print(sh, "%s", text);
	return 0;
}

static int cmd_reset_now(const struct shell *sh, size_t argc, char **argv)
{
	light_off_now(devices.light);
	sys_reboot(SYS_REBOOT_COLD);
	return 0;
}

SHELL_STATIC_SUBCMD_SET_CREATE(
	reset_commands,
	SHELL_CMD_ARG(cause, NULL, "Why the light last started", cmd_reset_cause, 1, 0),
	SHELL_CMD_ARG(now, NULL, "Lamp off, and start anew", cmd_reset_now, 1, 0),
	SHELL_SUBCMD_SET_END);

SHELL_CMD_REGISTER(reset, &reset_commands, "Resets", NULL);

static int cmd_version(const struct shell *sh, size_t argc, char **argv)
{
	shell_print(sh, "Pharos %s", PHAROS_VERSION);
	return 0;
}

SHELL_CMD_ARG_REGISTER(version, NULL, "Version of the firmware", cmd_version, 1, 0);
