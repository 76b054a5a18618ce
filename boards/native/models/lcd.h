/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A text display with a cursor, as its controller has it. Plain data.
 */
#ifndef NATIVE_MODELS_LCD_H_
#define NATIVE_MODELS_LCD_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LCD_LINES   2u
#define LCD_COLUMNS 16u

struct lcd {
	bool on;
	uint32_t line; /* of the cursor, which may be beyond the last column */
	uint32_t column;
	char text[LCD_LINES][LCD_COLUMNS];
};

/* Off, empty, cursor at the first place. */
void lcd_reset(struct lcd *self);

/* Empty, cursor at the first place. */
void lcd_clear(struct lcd *self);

/* False: beyond the display. */
bool lcd_move(struct lcd *self, int column, int line);

/* At the cursor, which moves on; what is beyond the line is lost. */
void lcd_write(struct lcd *self, const uint8_t *text, size_t length);

#endif
