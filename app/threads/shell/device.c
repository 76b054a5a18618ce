/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell commands for the device as a whole: thermal, link, reset, version.
 */
#include <errno.h>

#include <zephyr/kernel.h>
#include <zephyr/shell/shell.h>
#include <zephyr/sys/reboot.h>

#include <pharos/drivers/light.h>

#include "threads/devices.h"
#include "threads/links.h"
#include "threads/reset_cause.h"
#include "threads/shell/call.h"
#include "threads/shell/can.h"
#include "threads/shell/names.h"
#include "threads/shell/say.h"
#include "threads/thermal.h"
#include "version.h"

/* --- thermal ---------------------------------------------------------------------------------- */

static int cmd_thermal(const struct shell *sh, size_t argc, char **argv)
{
	struct thermal thermal;

	thermal_thread_get(&thermal);
	const struct thermal_report *const report = &thermal.report;

	shell_print(sh, "%-14s%s", "state", thermal_state_name(report->state));
	if (report->temp_valid) {
		say_fixed(sh, "temperature", report->temp_mdegc, 3, "degC");
		shell_print(sh, "%-14sok", "sensor");
	} else {
		shell_print(sh, "%-14s%s", "sensor",
		            report->sensor == THERMAL_SENSOR_WAITING
		                    ? "waiting"
		                    : thermal_fault_name(report->fault));
	}
	say_fixed(sh, "limit", report->limit_ppm, PPM_PER_PERCENT_DECIMALS, "% of full power");
	say_fixed(sh, "throttle at", thermal.config.throttle_mdegc, 3, "degC");
	say_fixed(sh, "shutdown at", thermal.config.shutdown_mdegc, 3, "degC");
	say_fixed(sh, "recover below", thermal.config.recover_mdegc, 3, "degC");
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

	if (links_stats_get(link, &stats) != 0) {
		return;
	}
	shell_print(sh,
	            "%-7s rx %u frames, %u bytes; overruns %u, line errors %u, bad frames %u, "
	            "skipped bytes %u",
	            links_name(link), stats.rx_frames, stats.rx_bytes, stats.rx_overruns,
	            stats.rx_errors, stats.framing.crc_errors, stats.framing.skipped_bytes);
	shell_print(sh, "%-7s tx %u frames, %u bytes; dropped %u; forwarded %u, dropped %u", "",
	            stats.tx_frames, stats.tx_bytes, stats.tx_dropped, stats.forwarded,
	            stats.forward_dropped);
}

/* For the Tab key: those that there are. */
static void link_get(size_t index, struct shell_static_entry *entry)
{
	struct link_stats stats;

	*entry = (struct shell_static_entry){.syntax = NULL};
	for (uint8_t link = 0; link < LINKS_MAX; link++) {
		if (links_stats_get(link, &stats) == 0 && index-- == 0) {
			entry->syntax = links_name(link);
			return;
		}
	}
}

SHELL_DYNAMIC_CMD_CREATE(link_names, link_get);

static int print_one(const struct shell *sh, const char *name)
{
	struct link_stats stats;

	for (uint8_t link = 0; link < LINKS_MAX; link++) {
		if (names_equal(links_name(link), name) && links_stats_get(link, &stats) == 0) {
			print_link(sh, link);
			return 0;
		}
	}
	shell_error(sh, "no link '%s' (see: link stats)", name);
	return -ENODEV;
}

static int cmd_link_stats(const struct shell *sh, size_t argc, char **argv)
{
	if (argc > 1) {
		return print_one(sh, argv[1]);
	}
	for (uint8_t link = 0; link < LINKS_MAX; link++) {
		print_link(sh, link);
	}
	shell_can_print(sh);
	const struct inbox_stats stats = inbox_stats_get();

	shell_print(sh,
	            "command frames %u, CAN frames %u, thermal reports %u (%u dropped), calls %u",
	            stats.frames, stats.can_frames, stats.thermal_reports, stats.reports_dropped,
	            stats.calls);
	return 0;
}

SHELL_STATIC_SUBCMD_SET_CREATE(
	link_commands,
	SHELL_CMD_ARG(stats, &link_names, "[LINK]  counters of every link, or of one", cmd_link_stats,
		      1, 1),
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
