/* SPDX-License-Identifier: Apache-2.0 */
#include "thermistor_sysfs.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "host/carry.h"
#include "host/clock.h"
#include "host/control.h"
#include "host/hardware.h"
#include "host/helper.h"
#include "host/module.h"
#include "host/say.h"
#include "sensor_host.h"

enum {
	EXIT_OPTION = 2
};

static const char *option = "sim";
static struct sensor sensor; /* class NULL: the model */
static struct thermistor_sysfs_reading reading;
static struct helper helper = {.name = "pharos-sensor"};
static struct helper_job job;
static void (*begun)(void);
static bool is_told; /* that it does not answer */
static uint64_t samples;
static uint64_t failures;

bool thermistor_sysfs_is_real(void)
{
	return sensor.class != NULL;
}

bool thermistor_sysfs_is_missing(void)
{
	return !hardware_allows_light();
}

bool thermistor_sysfs_is_simulated(void)
{
	return hardware_is_unprotected();
}

/* In the helper. */
static void work(struct helper_job *its)
{
	(void)its;
	sensor_read(&sensor, &reading);
}

static void done(struct helper_job *its)
{
	(void)its;
	samples += reading.error == 0 ? 1 : 0;
	failures += reading.error != 0 ? 1 : 0;
	if (is_told != (reading.error != 0)) {
		is_told = reading.error != 0;
		host_say("thermistor: %s %s%s", option, is_told ? "is lost: " : "is back",
		         is_told ? strerror(-reading.error) : "");
	}
	begun();
}

void thermistor_sysfs_begin(void (*finished)(void))
{
	begun = finished;
	job.work = work;
	job.done = done;
	helper_submit(&helper, &job);
}

const struct thermistor_sysfs_reading *thermistor_sysfs_reading(void)
{
	return &reading;
}

static int parse_thermistor(const char *value, struct host_error *error)
{
	option = value;
	sensor.class = NULL;
	return strcmp(value, "sim") == 0 ? 0 : sensor_parse(&sensor, value, error);
}

static int start(void)
{
	struct host_error error;

	if (sensor.class == NULL) {
		return 0;
	}
	if (clock_is_virtual() && sysfs_is_real()) {
		(void)fprintf(stderr, "pharos: --thermistor: a real sensor needs --time real\n");
		return EXIT_OPTION;
	}
	hardware_sensor(option);
	/* one that has gone by the time of a reset may come back */
	if (sensor_find(&sensor, &error) != 0 && !carry_is_reset()) {
		(void)fprintf(stderr, "pharos: --thermistor: %s\n", error.text);
		return EXIT_OPTION;
	}
	return 0;
}

static enum control_result run_thermistor(struct control_call *call)
{
	control_put_string(call->reply, "option", option);
	control_put_integer(call->reply, "samples", (int64_t)samples);
	control_put_integer(call->reply, "failures", (int64_t)failures);
	return CONTROL_OK;
}

static const struct host_option options[] = {
	{"thermistor", "SENSOR",
         "what measures the lamp's temperature (sim); SENSOR is one of these:\n"
         "sim                  the board's model\n"
         "hwmon:NAME/temp1     a sensor of the kernel's; NAME@DEVICE where several\n"
         "                     have the name, such as lm75@1-0048\n"
         "thermal:TYPE         a thermal zone\n"
         "iio:NAME/in_voltage0,reference=3300,pullup=10000,r25=10000,beta=3435\n"
         "                     an NTC from the ADC's input to ground, with a pull-up\n"
         "                     (ohms) to the reference (mV)\n"
         "iio:NAME/in_temp     a temperature",
         parse_thermistor},
	{0},
};

static const struct control_op ops[] = {
	{"thermistor",
         "the sensor of --thermistor: option, samples read since the last reset, failures to read",
         run_thermistor},
	{0},
};

HOST_MODULE(thermistor_module) = {
	.name = "thermistor",
	.order = HOST_ORDER_BOARD + 1,
	.options = options,
	.ops = ops,
	.start = start,
};
