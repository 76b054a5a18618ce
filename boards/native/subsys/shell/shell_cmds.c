/* SPDX-License-Identifier: Apache-2.0 */
/* The commands that every shell has. */
#include <errno.h>
#include <string.h>

#include "shell_internal.h"

static int cmd_clear(const struct shell *sh, size_t argc, char **argv)
{
	if (shell_is_terminal(sh)) {
		shell_fprintf(sh, SHELL_NORMAL, "\x1b[2J\x1b[H");
		sh->ctx->line_start = true;
	}
	return 0;
}

static int cmd_help(const struct shell *sh, size_t argc, char **argv)
{
	if (shell_is_terminal(sh)) {
		shell_print(
			sh,
			"Tab completes a command, or lists what fits. Up and down: history.\n"
			"Ctrl-A/E start/end, Alt-B/F word left/right, Ctrl-W word, Ctrl-U/K to\n"
			"start/end, Ctrl-C new line, Ctrl-L clear the screen.%s",
			sh->ctx->leave != NULL ? " Ctrl-D on an empty line leaves." : "");
	}
	shell_print(sh, "-h or --help after a command tells more about it. Commands:");
	shell_help_commands(sh, NULL);
	return 0;
}

static int cmd_history(const struct shell *sh, size_t argc, char **argv)
{
	const char *line;

	for (int i = 0; (line = shell_history_get(sh->ctx, i)) != NULL; i++) {
		shell_print(sh, "[%3d] %s", i, line);
	}
	return 0;
}

static int cmd_resize(const struct shell *sh, size_t argc, char **argv)
{
	if (!shell_is_terminal(sh)) {
		shell_error(sh, "not a terminal");
		return -ENOEXEC;
	}
	shell_edit_ask_width(sh);
	return 0;
}

static int cmd_retval(const struct shell *sh, size_t argc, char **argv)
{
	shell_print(sh, "%d", shell_get_return_value(sh));
	return 0;
}

static int on_off(const struct shell *sh, const char *word, int (*set)(const struct shell *, bool))
{
	(void)set(sh, strcmp(word, "on") == 0);
	return 0;
}

static int cmd_colors(const struct shell *sh, size_t argc, char **argv)
{
	return on_off(sh, argv[0], shell_use_colors_set);
}

static int cmd_echo(const struct shell *sh, size_t argc, char **argv)
{
	return on_off(sh, argv[0], shell_echo_set);
}

SHELL_STATIC_SUBCMD_SET_CREATE(colors_commands,
	SHELL_CMD_ARG(off, NULL, "Without colours", cmd_colors, 1, 0),
	SHELL_CMD_ARG(on, NULL, "With colours", cmd_colors, 1, 0),
	SHELL_SUBCMD_SET_END
);
SHELL_STATIC_SUBCMD_SET_CREATE(echo_commands,
	SHELL_CMD_ARG(off, NULL, "No echo, no prompt: for programs", cmd_echo, 1, 0),
	SHELL_CMD_ARG(on, NULL, "For people", cmd_echo, 1, 0),
	SHELL_SUBCMD_SET_END
);
SHELL_STATIC_SUBCMD_SET_CREATE(shell_commands,
	SHELL_CMD(colors, &colors_commands, "Colours", NULL),
	SHELL_CMD(echo, &echo_commands, "Echo and prompt", NULL),
	SHELL_SUBCMD_SET_END
);

SHELL_CMD_ARG_REGISTER(clear, NULL, "Clear the screen", cmd_clear, 1, 0);
SHELL_CMD_ARG_REGISTER(help, NULL, "List the commands", cmd_help, 1, 0);
SHELL_CMD_ARG_REGISTER(history, NULL, "Lines typed before, newest first", cmd_history, 1, 0);
SHELL_CMD_ARG_REGISTER(resize, NULL, "Ask the terminal for its width again", cmd_resize, 1, 0);
SHELL_CMD_ARG_REGISTER(retval, NULL, "What the last command returned", cmd_retval, 1, 0);
SHELL_CMD_REGISTER(shell, &shell_commands, "This shell", NULL);
