/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What an injected fault of a chip (models/board.h) does to an operation of its driver.
 */
#ifndef NATIVE_DEVICES_FAULT_H_
#define NATIVE_DEVICES_FAULT_H_

#include "models/board.h"

/*
 * 0: go on. -EIO: the chip answers with an error. A late chip answers after its delay, one that
 * never answers keeps its caller: a thread that may sleep does so; anybody else keeps the CPU,
 * until the watchdog, which needs none, bites. Any context.
 */
int fault_pass(enum board_chip chip);

/* The chip of that name; BOARD_CHIP_COUNT: none, and its faults are none. */
enum board_chip fault_chip(const char *name);

/* The fault now. Any context. */
static inline const struct board_fault *fault_of(enum board_chip chip)
{
	static const struct board_fault none;

	return chip < BOARD_CHIP_COUNT ? &board.faults[chip] : &none;
}

/* The same for a driver's start, which a chip that is late or silent does not hold up. */
int fault_start(enum board_chip chip);

#endif
