/* SPDX-License-Identifier: Apache-2.0 */
/* Between the two halves of --thermistor. No host and no Zephyr headers. */
#ifndef THERMISTOR_SYSFS_H_
#define THERMISTOR_SYSFS_H_

#include <stdbool.h>
#include <stdint.h>

struct thermistor_sysfs_reading {
	int error;       /* -errno: nothing was read, and the rest says nothing */
	bool is_divider; /* an NTC's voltage; else a temperature */
	int32_t temp_mdegc;
	uint32_t sum_uv;  /* of all conversions of a sample: the voltage over the NTC */
	uint32_t full_uv; /* the same of what feeds NTC and pull-up */
	uint32_t pullup_ohms;
	uint32_t r25_ohms;
	uint32_t beta_k;
};

/* False: the sensor is the board's model. */
bool thermistor_sysfs_is_real(void);

/* True: the sensor is the model, and the lamp is real: it must not be lit. */
bool thermistor_sysfs_is_missing(void);

/* True: the same, and somebody said that the lamp may be lit. */
bool thermistor_sysfs_is_simulated(void);

/* Reads in a helper's thread, then calls done, in interrupt context; before it returns where time
 * is virtual. One at a time. */
void thermistor_sysfs_begin(void (*done)(void));

/* What was read last. From done on, until the next begin. */
const struct thermistor_sysfs_reading *thermistor_sysfs_reading(void);

#endif
