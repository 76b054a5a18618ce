/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The screen is redrawn from the prompt after every key but the commonest (a character at the end
 * of the line), so that what it shows does not depend on what it showed before.
 */
#include <stdio.h>
#include <string.h>

#include "shell_internal.h"

#define CTRL(letter) ((letter)&0x1f)
#define BACKSPACE    0x08
#define DELETE       0x7f
#define ESCAPE       0x1b

/* A terminal says this as the answer to "where is the cursor", sent to the far right. */
#define KEY_ARG_MAX 9999

bool shell_is_terminal(const struct shell *sh)
{
	return sh->ctx->cfg.echo && sh->ctx->cfg.use_vt100;
}

void shell_edit_bell(const struct shell *sh)
{
	if (shell_is_terminal(sh)) {
		shell_out_raw(sh, "\a", 1);
	}
}

static void move(const struct shell *sh, unsigned int count, char direction)
{
	char sequence[16];

	if (count > 0) {
		(void)snprintf(sequence, sizeof(sequence), "\x1b[%u%c", count, direction);
		shell_out_text(sh, sequence);
	}
}

void shell_edit_hide(const struct shell *sh)
{
	struct shell_ctx *ctx = sh->ctx;

	if (!ctx->shown) {
		return;
	}
	move(sh, ctx->cursor_row, 'A');
	shell_out_text(sh, "\r\x1b[J");
	ctx->cursor_row = 0;
	ctx->shown = false;
	ctx->line_start = true;
}

void shell_edit_show(const struct shell *sh)
{
	struct shell_ctx *ctx = sh->ctx;
	const unsigned int prompt = (unsigned int)strlen(ctx->prompt);
	const unsigned int end = prompt + ctx->len;
	const unsigned int cursor = prompt + ctx->pos;

	shell_edit_hide(sh);
	shell_out_color(sh, SHELL_INFO);
	shell_out_text(sh, ctx->prompt);
	shell_out_color(sh, SHELL_NORMAL);
	shell_out_raw(sh, ctx->line, ctx->len);
	if (end > 0 && end % ctx->columns == 0) {
		/* The terminal waits with the wrap until a character comes. */
		shell_out_raw(sh, "\r\n", 2);
	}
	if (cursor != end) {
		move(sh, end / ctx->columns - cursor / ctx->columns, 'A');
		shell_out_raw(sh, "\r", 1);
		move(sh, cursor % ctx->columns, 'C');
	}
	ctx->cursor_row = (uint16_t)(cursor / ctx->columns);
	ctx->shown = true;
	ctx->line_start = end % ctx->columns == 0;
}

void shell_edit_ask_width(const struct shell *sh)
{
	/* Save the cursor, go as far right as it gets, ask, come back. */
	shell_out_text(sh, "\x1b[s\x1b[999C\x1b[6n\x1b[u");
}

void shell_edit_set(const struct shell *sh, const char *text)
{
	struct shell_ctx *ctx = sh->ctx;

	ctx->len = (uint16_t)strnlen(text, sizeof(ctx->line) - 1);
	memmove(ctx->line, text, ctx->len);
	ctx->line[ctx->len] = '\0';
	ctx->pos = ctx->len;
}

bool shell_edit_insert(const struct shell *sh, const char *text, size_t len)
{
	struct shell_ctx *ctx = sh->ctx;

	if (ctx->len + len >= sizeof(ctx->line)) {
		return false;
	}
	memmove(&ctx->line[ctx->pos + len], &ctx->line[ctx->pos], ctx->len - ctx->pos + 1u);
	memcpy(&ctx->line[ctx->pos], text, len);
	ctx->len += (uint16_t)len;
	ctx->pos += (uint16_t)len;
	return true;
}

/* Takes [from, to) out of the line; the cursor is left at from. */
static void cut(struct shell_ctx *ctx, size_t from, size_t to)
{
	memmove(&ctx->line[from], &ctx->line[to], ctx->len - to + 1);
	ctx->len -= (uint16_t)(to - from);
	ctx->pos = (uint16_t)from;
}

static uint16_t word_left(const struct shell_ctx *ctx)
{
	uint16_t at = ctx->pos;

	while (at > 0 && ctx->line[at - 1] == ' ') {
		at--;
	}
	while (at > 0 && ctx->line[at - 1] != ' ') {
		at--;
	}
	return at;
}

static uint16_t word_right(const struct shell_ctx *ctx)
{
	uint16_t at = ctx->pos;

	while (at < ctx->len && ctx->line[at] == ' ') {
		at++;
	}
	while (at < ctx->len && ctx->line[at] != ' ') {
		at++;
	}
	return at;
}

