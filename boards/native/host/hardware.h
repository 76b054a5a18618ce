/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What of the board is real. A real lamp whose temperature sensor is a model would be protected by
 * nothing: it does not light, unless --unsafe-simulated-sensor says so.
 */
#ifndef NATIVE_HOST_HARDWARE_H_
#define NATIVE_HOST_HARDWARE_H_

#include <stdbool.h>

/* Start hooks of order HOST_ORDER_BOARD + 1: the lamp, or its sensor, is what that option says. The
 * text stays valid. */
void hardware_lamp(const char *option);
void hardware_sensor(const char *option);

/* After the options: real outputs are only to be made safe (--off). */
bool hardware_is_only_off(void);

/* --- once all modules have started --- */

/* False: the lamp is real and the sensor is not, and nobody has said that this is meant so. */
bool hardware_allows_light(void);

/* True: a real lamp is lit, and its temperature is a model's. */
bool hardware_is_unprotected(void);

#endif
