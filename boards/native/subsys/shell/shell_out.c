/* SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "shell_internal.h"

void shell_out_raw(const struct shell *sh, const char *data, size_t len)
{
	struct shell_ctx *ctx = sh->ctx;

	if (len > 0) {
		ctx->line_start = data[len - 1] == '\n';
	}
	while (len > 0) {
		size_t sent = 0;

		if (sh->iface->api->write(sh->iface, data, len, &sent) != 0) {
			return;
		}
		data += sent;
		len -= sent;
		if (sent == 0) {
			(void)k_sem_take(&ctx->tx_ready, K_FOREVER);
		}
	}
}

void shell_out_text(const struct shell *sh, const char *text)
{
	shell_out_raw(sh, text, strlen(text));
}

void shell_out_cooked(const struct shell *sh, const char *data, size_t len)
{
	const bool crlf = shell_is_terminal(sh) || sh->shell_flag == SHELL_FLAG_OLF_CRLF;

	while (len > 0) {
		const char *newline = crlf ? memchr(data, '\n', len) : NULL;
		const size_t part = newline == NULL ? len : (size_t)(newline - data);

		shell_out_raw(sh, data, part);
		data += part;
		len -= part;
		if (newline != NULL) {
			shell_out_raw(sh, "\r\n", 2);
			data++;
			len--;
		}
	}
}

void shell_out_color(const struct shell *sh, enum shell_vt100_color color)
{
	char sequence[8];
	const bool line_start = sh->ctx->line_start;

	if (!IS_ENABLED(CONFIG_SHELL_VT100_COLORS) || !sh->ctx->cfg.use_colors ||
	    !shell_is_terminal(sh)) {
		return;
	}
	if (color == SHELL_VT100_COLOR_DEFAULT) {
		shell_out_text(sh, "\x1b[0m");
	} else {
		(void)snprintf(sequence, sizeof(sequence), "\x1b[1;3%dm", (int)color);
		shell_out_text(sh, sequence);
	}
	/* A colour is nothing on the line. */
	sh->ctx->line_start = line_start;
}

void shell_out_fresh_line(const struct shell *sh)
{
	if (!sh->ctx->line_start) {
		shell_out_cooked(sh, "\n", 1);
	}
}

void shell_out_begin(const struct shell *sh)
{
	if (!sh->ctx->executing && sh->ctx->bypass == NULL) {
		shell_edit_hide(sh);
	}
}

void shell_out_end(const struct shell *sh)
{
	if (!sh->ctx->executing && sh->ctx->bypass == NULL && shell_is_terminal(sh) &&
	    sh->ctx->state == SHELL_STATE_ACTIVE) {
		shell_out_fresh_line(sh);
		shell_edit_show(sh);
	}
}

static void out_colored(const struct shell *sh, enum shell_vt100_color color, const char *text,
                        size_t len)
{
	const bool colored = color != SHELL_VT100_COLOR_DEFAULT;
	const bool newline = len > 0 && text[len - 1] == '\n';

	if (!colored) {
		shell_out_cooked(sh, text, len);
		return;
	}
	/* The colour ends before the line does, lest it shows on the next one. */
	shell_out_color(sh, color);
	shell_out_cooked(sh, text, newline ? len - 1 : len);
	shell_out_color(sh, SHELL_VT100_COLOR_DEFAULT);
	if (newline) {
		shell_out_cooked(sh, "\n", 1);
	}
}

void shell_out_log(const struct shell *sh, enum shell_vt100_color color, const char *text,
                   size_t len)
{
	struct shell_ctx *ctx = sh->ctx;

	(void)k_mutex_lock(&ctx->wr_mtx, K_FOREVER);
	shell_out_begin(sh);
	shell_out_fresh_line(sh);
	out_colored(sh, color, text, len);
	shell_out_cooked(sh, "\n", 1);
	shell_out_end(sh);
	(void)k_mutex_unlock(&ctx->wr_mtx);
}

void shell_vfprintf(const struct shell *sh, enum shell_vt100_color color, const char *fmt,
                    va_list args)
{
	static const char cut[] = "...\n";
	struct shell_ctx *ctx = sh->ctx;
	int len;

	if (ctx->state != SHELL_STATE_ACTIVE) {
		return;
	}
	(void)k_mutex_lock(&ctx->wr_mtx, K_FOREVER);
	len = vsnprintf(ctx->text, sizeof(ctx->text), fmt, args);
	if (len >= (int)sizeof(ctx->text)) {
		len = (int)sizeof(ctx->text) - 1;
		memcpy(&ctx->text[sizeof(ctx->text) - sizeof(cut)], cut, sizeof(cut));
	}
	if (len > 0) {
		shell_out_begin(sh);
		out_colored(sh, color, ctx->text, (size_t)len);
		shell_out_end(sh);
	}
	(void)k_mutex_unlock(&ctx->wr_mtx);
}

void shell_fprintf(const struct shell *sh, enum shell_vt100_color color, const char *fmt, ...)
{
	va_list args;

	va_start(args, fmt);
	shell_vfprintf(sh, color, fmt, args);
	va_end(args);
}

void shell_hexdump_line(const struct shell *sh, unsigned int offset, const uint8_t *data,
                        size_t len)
{
	char hex[SHELL_HEXDUMP_BYTES_IN_LINE * 3 + 2] = "";
	char text[SHELL_HEXDUMP_BYTES_IN_LINE + 1] = "";
	size_t at = 0;

	for (size_t i = 0; i < len && i < SHELL_HEXDUMP_BYTES_IN_LINE; i++) {
		/* A gap in the middle makes the columns countable. */
		at += (size_t)snprintf(&hex[at], sizeof(hex) - at, "%02x%s", data[i],
		                       i == SHELL_HEXDUMP_BYTES_IN_LINE / 2 - 1 ? "  " : " ");
		text[i] = data[i] >= ' ' && data[i] <= '~' ? (char)data[i] : '.';
	}
	shell_print(sh, "%08X: %-*s|%-*s|", offset, (int)sizeof(hex) - 1, hex,
	            SHELL_HEXDUMP_BYTES_IN_LINE, text);
}

void shell_hexdump(const struct shell *sh, const uint8_t *data, size_t len)
{
	for (size_t at = 0; at < len; at += SHELL_HEXDUMP_BYTES_IN_LINE) {
		const size_t left = len - at;

		shell_hexdump_line(
			sh, (unsigned int)at, &data[at],
			left < SHELL_HEXDUMP_BYTES_IN_LINE ? left : SHELL_HEXDUMP_BYTES_IN_LINE);
	}
}