/* step: 1 towards older lines, -1 towards newer ones. */
static void history_step(const struct shell *sh, int step)
{
	struct shell_ctx *ctx = sh->ctx;
	const int at = ctx->history_at + step;
	const char *line = at < 0 ? ctx->saved_line : shell_history_get(ctx, at);

	if (at < -1 || line == NULL) {
		shell_edit_bell(sh);
		return;
	}
	if (ctx->history_at < 0) {
		memcpy(ctx->saved_line, ctx->line, ctx->len + 1u);
	}
	ctx->history_at = (int16_t)at;
	shell_edit_set(sh, line);
	shell_edit_show(sh);
}

static void type(const struct shell *sh, char byte)
{
	struct shell_ctx *ctx = sh->ctx;

	if (!shell_edit_insert(sh, &byte, 1)) {
		ctx->overflow = true;
		shell_edit_bell(sh);
	} else if (shell_is_terminal(sh)) {
		const size_t end = strlen(ctx->prompt) + ctx->len;

		if (ctx->shown && ctx->pos == ctx->len && end % ctx->columns != 0) {
			shell_out_raw(sh, &byte, 1);
		} else {
			shell_edit_show(sh);
		}
	}
}

static void clear_screen(const struct shell *sh)
{
	shell_out_text(sh, "\x1b[2J\x1b[H");
	sh->ctx->cursor_row = 0;
	sh->ctx->shown = false;
}

static void cancel(const struct shell *sh)
{
	struct shell_ctx *ctx = sh->ctx;

	ctx->pos = ctx->len;
	shell_edit_show(sh);
	shell_out_text(sh, ctx->len == 0 && ctx->leave != NULL ? "^C (Ctrl-D leaves)" : "^C");
	shell_out_fresh_line(sh);
	shell_edit_reset(sh);
	shell_edit_show(sh);
}

/* Keys that change the line or move the cursor. False: not one of them. */
static bool edit_control(struct shell_ctx *ctx, char byte)
{
	switch (byte) {
	case CTRL('A'):
		ctx->pos = 0;
		return true;
	case CTRL('B'):
		ctx->pos -= ctx->pos > 0;
		return true;
	case CTRL('D'):
		if (ctx->pos < ctx->len) {
			cut(ctx, ctx->pos, ctx->pos + 1u);
		}
		return true;
	case CTRL('E'):
		ctx->pos = ctx->len;
		return true;
	case CTRL('F'):
		ctx->pos += ctx->pos < ctx->len;
		return true;
	case CTRL('K'):
		cut(ctx, ctx->pos, ctx->len);
		return true;
	case CTRL('U'):
		cut(ctx, 0, ctx->pos);
		return true;
	case CTRL('W'):
		cut(ctx, word_left(ctx), ctx->pos);
		return true;
	case BACKSPACE:
	case DELETE:
		if (ctx->pos > 0) {
			cut(ctx, ctx->pos - 1u, ctx->pos);
		}
		return true;
	default:
		return false;
	}
}

static void control(const struct shell *sh, char byte)
{
	struct shell_ctx *ctx = sh->ctx;

	ctx->overflow = false;
	if (byte == CTRL('D') && ctx->len == 0 && ctx->leave != NULL) {
		shell_out_fresh_line(sh);
		ctx->leave();
	}
	if (edit_control(ctx, byte)) {
		shell_edit_show(sh);
		return;
	}
	switch (byte) {
	case CTRL('C'):
		cancel(sh);
		break;
	case CTRL('L'):
		clear_screen(sh);
		shell_edit_show(sh);
		shell_edit_ask_width(sh);
		break;
	case CTRL('N'):
		history_step(sh, -1);
		break;
	case CTRL('P'):
		history_step(sh, 1);
		break;
	case '\t':
		shell_complete(sh);
		break;
	default:
		break;
	}
}

/* ESC [ row ; column R: the answer to shell_edit_ask_width(). */
static void take_width(const struct shell *sh, uint16_t columns)
{
	struct shell_ctx *ctx = sh->ctx;

	/* A terminal narrower than this has given nonsense. */
	if (ctx->key_arg_count == 2 && columns >= 20 && columns != ctx->columns) {
		shell_edit_hide(sh);
		ctx->columns = columns;
		shell_edit_show(sh);
	}
}

/* ESC [ n ~ */
static char tilde_key(uint16_t number)
{
	switch (number) {
	case 1:
	case 7:
		return CTRL('A');
	case 3:
		return CTRL('D');
	case 4:
	case 8:
		return CTRL('E');
	default:
		return '\0';
	}
}

