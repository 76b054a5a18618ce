/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command for the gimbal: gimbal.
 */
#include <errno.h>

#include <zephyr/shell/shell.h>

#include "threads/clock.h"
#include "threads/fixed.h"
#include "threads/mavlink_node.h"
#include "threads/shell_call.h"

#define MDEG_DECIMALS 3

struct point_request {
	struct gimbal_event event;
	enum gimbal_result result;
	enum arbiter_verdict verdict;
};

static int point(struct command *command, void *argument)
{
	struct point_request *const request = argument;

	request->verdict =
		command_point(command, ARBITER_SOURCE_SHELL, &request->event, &request->result);
	return 0;
}

/* Carries the event out and says what became of it. */
static int gimbal_command(const struct shell *sh, const struct gimbal_event *event)
{
	struct point_request request = {.event = *event};

	if (!shell_call(sh, point, &request, NULL)) {
		return -EAGAIN;
	}
	if (request.verdict == ARBITER_EXCLUDED) {
		shell_error(sh, "the shell may not command (see: param get LGT_SRC_EXCL)");
		return -EACCES;
	}
	if (request.verdict == ARBITER_OUTRANKED) {
		shell_error(sh, "not now: another source is in command (see: gimbal status)");
		return -EBUSY;
	}
	switch (request.result) {
	case GIMBAL_ACCEPTED:
		shell_print(sh, "ok");
		return 0;
	case GIMBAL_DENIED:
		shell_error(sh, "out of range; nothing changed (-360 to 360 degrees)");
		return -EINVAL;
	case GIMBAL_ABSENT:
		shell_error(sh, "there is no gimbal (see: param get GMB_ENABLE)");
		return -ENODEV;
	}
	return -EINVAL;
}

static int aim(const struct shell *sh, enum gimbal_axis_id axis, char **argv)
{
	struct gimbal_event event = {.kind = GIMBAL_EVENT_AIM};
	int64_t mdeg;

	if (!fixed_parse(argv[1], MDEG_DECIMALS, &mdeg) || mdeg < INT32_MIN || mdeg > INT32_MAX) {
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
	struct gimbal_node node;
	struct mavlink_gimbal_stats mavlink;
};

static int copy_status(struct command *command, void *argument)
{
	struct status *const status = argument;

	status->node = command->gimbal;
	status->mavlink = *mavlink_node_gimbal_stats();
	return 0;
}

static void print_axis(const struct shell *sh, const char *label, int32_t mdeg, bool locked,
                       bool at_limit)
{
	char text[FIXED_TEXT_MAX];

	fixed_format(text, mdeg, MDEG_DECIMALS);
	shell_print(sh, "%-14s%s deg%s%s", label, text, locked ? ", locked" : "",
	            at_limit ? ", at its limit" : "");
}

static int cmd_gimbal_status(const struct shell *sh, size_t argc, char **argv)
{
	struct status status;
	const struct gimbal_node *const node = &status.node;

	if (!shell_call(sh, copy_status, &status, NULL)) {
		return -EAGAIN;
	}
	if (!node->active) {
		shell_error(sh, "there is no gimbal (see: param get GMB_ENABLE)");
		return -ENODEV;
	}

	const struct gimbal_report report = gimbal_report(&node->gimbal, clock_now_us());
	char heading[FIXED_TEXT_MAX];

	fixed_format(heading, report.heading_mdeg, MDEG_DECIMALS);
	shell_print(sh, "%-14s%s", "mode", gimbal_mode_name(report.mode));
	print_axis(sh, "pan", report.own.yaw_mdeg, report.pan_locked, report.at_limit[GIMBAL_PAN]);
	print_axis(sh, "tilt", report.own.pitch_mdeg, report.tilt_locked,
	           report.at_limit[GIMBAL_TILT]);
	shell_print(sh, "%-14s%s", "heading", report.heading_known ? heading : "not known");
	if (report.attitude_lost) {
		shell_print(sh, "%-14sholds still without the vehicle's attitude", "");
	}
	shell_print(sh, "%-14s%s", "commander", arbiter_source_name(node->arbiter.commander));
	shell_print(sh, "%-14s%s, %u errors", "servos", report.fault ? "FAULT" : "ok",
	            node->servo_errors);
	shell_print(sh, "%-14s%u; refused %u, rates ended %u, attitude lost %u", "commands",
	            node->gimbal.stats.accepted, node->gimbal.stats.denied,
	            node->gimbal.stats.rate_timeouts, node->gimbal.stats.attitude_losses);
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
