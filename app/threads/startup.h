/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Start-up is a sequence of steps, each with a result that is kept and shown: in the log, by the
 * shell's `startup`, over MAVLink. A step that fails ends nothing: what it was for is missing, all
 * else starts. Without its driver or the watchdog the lamp stays dark until the next reset; without
 * its sensor as the thermal supervisor says (core/thermal.h).
 */
#ifndef PHAROS_THREADS_STARTUP_H
#define PHAROS_THREADS_STARTUP_H

#include <stdbool.h>
#include <stdint.h>

#include <zephyr/device.h>

#include "threads/limits.h"

enum startup_step {
	STARTUP_WATCHDOG,
	STARTUP_LIGHT,
	STARTUP_SENSOR,
	STARTUP_STORAGE,
	STARTUP_SYNC,
	STARTUP_EDGE_TIME,
	STARTUP_STRAP,
	STARTUP_UART_LINK0,
	STARTUP_UART_LINK1,
	STARTUP_UART_LINK2,
	STARTUP_UART_LINK3,
	STARTUP_CAN_LINK,
	STARTUP_IMC_LINK,
	STARTUP_SERVOS,
	STARTUP_DRIVER_FAULT,
	STARTUP_BUTTON,
	STARTUP_STEPS,
};

/* Results besides 0 and -errno. */
#define STARTUP_ABSENT  1 /* not on this board */
#define STARTUP_PENDING 2 /* not reached */

/* The step's result, once it is known; one that fails is logged. Start-up, or the supervisor. */
void startup_done(enum startup_step step, int result);

/* The same of a step that is a device's own start; device NULL: absent. Returns the result. */
int startup_device(enum startup_step step, const struct device *device);

/* 0, -errno or one of the above. Any context, as all below. */
int startup_result(enum startup_step step);

/* The device, if its step has succeeded; else NULL. */
static inline const struct device *startup_ready(enum startup_step step,
                                                 const struct device *device)
{
	return startup_result(step) == 0 ? device : NULL;
}

/* The first step that has failed, from `from` on; STARTUP_STEPS: none. */
enum startup_step startup_failed(enum startup_step from);

/* Everything that this board has has started. */
bool startup_is_whole(void);

/* The lamp's driver and the watchdog have started. */
bool startup_allows_light(void);

/* For people: "watchdog", "light", … */
const char *startup_name(enum startup_step step);

#endif
