/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command for the gimbal: gimbal.
 */
#include <errno.h>

#include <zephyr/shell/shell.h>

#include "core/decimal.h"
#include "threads/clock.h"
#include "threads/mavlink_node.h"
#include "threads/servos.h"
#include "threads/shell/call.h"
#include "threads/shell/say.h"

struct point_request {
	struct gimbal_event event;
	enum device_result result;
};

static int point(struct pharos_device *device, void *argument)
{
	struct point_request *const request = argument;

	request->result = pharos_device_point(device, clock_now_us(), &shell_who, &request->event);
	return 0;
}

static int say_absent(const struct shell *sh)
{
	shell_error(sh, "there is no gimbal (see: param get GMB_ENABLE)");
	return -ENODEV;
}

/* Carries the event out and says what became of it. */
static int gimbal_command(const struct shell *sh, const struct gimbal_event *event)
{
	struct point_request request = {.event = *event};

	if (!shell_call(sh, point, &request, NULL)) {
		return -EAGAIN;
	}
	if (request.result == DEVICE_DENIED) {
		shell_error(sh, "out of range; nothing changed (-360 to 360 degrees)");
		return -EINVAL;
	}
	if (request.result == DEVICE_ABSENT) {
		return say_absent(sh);
	}
	return say_result(sh, request.result, "gimbal status");
}

static int aim(const struct shell *sh, enum gimbal_axis_id axis, char **argv)
{
	struct gimbal_event event = {.kind = GIMBAL_EVENT_AIM};
	int64_t mdeg;

	if (!decimal_parse_exact(argv[1], MDEG_DECIMALS, &mdeg) || mdeg < INT32_MIN ||
	    mdeg > INT32_MAX) {
		shell_error(sh, "%s: '%s' is not a number of degrees, such as -20 or 7.5", argv[0],
		            argv[1]);
		return -EINVAL;
	}
	event.aim[axis] = (struct gimbal_aim){.kind = GIMBAL_ANGLE, .value = (int32_t)mdeg};
	return gimbal_command(sh, &event);
}

static int cmd_gimbal_pan(const struct shell *sh, size_t argc, char **argv)
{
	return aim(sh, GIMBAL_PAN, argv);
}

static int cmd_gimbal_tilt(const struct shell *sh, size_t argc, char **argv)
{
	return aim(sh, GIMBAL_TILT, argv);
}

static int cmd_gimbal_neutral(const struct shell *sh, size_t argc, char **argv)
{
	const struct gimbal_event event = {.kind = GIMBAL_EVENT_NEUTRAL};

	return gimbal_command(sh, &event);
}

static int cmd_gimbal_retract(const struct shell *sh, size_t argc, char **argv)
{
	const struct gimbal_event event = {.kind = GIMBAL_EVENT_RETRACT};

	return gimbal_command(sh, &event);
}

struct status {
	bool has_gimbal;
	struct gimbal gimbal;
	enum arbiter_source commander;
	uint32_t servo_errors;
	struct mavlink_gimbal_stats mavlink;
};

static int copy_status(struct pharos_device *device, void *argument)
{
	struct status *const status = argument;

	status->has_gimbal = device->has_gimbal;
	status->gimbal = device->gimbal;
	status->commander = device->gimbal_arbiter.commander;
	status->servo_errors = servos_errors();
	status->mavlink = *mavlink_node_gimbal_stats();
	return 0;
}

static void print_axis(const struct shell *sh, const char *label, int32_t mdeg, bool locked,
                       bool at_limit)
{
	char text[DECIMAL_TEXT_MAX];

	(void)decimal_print(text, mdeg, MDEG_DECIMALS);
	shell_print(sh, "%-14s%s deg%s%s", label, text, locked ? ", locked" : "",
	            at_limit ? ", at its limit" : "");
}

static int cmd_gimbal_status(const struct shell *sh, size_t argc, char **argv)
{
	struct status status;
	const struct gimbal *const gimbal = &status.gimbal;

	if (!shell_call(sh, copy_status, &status, NULL)) {
		return -EAGAIN;
	}
	if (!status.has_gimbal) {
		return say_absent(sh);
	}

	const struct gimbal_report report = gimbal_report(gimbal, clock_now_us());
	char heading[DECIMAL_TEXT_MAX];

	(void)decimal_print(heading, report.heading_mdeg, MDEG_DECIMALS);
	shell_print(sh, "%-14s%s", "mode", gimbal_mode_name(report.mode));
	print_axis(sh, "pan", report.own.yaw_mdeg, report.pan_locked, report.at_limit[GIMBAL_PAN]);
	print_axis(sh, "tilt", report.own.pitch_mdeg, report.tilt_locked,
	           report.at_limit[GIMBAL_TILT]);
	shell_print(sh, "%-14s%s", "heading", report.heading_known ? heading : "not known");
	if (report.attitude_lost) {
		shell_print(sh, "%-14sholds still without the vehicle's attitude", "");
	}
	shell_print(sh, "%-14s%s", "commander", arbiter_source_name(status.commander));
	shell_print(sh, "%-14s%s, %u errors", "servos", report.fault ? "FAULT" : "ok",
	            status.servo_errors);
	shell_print(sh, "%-14s%u; refused %u, rates ended %u, attitude lost %u", "commands",
	            gimbal->stats.accepted, gimbal->stats.denied, gimbal->stats.rate_timeouts,
	            gimbal->stats.attitude_losses);
	shell_print(sh, "%-14s%u set, %u refused, %u without meaning, %u not of the manager",
	            "mavlink", status.mavlink.set, status.mavlink.refused, status.mavlink.bad,
	            status.mavlink.foreign);
	shell_print(sh, "%-14sasked for data %u", "", status.mavlink.requests);
	return 0;
}

SHELL_STATIC_SUBCMD_SET_CREATE(
	gimbal_commands, SHELL_CMD_ARG(neutral, NULL, "To its neutral position", cmd_gimbal_neutral, 1, 0),
	SHELL_CMD_ARG(pan, NULL, "DEGREES  from straight ahead, right is positive", cmd_gimbal_pan, 2, 0),
	SHELL_CMD_ARG(retract, NULL, "To its retracted position", cmd_gimbal_retract, 1, 0),
	SHELL_CMD_ARG(status, NULL, "Where it points, and who says so", cmd_gimbal_status, 1, 0),
	SHELL_CMD_ARG(tilt, NULL, "DEGREES  from level, up is positive", cmd_gimbal_tilt, 2, 0),
	SHELL_SUBCMD_SET_END);

SHELL_CMD_REGISTER(gimbal, &gimbal_commands, "The gimbal", NULL);
