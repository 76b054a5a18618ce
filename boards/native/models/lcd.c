/* SPDX-License-Identifier: Apache-2.0 */
#include "models/lcd.h"

#include <string.h>

void lcd_clear(struct lcd *self)
{
	memset(self->text, ' ', sizeof(self->text));
	self->line = 0;
	self->column = 0;
}

void lcd_reset(struct lcd *self)
{
	self->on = false;
	lcd_clear(self);
}

bool lcd_move(struct lcd *self, int column, int line)
{
	if (line < 0 || line >= (int)LCD_LINES || column < 0 || column >= (int)LCD_COLUMNS) {
		return false;
	}
	self->line = (uint32_t)line;
	self->column = (uint32_t)column;
	return true;
}

void lcd_write(struct lcd *self, const uint8_t *text, size_t length)
{
	for (size_t i = 0; i < length && self->column < LCD_COLUMNS; i++) {
		self->text[self->line][self->column++] = (char)text[i];
	}
}
