/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The outputs besides the lamp and the servos, and the GPIO inputs: what the board has of them, and
 * what the device's actuators want of them. A build without IMC, which commands them, has none.
 *
 * Context: the command thread, or before the threads start.
 */
#ifndef PHAROS_THREADS_OUTPUTS_H
#define PHAROS_THREADS_OUTPUTS_H

#include <stdint.h>

#include "core/device.h"

#ifdef CONFIG_PHAROS_IMC

/* What the board has, and which power channels are on after this start. After storage_load(). */
void outputs_config(struct actuators_config *config);

/* Configures the lines, and carries out what is wanted now. */
void outputs_start(const struct actuators *actuators);

/* Carries out whatever differs from before, and stores the choice of power channels. */
void outputs_perform(const struct actuators *actuators);

/* Levels of the GPIO inputs, bit per number. */
uint32_t outputs_read_inputs(const struct actuators *actuators);

/* Writes that a driver refused; tried again with the next change. */
uint32_t outputs_errors(void);

#endif

#endif