static void csi_key(const struct shell *sh, char final)
{
	struct shell_ctx *ctx = sh->ctx;
	const bool word = ctx->key_arg_count == 2; /* ESC [ 1 ; 5 C: with control or alt */

	switch (final) {
	case 'A':
		control(sh, CTRL('P'));
		break;
	case 'B':
		control(sh, CTRL('N'));
		break;
	case 'C':
	case 'D':
		if (word) {
			ctx->pos = final == 'C' ? word_right(ctx) : word_left(ctx);
			shell_edit_show(sh);
		} else {
			control(sh, final == 'C' ? CTRL('F') : CTRL('B'));
		}
		break;
	case 'F':
		control(sh, CTRL('E'));
		break;
	case 'H':
		control(sh, CTRL('A'));
		break;
	case 'R':
		take_width(sh, ctx->key_args[1]);
		break;
	case '~':
		control(sh, tilde_key(ctx->key_args[0]));
		break;
	default:
		break;
	}
}

static void csi_byte(const struct shell *sh, char byte)
{
	struct shell_ctx *ctx = sh->ctx;

	if (byte >= '0' && byte <= '9') {
		uint16_t *arg = &ctx->key_args[ctx->key_arg_count == 2 ? 1 : 0];

		if (ctx->key_arg_count == 0) {
			ctx->key_arg_count = 1;
		}
		*arg = *arg > KEY_ARG_MAX / 10 ? KEY_ARG_MAX : (uint16_t)(*arg * 10 + (byte - '0'));
	} else if (byte == ';') {
		ctx->key_arg_count = 2;
	} else if (byte >= '@' && byte <= '~') {
		ctx->key_state = SHELL_KEY_PLAIN;
		csi_key(sh, byte);
	} else if (byte < ' ') {
		/* Not part of any sequence: the sequence was cut short. */
		ctx->key_state = SHELL_KEY_PLAIN;
	}
}

static void escape_byte(const struct shell *sh, char byte)
{
	struct shell_ctx *ctx = sh->ctx;

	ctx->key_state = SHELL_KEY_PLAIN;
	ctx->key_arg_count = 0;
	ctx->key_args[0] = 0;
	ctx->key_args[1] = 0;
	switch (byte) {
	case '[':
		ctx->key_state = SHELL_KEY_CSI;
		break;
	case 'O':
		ctx->key_state = SHELL_KEY_SS3;
		break;
	case 'b':
		ctx->pos = word_left(ctx);
		shell_edit_show(sh);
		break;
	case 'f':
		ctx->pos = word_right(ctx);
		shell_edit_show(sh);
		break;
	default:
		break;
	}
}

/* True: the line is complete. */
static bool newline(const struct shell *sh, char byte)
{
	struct shell_ctx *ctx = sh->ctx;
	const char before = ctx->last_newline;

	/* CR LF and LF CR are one line end. */
	if (before != '\0' && before != byte) {
		ctx->last_newline = '\0';
		return false;
	}
	ctx->last_newline = byte;
	if (shell_is_terminal(sh)) {
		ctx->pos = ctx->len;
		shell_edit_show(sh);
		shell_out_fresh_line(sh);
		ctx->shown = false;
		ctx->cursor_row = 0;
	}
	return true;
}

bool shell_edit_byte(const struct shell *sh, char byte)
{
	struct shell_ctx *ctx = sh->ctx;

	if (byte == '\r' || byte == '\n') {
		ctx->key_state = SHELL_KEY_PLAIN;
		return newline(sh, byte);
	}
	ctx->last_newline = '\0';
	if (!shell_is_terminal(sh)) {
		byte = byte == '\t' ? ' ' : byte;
		if (byte >= ' ' && byte <= '~') {
			type(sh, byte);
		}
		return false;
	}
	switch (ctx->key_state) {
	case SHELL_KEY_PLAIN:
		if (byte == ESCAPE) {
			ctx->key_state = SHELL_KEY_ESCAPE;
		} else if (byte >= ' ' && byte <= '~') {
			type(sh, byte);
		} else {
			control(sh, byte);
		}
		break;
	case SHELL_KEY_ESCAPE:
		escape_byte(sh, byte);
		break;
	case SHELL_KEY_CSI:
		csi_byte(sh, byte);
		break;
	case SHELL_KEY_SS3:
		ctx->key_state = SHELL_KEY_PLAIN;
		csi_key(sh, byte);
		break;
	}
	return false;
}

void shell_edit_reset(const struct shell *sh)
{
	struct shell_ctx *ctx = sh->ctx;

	ctx->line[0] = '\0';
	ctx->len = 0;
	ctx->pos = 0;
	ctx->overflow = false;
	ctx->history_at = -1;
	ctx->shown = false;
	ctx->cursor_row = 0;
}
