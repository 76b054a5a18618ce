/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "shell_internal.h"

/* Follows the words before the last one; *prefix is the last word as far as it was typed. False:
 * what stands there is no command that has subcommands.
 */
static bool find_parent(char *text, const struct shell_static_entry **parent,
                        struct shell_static_entry *space, const char **prefix)
{
	const size_t len = strlen(text);
	const bool new_word = len == 0 || text[len - 1] == ' ';
	char *cursor = text;
	char *word = NULL;

	*parent = NULL;
	*prefix = "";
	while (shell_word_next(&cursor, &word) == SHELL_WORD_FOUND) {
		if (*cursor == '\0' && !new_word) {
			*prefix = word;
			return true;
		}
		*parent = shell_cmd_find(*parent, word, space);
		if (*parent == NULL) {
			return false;
		}
		if ((*parent)->subcmd == NULL) {
			return false;
		}
	}
	return true;
}

static void list_matches(const struct shell *sh, const struct shell_static_entry *parent,
                         const char *prefix, size_t longest)
{
	const size_t width = longest + 2;
	const size_t per_row = sh->ctx->columns / width > 0 ? sh->ctx->columns / width : 1;
	const struct shell_static_entry *entry;
	struct shell_static_entry space;
	const char *after = "";
	size_t at = 0;

	while ((entry = shell_cmd_after(parent, after, prefix, &space)) != NULL) {
		const size_t len = strlen(entry->syntax);

		if (at > 0 && at % per_row == 0) {
			shell_out_cooked(sh, "\n", 1);
		}
		shell_out_color(sh, SHELL_OPTION);
		shell_out_raw(sh, entry->syntax, len);
		shell_out_color(sh, SHELL_NORMAL);
		at++;
		for (size_t i = len; i < width && at % per_row != 0; i++) {
			shell_out_raw(sh, " ", 1);
		}
		after = entry->syntax;
	}
	shell_out_cooked(sh, "\n", 1);
}

void shell_complete(const struct shell *sh)
{
	struct shell_ctx *ctx = sh->ctx;
	const struct shell_static_entry *parent;
	const struct shell_static_entry *entry;
	struct shell_static_entry parent_space;
	struct shell_static_entry space;
	const char *prefix;
	const char *first = NULL;
	const char *after = "";
	size_t common = 0;
	size_t longest = 0;
	size_t count = 0;

	/* ctx->command is free while a line is being typed. */
	memcpy(ctx->command, ctx->line, ctx->pos);
	ctx->command[ctx->pos] = '\0';
	if (!find_parent(ctx->command, &parent, &parent_space, &prefix)) {
		shell_edit_bell(sh);
		return;
	}
	while ((entry = shell_cmd_after(parent, after, prefix, &space)) != NULL) {
		const size_t len = strlen(entry->syntax);

		if (count++ == 0) {
			first = entry->syntax;
			common = len;
		}
		while (strncmp(first, entry->syntax, common) != 0) {
			common--;
		}
		longest = len > longest ? len : longest;
		after = entry->syntax;
	}
	if (count == 0) {
		shell_edit_bell(sh);
		return;
	}
	if (count > 1) {
		const uint16_t pos = ctx->pos;

		ctx->pos = ctx->len;
		shell_edit_show(sh);
		shell_out_fresh_line(sh);
		list_matches(sh, parent, prefix, longest);
		ctx->pos = pos;
		ctx->cursor_row = 0;
		ctx->shown = false;
	}
	(void)shell_edit_insert(sh, &first[strlen(prefix)], common - strlen(prefix));
	if (count == 1 && ctx->line[ctx->pos] != ' ') {
		(void)shell_edit_insert(sh, " ", 1);
	}
	shell_edit_show(sh);
}
