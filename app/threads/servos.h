/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The servos that turn the beam, where the board has them and the build has a gimbal.
 *
 * Context: the command thread, unless said otherwise.
 */
#ifndef PHAROS_THREADS_SERVOS_H
#define PHAROS_THREADS_SERVOS_H

#include <stdbool.h>
#include <stdint.h>

#include "core/device.h"

#ifdef CONFIG_PHAROS_GIMBAL

/* The board has both, and they work; one that does not is logged. */
bool servos_ready(void);

/* Brings them where the device's gimbal says, and tells it when they can't be driven. */
void servos_move(struct pharos_device *device);

/* Times that one could not be driven. */
uint32_t servos_errors(void);

#else

static inline bool servos_ready(void)
{
	return false;
}

static inline void servos_move(struct pharos_device *device)
{
}

#endif

#endif
