/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A small text display: what stands on it. Text is bytes of printable ASCII; any other byte becomes
 * '?', what is too long is cut off, what is short is filled with spaces.
 *
 * Context: the thread that owns it, no locks inside. Spec: IMC 307 LcdControl.
 */
#ifndef PHAROS_CORE_DISPLAY_H
#define PHAROS_CORE_DISPLAY_H

#include "core/limits.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Wire values of IMC. */
enum display_op {
	DISPLAY_OP_OFF,
	DISPLAY_OP_ON,
	DISPLAY_OP_CLEAR,
	DISPLAY_OP_WRITE0,
	DISPLAY_OP_WRITE1,
};
#define DISPLAY_OPS 5u

struct display {
	bool on; /* what is written stands there also while it is off */
	char lines[DISPLAY_LINES][DISPLAY_COLUMNS];
};

/* Off and empty. */
void display_init(struct display *self);

/* text: length bytes, for the two WRITE ops. False: no such op; nothing changed. */
bool display_command(struct display *self, uint32_t op, const char *text, size_t length);

#endif
