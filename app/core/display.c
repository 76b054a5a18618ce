/* SPDX-License-Identifier: Apache-2.0 */
#include "core/display.h"

#include <string.h>

#define PRINTABLE_FIRST ' '
#define PRINTABLE_LAST  '~'

_Static_assert(DISPLAY_LINES == 2, "there is an op for each line");

static void clear(struct display *self)
{
	memset(self->lines, ' ', sizeof(self->lines));
}

void display_init(struct display *self)
{
	self->on = false;
	clear(self);
}

static void write_line(char line[DISPLAY_COLUMNS], const char *text, size_t length)
{
	for (size_t column = 0; column < DISPLAY_COLUMNS; column++) {
		const char byte = (column < length) ? text[column] : ' ';

		line[column] = (byte >= PRINTABLE_FIRST && byte <= PRINTABLE_LAST) ? byte : '?';
	}
}

bool display_command(struct display *self, uint32_t op, const char *text, size_t length)
{
	if (op >= DISPLAY_OPS) {
		return false;
	}
	switch ((enum display_op)op) {
	case DISPLAY_OP_OFF:
	case DISPLAY_OP_ON:
		self->on = op == DISPLAY_OP_ON;
		break;
	case DISPLAY_OP_CLEAR:
		clear(self);
		break;
	case DISPLAY_OP_WRITE0:
	case DISPLAY_OP_WRITE1:
		write_line(self->lines[op - DISPLAY_OP_WRITE0], text, length);
		break;
	}
	return true;
}
