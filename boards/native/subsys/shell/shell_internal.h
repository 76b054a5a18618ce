/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Between the shell's own files. Unless said otherwise, the caller holds ctx->wr_mtx.
 *
 *	shell.c           a shell's life: init, thread, bytes in
 *	shell_out.c       bytes out; what is printed while a line is being typed
 *	shell_edit.c      keys and the line being typed
 *	shell_history.c   lines typed before
 *	shell_complete.c  the Tab key
 *	shell_parse.c     words, and the tree of commands
 *	shell_exec.c      from a line to a command's function; help
 */
#ifndef SHELL_INTERNAL_H
#define SHELL_INTERNAL_H

#include <zephyr/shell/shell.h>

/* --- shell_out.c --- */

/* Bytes as they are. Waits for the transport. */
void shell_out_raw(const struct shell *sh, const char *data, size_t len);
void shell_out_text(const struct shell *sh, const char *text);
/* '\n' becomes the shell's line end. */
void shell_out_cooked(const struct shell *sh, const char *data, size_t len);
void shell_out_color(const struct shell *sh, enum shell_vt100_color color);
/* Ends the line, unless nothing is on it. */
void shell_out_fresh_line(const struct shell *sh);
/* A line of log, without its end; above the line being typed. Takes wr_mtx itself. */
void shell_out_log(const struct shell *sh, enum shell_vt100_color color, const char *text,
                   size_t len);
/* Lets a command of another thread, or a line of log, print: takes the line being typed away, and
 * brings it back.
 */
void shell_out_begin(const struct shell *sh);
void shell_out_end(const struct shell *sh);

/* --- shell_edit.c --- */

/* A terminal is at the other end. */
bool shell_is_terminal(const struct shell *sh);
/* Sends the prompt and the line being typed, from the start of a row, and puts the cursor right. */
void shell_edit_show(const struct shell *sh);
/* Takes both off the screen; the cursor is where the prompt began. */
void shell_edit_hide(const struct shell *sh);
void shell_edit_set(const struct shell *sh, const char *text);
/* False: does not fit, nothing changed. */
bool shell_edit_insert(const struct shell *sh, const char *text, size_t len);
void shell_edit_bell(const struct shell *sh);
/* One byte from the transport. True: a line is complete in ctx->line. */
bool shell_edit_byte(const struct shell *sh, char byte);
/* After the line was executed. */
void shell_edit_reset(const struct shell *sh);
/* Asks the terminal for its width; the answer arrives as a key. */
void shell_edit_ask_width(const struct shell *sh);

/* --- shell_history.c --- */

void shell_history_add(struct shell_ctx *ctx, const char *line);
/* The line `back` before the newest (0), or NULL. */
const char *shell_history_get(const struct shell_ctx *ctx, int back);

/* --- shell_complete.c --- */

void shell_complete(const struct shell *sh);

/* --- shell_parse.c: any context, no lock --- */

enum shell_word_result {
	SHELL_WORD_FOUND,
	SHELL_WORD_END,
	SHELL_WORD_NOT_TERMINATED,
};

/* Takes the next word off *cursor, undoing quotes in place. Not terminated: *word is the quote. */
enum shell_word_result shell_word_next(char **cursor, char **word);
/* The index-th command below parent (NULL: root commands), in no particular order; NULL: no more.
 * space: for dynamic commands, lives as long as the result.
 */
const struct shell_static_entry *shell_cmd_get(const struct shell_static_entry *parent,
                                               size_t index, struct shell_static_entry *space);
const struct shell_static_entry *shell_cmd_find(const struct shell_static_entry *parent,
                                                const char *word, struct shell_static_entry *space);
/* Visits in alphabetical order: the first command that is after `after` ("" first) and begins with
 * prefix; NULL: no more.
 */
const struct shell_static_entry *shell_cmd_after(const struct shell_static_entry *parent,
                                                 const char *after, const char *prefix,
                                                 struct shell_static_entry *space);

/* --- shell_exec.c: without wr_mtx --- */

/* Runs ctx->command, which it splits in place. */
int shell_execute(const struct shell *sh);
void shell_help_commands(const struct shell *sh, const struct shell_static_entry *parent);

#endif
