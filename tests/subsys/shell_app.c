/* SPDX-License-Identifier: Apache-2.0 */
/* A program that is nothing but a shell, for test_terminal.py. */
#include <stdlib.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/settings/settings.h>
#include <zephyr/shell/shell.h>

#include "host/say.h"
#include "kernel/port.h"

LOG_MODULE_REGISTER(shell_app, LOG_LEVEL_DBG);

static int cmd_echo(const struct shell *sh, size_t argc, char **argv)
{
	for (size_t i = 1; i < argc; i++) {
		shell_print(sh, "<%s>", argv[i]);
	}
	return 0;
}

static void log_later(struct k_timer *timer)
{
	LOG_WRN("from a timer");
}

static K_TIMER_DEFINE(later, log_later, NULL);

static int cmd_log(const struct shell *sh, size_t argc, char **argv)
{
	k_timer_start(&later, K_MSEC(atoi(argv[1])), K_NO_WAIT);
	return 0;
}

static int cmd_error(const struct shell *sh, size_t argc, char **argv)
{
	shell_error(sh, "in red");
	return 0;
}

static int cmd_exit(const struct shell *sh, size_t argc, char **argv)
{
	/* What was printed goes out first. */
	k_sleep(K_MSEC(1));
	port_exit(0);
}

static int cmd_save(const struct shell *sh, size_t argc, char **argv)
{
	const int rc = settings_save_one(argv[1], argv[2], strlen(argv[2]));

	shell_print(sh, "saved: %d", rc);
	return rc;
}

SHELL_STATIC_SUBCMD_SET_CREATE(tree_commands,
	SHELL_CMD(branch, NULL, "Long", NULL),
	SHELL_CMD(brook, NULL, "Wet", NULL),
	SHELL_CMD_ARG(leaf, NULL, "Green", cmd_echo, 1, 3),
	SHELL_SUBCMD_SET_END
);
SHELL_CMD_REGISTER(say, NULL, "Prints its words", cmd_echo);
SHELL_CMD_ARG_REGISTER(later, NULL, "<ms>: a line of log after that time", cmd_log, 2, 0);
SHELL_CMD_REGISTER(fail, NULL, "An error", cmd_error);
SHELL_CMD_REGISTER(exit, NULL, "Ends the process", cmd_exit);
SHELL_CMD_ARG_REGISTER(save, NULL, "<name> <value>", cmd_save, 3, 0);
SHELL_CMD_REGISTER(tree, &tree_commands, "A tree", NULL);

int main(void)
{
	/* To stderr: what a slow machine makes the host say is no part of the screen. */
	host_say_through(NULL);
	(void)settings_subsys_init();
	k_sleep(K_FOREVER);
	return 0;
}
