/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command startup: what each step of start-up came to.
 */
#include <zephyr/shell/shell.h>

#include "threads/startup.h"
#include "threads/supervisor.h"

static void print_step(const struct shell *sh, enum startup_step step)
{
	const int result = startup_result(step);

	if (result < 0) {
		shell_error(sh, "%-14serror %d", startup_name(step), result);
	} else if (step == STARTUP_WATCHDOG && result == 0) {
		shell_print(sh, "%-14sok, %u ms", startup_name(step), supervisor_watchdog_ms());
	} else if (result != STARTUP_ABSENT) {
		shell_print(sh, "%-14s%s", startup_name(step), result == 0 ? "ok" : "not reached");
	}
}

static int cmd_startup(const struct shell *sh, size_t argc, char **argv)
{
	for (int step = 0; step < STARTUP_STEPS; step++) {
		print_step(sh, (enum startup_step)step);
	}
	if (!startup_allows_light()) {
		shell_error(sh, "the lamp stays dark until the next reset");
	}
	return 0;
}

SHELL_CMD_ARG_REGISTER(startup, NULL, "What each step of the start came to", cmd_startup, 1, 0);
