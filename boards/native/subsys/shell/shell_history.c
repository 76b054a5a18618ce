/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "shell_internal.h"

void shell_history_add(struct shell_ctx *ctx, const char *line)
{
	const size_t size = strlen(line) + 1;
	const char *newest = shell_history_get(ctx, 0);

	if (size == 1 || size > sizeof(ctx->history) ||
	    (newest != NULL && strcmp(newest, line) == 0)) {
		return;
	}
	while (ctx->history_len + size > sizeof(ctx->history)) {
		const size_t oldest = strlen(ctx->history) + 1;

		ctx->history_len -= (uint16_t)oldest;
		memmove(ctx->history, &ctx->history[oldest], ctx->history_len);
	}
	memcpy(&ctx->history[ctx->history_len], line, size);
	ctx->history_len += (uint16_t)size;
}

const char *shell_history_get(const struct shell_ctx *ctx, int back)
{
	size_t end = ctx->history_len;

	while (end > 0) {
		size_t start = end - 1;

		while (start > 0 && ctx->history[start - 1] != '\0') {
			start--;
		}
		if (back-- == 0) {
			return &ctx->history[start];
		}
		end = start;
	}
	return NULL;
}
