/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "shell_internal.h"

static bool is_blank(char c)
{
	return c == ' ' || c == '\t';
}

enum shell_word_result shell_word_next(char **cursor, char **word)
{
	char *in = *cursor;
	char *out;
	char quote = '\0';

	while (is_blank(*in)) {
		in++;
	}
	if (*in == '\0') {
		*cursor = in;
		return SHELL_WORD_END;
	}
	*word = in;
	out = in;
	for (; *in != '\0' && (quote != '\0' || !is_blank(*in)); in++) {
		if (quote == '\0' && (*in == '"' || *in == '\'')) {
			quote = *in;
		} else if (quote != '\0' && *in == quote) {
			quote = '\0';
		} else if (*in == '\\' && quote != '\'' && in[1] != '\0') {
			in++;
			*out++ = *in;
		} else {
			*out++ = *in;
		}
	}
	/* Step over the blank before the terminator takes its place. */
	*cursor = *in == '\0' ? in : in + 1;
	*out = '\0';
	if (quote != '\0') {
		(*word)[0] = quote;
		(*word)[1] = '\0';
		return SHELL_WORD_NOT_TERMINATED;
	}
	return SHELL_WORD_FOUND;
}

static bool is_dynamic(const union shell_cmd_entry *set)
{
	TYPE_SECTION_FOREACH(const union shell_cmd_entry, shell_dynamic_subcmds, dynamic)
	{
		if (dynamic == set) {
			return true;
		}
	}
	return false;
}

static const struct shell_static_entry *root_get(size_t index)
{
	size_t at = 0;

	TYPE_SECTION_FOREACH(const union shell_cmd_entry, shell_root_cmds, root)
	{
		if (at++ == index) {
			return root->entry;
		}
	}
	return NULL;
}

const struct shell_static_entry *shell_cmd_get(const struct shell_static_entry *parent,
                                               size_t index, struct shell_static_entry *space)
{
	if (parent == NULL) {
		return root_get(index);
	}
	if (parent->subcmd == NULL) {
		return NULL;
	}
	if (is_dynamic(parent->subcmd)) {
		memset(space, 0, sizeof(*space));
		parent->subcmd->dynamic_get(index, space);
		return space->syntax == NULL ? NULL : space;
	}
	return parent->subcmd->entry[index].syntax == NULL ? NULL : &parent->subcmd->entry[index];
}

const struct shell_static_entry *shell_cmd_find(const struct shell_static_entry *parent,
                                                const char *word, struct shell_static_entry *space)
{
	const struct shell_static_entry *entry;

	for (size_t i = 0; (entry = shell_cmd_get(parent, i, space)) != NULL; i++) {
		if (entry->syntax[0] != '\0' && strcmp(entry->syntax, word) == 0) {
			return entry;
		}
	}
	return NULL;
}

const struct shell_static_entry *shell_cmd_after(const struct shell_static_entry *parent,
                                                 const char *after, const char *prefix,
                                                 struct shell_static_entry *space)
{
	const struct shell_static_entry *entry;
	struct shell_static_entry found = {0};
	size_t found_at = 0;

	for (size_t i = 0; (entry = shell_cmd_get(parent, i, space)) != NULL; i++) {
		if (strncmp(entry->syntax, prefix, strlen(prefix)) != 0 ||
		    strcmp(entry->syntax, after) <= 0) {
			continue;
		}
		if (found.syntax == NULL || strcmp(entry->syntax, found.syntax) < 0) {
			found = *entry;
			found_at = i;
		}
	}
	return found.syntax == NULL ? NULL : shell_cmd_get(parent, found_at, space);
}
