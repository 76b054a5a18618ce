/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <string.h>

#include "shell_internal.h"

/* What has been found so far while walking along a command line. */
struct search {
	const struct shell_static_entry *parent;
	struct shell_static_entry space;
	struct shell_static_entry handler; /* the last word with a function */
	struct shell_static_entry help;    /* the last word with a help text */
	size_t handler_at;
	size_t raw_after; /* words before the raw rest; SIZE_MAX: none */
	bool done;        /* what follows are arguments */
};

static bool is_help_request(const char *word)
{
	return strcmp(word, "-h") == 0 || strcmp(word, "--help") == 0;
}

void shell_help_commands(const struct shell *sh, const struct shell_static_entry *parent)
{
	const struct shell_static_entry *entry;
	struct shell_static_entry space;
	const char *after = "";
	size_t width = 0;

	for (size_t i = 0; (entry = shell_cmd_get(parent, i, &space)) != NULL; i++) {
		const size_t len = strlen(entry->syntax);

		width = len > width ? len : width;
	}
	while ((entry = shell_cmd_after(parent, after, "", &space)) != NULL) {
		const char *line = entry->help == NULL ? "" : entry->help;
		const char *end;

		shell_fprintf(sh, SHELL_NORMAL, "  %-*s", *line == '\0' ? 0 : (int)width + 2,
		              entry->syntax);
		/* A help text of several lines stays in its column. */
		for (; (end = strchr(line, '\n')) != NULL; line = end + 1) {
			shell_fprintf(sh, SHELL_NORMAL, "%.*s\n%*s", (int)(end - line), line,
			              (int)width + 4, "");
		}
		shell_print(sh, "%s", line);
		after = entry->syntax;
	}
}

void shell_help(const struct shell *sh)
{
	const struct shell_static_entry *active = &sh->ctx->active_cmd;
	struct shell_static_entry space;

	if (active->help != NULL) {
		shell_print(sh, "%s - %s", active->syntax, active->help);
	}
	if (shell_cmd_get(active, 0, &space) != NULL) {
		shell_print(sh, "Subcommands:");
		shell_help_commands(sh, active);
	}
}

static int print_help_of(const struct shell *sh, const struct shell_static_entry *entry)
{
	if (entry->help == NULL) {
		shell_error(sh, "Please specify a subcommand.");
		return -ENOEXEC;
	}
	sh->ctx->active_cmd = *entry;
	shell_help(sh);
	return SHELL_CMD_HELP_PRINTED;
}

static int check_count(const struct shell *sh, const struct shell_static_entry *entry, size_t argc)
{
	const size_t mandatory = entry->args.mandatory;
	size_t most = mandatory + entry->args.optional;

	if (entry->args.optional == SHELL_OPT_ARG_RAW) {
		most = mandatory + 1;
	} else if (entry->args.optional == SHELL_OPT_ARG_CHECK_SKIP) {
		most = SIZE_MAX;
	}
	if (mandatory == 0 || (argc >= mandatory && argc <= most)) {
		return 0;
	}
	shell_error(sh, "%s: wrong parameter count", entry->syntax);
	if (entry->help != NULL) {
		shell_help(sh);
	}
	return -EINVAL;
}

/* One more word. 0, or what shell_execute() returns. */
static int take_word(const struct shell *sh, struct search *search, const char *word, size_t at)
{
	const struct shell_static_entry *entry;

	if (at > 0 && is_help_request(word)) {
		return print_help_of(sh, &search->help);
	}
	if (search->done) {
		return 0;
	}
	entry = shell_cmd_find(search->parent, word, &search->space);
	if (entry == NULL) {
		search->done = true;
		if (at == 0) {
			shell_error(sh, "%s: command not found", word);
			return -ENOEXEC;
		}
		if (search->handler.handler == NULL) {
			shell_error(sh, "%s: unknown subcommand", word);
		}
		return 0;
	}
	if (entry->handler != NULL) {
		search->handler = *entry;
		search->handler_at = at;
		if (entry->subcmd == NULL && entry->args.optional == SHELL_OPT_ARG_RAW) {
			search->raw_after = at + entry->args.mandatory;
		}
	}
	if (entry->help != NULL) {
		search->help = *entry;
	}
	search->parent = entry;
	return 0;
}

static int call(const struct shell *sh, const struct search *search, size_t argc, char **argv)
{
	int rc;

	if (search->handler.handler == NULL) {
		return print_help_of(sh, &search->help);
	}
	sh->ctx->active_cmd = search->handler;
	rc = check_count(sh, &search->handler, argc - search->handler_at);
	if (rc == 0) {
		rc = search->handler.handler(sh, argc - search->handler_at,
		                             &argv[search->handler_at]);
	}
	return rc;
}

int shell_execute(const struct shell *sh)
{
	char *argv[CONFIG_SHELL_ARGC_MAX + 1] = {NULL};
	struct search search = {.raw_after = SIZE_MAX};
	char *cursor = sh->ctx->command;
	enum shell_word_result result;
	size_t argc = 0;
	char *word = NULL;
	int rc;

	for (;;) {
		if (argc >= search.raw_after) {
			cursor += strspn(cursor, " \t");
			if (*cursor != '\0') {
				argv[argc++] = cursor;
			}
			break;
		}
		result = shell_word_next(&cursor, &word);
		if (result == SHELL_WORD_END) {
			break;
		}
		if (result == SHELL_WORD_NOT_TERMINATED) {
			shell_error(sh, "not terminated: %s", word);
			return -ENOEXEC;
		}
		if (argc == CONFIG_SHELL_ARGC_MAX) {
			shell_error(sh, "too many parameters: at most %d words",
			            CONFIG_SHELL_ARGC_MAX);
			return -ENOEXEC;
		}
		rc = take_word(sh, &search, word, argc);
		if (rc != 0) {
			return rc;
		}
		argv[argc++] = word;
	}
	return argc == 0 ? -ENOEXEC : call(sh, &search, argc, argv);
}
