/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Temperature sensors of the kernel, by name:
 *
 *   hwmon:NAME/temp1            thousandths of a degree
 *   thermal:TYPE                a thermal zone's
 *   iio:NAME/in_voltage0,…      an NTC's voltage in mV: (raw + offset) * scale; NTC between input
 * and ground, pull-up to the reference iio:NAME/in_temp            a temperature, in the same way
 *
 * Reading may wait for a slow bus.
 */
#ifndef SENSOR_HOST_H_
#define SENSOR_HOST_H_

#include "host/error.h"
#include "host/sysfs.h"
#include "thermistor_sysfs.h"

struct sensor {
	const struct sysfs_class *class;
	char called[SYSFS_NAME_SIZE];
	char channel[32];
	char path[SYSFS_PATH_SIZE]; /* empty: to be looked for */
	uint32_t reference_mv;
	uint32_t pullup_ohms;
	uint32_t r25_ohms;
	uint32_t beta_k;
};

/* What follows `--thermistor`. 0, or -1 with a reason. */
int sensor_parse(struct sensor *sensor, const char *text, struct host_error *error);

/* Finds it. 0, or -1 with a reason. */
int sensor_find(struct sensor *sensor, struct host_error *error);

/* One sample; one that has gone is looked for again with the next. */
void sensor_read(struct sensor *sensor, struct thermistor_sysfs_reading *reading);

#endif
