/* SPDX-License-Identifier: Apache-2.0 */
#include "host/hardware.h"

#include <stddef.h>

#include "host/control.h"
#include "host/module.h"
#include "host/say.h"

static const char *lamp;   /* NULL: a model */
static const char *sensor; /* the same */
static bool is_meant;
static bool is_off;

void hardware_lamp(const char *option)
{
	lamp = option;
}

void hardware_sensor(const char *option)
{
	sensor = option;
}

bool hardware_is_only_off(void)
{
	return is_off;
}

bool hardware_allows_light(void)
{
	return lamp == NULL || sensor != NULL || is_meant;
}

bool hardware_is_unprotected(void)
{
	return lamp != NULL && sensor == NULL && is_meant;
}

static int parse_unsafe(const char *value, struct host_error *error)
{
	(void)value;
	(void)error;
	is_meant = true;
	return 0;
}

static int parse_off(const char *value, struct host_error *error)
{
	(void)value;
	(void)error;
	is_off = true;
	return 0;
}

static int start(void)
{
	if (!hardware_allows_light()) {
		host_say("the lamp stays dark: it is real (%s) and its temperature sensor is not; "
		         "give --thermistor hwmon:NAME/temp1, thermal:TYPE or "
		         "iio:NAME/in_voltage0 (or --unsafe-simulated-sensor)",
		         lamp);
	} else if (hardware_is_unprotected()) {
		host_say("--unsafe-simulated-sensor: nothing protects the lamp from heat");
	}
	return 0;
}

static enum control_result run_hardware(struct control_call *call)
{
	control_put_string(call->reply, "lamp", lamp != NULL ? lamp : "simulated");
	control_put_string(call->reply, "sensor", sensor != NULL ? sensor : "simulated");
	control_put_bool(call->reply, "allows_light", hardware_allows_light());
	control_put_bool(call->reply, "unprotected", hardware_is_unprotected());
	return CONTROL_OK;
}

static const struct host_option options[] = {
	{"unsafe-simulated-sensor", NULL,
         "light a real lamp (--gpio, --light) that no --thermistor protects from\n"
         "heat; without this it stays dark",
         parse_unsafe},
	{"off", NULL,
         "only make the outputs of --gpio, --light and its kin dark, and end: for a\n"
         "service's ExecStopPost=, when light and guard may both have been killed",
         parse_off},
	{0},
};

static const struct control_op ops[] = {
	{"hardware",
         "what lamp and sensor are (an option, or simulated), whether the lamp may be lit, whether "
         "it is without protection from heat",
         run_hardware},
	{0},
};

HOST_MODULE(hardware_module) = {
	.name = "hardware",
	.order = HOST_ORDER_BOARD + 2,
	.options = options,
	.ops = ops,
	.start = start,
};
