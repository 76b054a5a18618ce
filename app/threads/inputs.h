/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The board's slow inputs, where it has them: the lamp driver's fault output (alias driver-fault)
 * is logged and counted; a press of the button (alias button0) switches the light on or off, with
 * the rights of the shell. A level counts once it has lasted INPUTS_SETTLE_MS.
 */
#ifndef PHAROS_THREADS_INPUTS_H
#define PHAROS_THREADS_INPUTS_H

#include <stdbool.h>
#include <stdint.h>

#define INPUTS_SETTLE_MS 20

struct inputs_status {
	bool has_driver_fault; /* the board has that input */
	bool driver_fault;     /* now */
	uint32_t driver_faults;
	uint32_t presses;
};

/* After command_init(). Sets the results of STARTUP_DRIVER_FAULT and STARTUP_BUTTON. */
void inputs_init(void);

/* Any thread. */
struct inputs_status inputs_get(void);

#endif
