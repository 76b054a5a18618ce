/* SPDX-License-Identifier: Apache-2.0 */
#include "sensor_host.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/options.h"

/* As on the MCU: an oversampled converter always shows some noise, and one that stands still is
 * stuck. */
#define CONVERSIONS 16

#define VOLTAGE "in_voltage"
#define TEMP    "in_temp"

/* No sensor of a lamp is there: it fits, and is out of range. */
#define TEMP_MAX_MDEGC 1e9

static const struct sysfs_class hwmon = {"class/hwmon", "hwmon", "name", "hwmon sensor"};
static const struct sysfs_class zones = {"class/thermal", "thermal_zone", "type", "thermal zone"};
static const struct sysfs_class iio = {"bus/iio/devices", "iio:device", "name", "IIO device"};

static bool starts(const char *text, const char *with)
{
	return strncmp(text, with, strlen(with)) == 0;
}

/* --- the option ---------------------------------------------------------------------------------
 */

/* NAME=NUMBER of a divider. */
static int parse_part(struct sensor *sensor, char *word, struct host_error *error)
{
	const struct {
		const char *name;
		uint32_t *value;
		uint32_t low;
		uint32_t high;
	} parts[] = {
		{"reference", &sensor->reference_mv, 100, 100000},
		{"pullup", &sensor->pullup_ohms, 1, 100000000},
		{"r25", &sensor->r25_ohms, 1, 100000000},
		{"beta", &sensor->beta_k, 1000, 10000},
	};
	char *equals = strchr(word, '=');
	struct host_error reason;
	uint64_t number;

	if (equals != NULL) {
		*equals = '\0';
	}
	for (size_t i = 0; i < sizeof(parts) / sizeof(parts[0]); i++) {
		if (strcmp(parts[i].name, word) != 0) {
			continue;
		}
		if (parse_number(equals != NULL ? equals + 1 : "", parts[i].low, parts[i].high,
		                 &number, &reason) != 0) {
			return host_error_set(error, "%s: %.200s", word, reason.text);
		}
		*parts[i].value = (uint32_t)number;
		return 0;
	}
	return host_error_set(error, "\"%.40s\" is not one of reference, pullup, r25 and beta",
	                      word);
}

/* NAME/CHANNEL, taken apart. */
static int parse_channel(struct sensor *sensor, char *text, const char *example,
                         struct host_error *error)
{
	char *slash = strrchr(text, '/');

	if (slash == NULL || slash == text || slash[1] == '\0' ||
	    strlen(slash + 1) >= sizeof(sensor->channel) - 8) {
		return host_error_set(error, "\"%.60s\" is not as %s", text, example);
	}
	*slash = '\0';
	(void)snprintf(sensor->channel, sizeof(sensor->channel), "%s", slash + 1);
	(void)snprintf(sensor->called, sizeof(sensor->called), "%.*s", SYSFS_NAME_SIZE - 1, text);
	return 0;
}

/* Other inputs of such a chip are volts, amperes, turns of a fan. */
static int parse_hwmon(struct sensor *sensor, char *text, struct host_error *error)
{
	const char *channel = sensor->channel;

	if (parse_channel(sensor, text, "hwmon:NAME/temp1", error) != 0) {
		return -1;
	}
	if (!starts(channel, "temp") || channel[4] == '\0' ||
	    channel[4 + strspn(channel + 4, "0123456789")] != '\0') {
		return host_error_set(error, "hwmon: %s is no temperature such as temp1", channel);
	}
	return 0;
}

static int parse_iio(struct sensor *sensor, char *text, struct host_error *error)
{
	char *rest = text;
	char *word = strsep(&rest, ",");

	if (parse_channel(sensor, word, "iio:NAME/in_voltage0", error) != 0) {
		return -1;
	}
	if (!starts(sensor->channel, VOLTAGE) && !starts(sensor->channel, TEMP)) {
		return host_error_set(error, "iio: %s is neither " VOLTAGE "… nor " TEMP "…",
		                      sensor->channel);
	}
	while ((word = strsep(&rest, ",")) != NULL) {
		if (parse_part(sensor, word, error) != 0) {
			return -1;
		}
	}
	return 0;
}

int sensor_parse(struct sensor *sensor, const char *text, struct host_error *error)
{
	char copy[SYSFS_PATH_SIZE];

	*sensor = (struct sensor){
		/* as in native.dts */
		.reference_mv = 3300,
		.pullup_ohms = 10000,
		.r25_ohms = 10000,
		.beta_k = 3435,
	};
	if (strlen(text) >= sizeof(copy)) {
		return host_error_set(error, "longer than %zu characters", sizeof(copy) - 1);
	}
	strcpy(copy, text);
	if (starts(copy, "hwmon:")) {
		sensor->class = &hwmon;
		return parse_hwmon(sensor, copy + 6, error);
	}
	if (starts(copy, "iio:")) {
		sensor->class = &iio;
		return parse_iio(sensor, copy + 4, error);
	}
	if (starts(copy, "thermal:") && copy[8] != '\0') {
		sensor->class = &zones;
		(void)snprintf(sensor->called, sizeof(sensor->called), "%.*s", SYSFS_NAME_SIZE - 1,
		               copy + 8);
		return 0;
	}
	return host_error_set(error,
	                      "\"%.60s\" is none of sim, hwmon:NAME/temp1, thermal:TYPE, "
	                      "iio:NAME/in_voltage0",
	                      text);
}

/* --- attributes ---------------------------------------------------------------------------------
 */

/* "temp1_input", "temp", "in_voltage0_raw": what a sample is read from. */
static void name_value(const struct sensor *sensor, char name[SYSFS_NAME_SIZE])
{
	(void)snprintf(name, SYSFS_NAME_SIZE, "%s%s",
	               sensor->class == &zones ? "temp" : sensor->channel,
	               sensor->class == &zones ? ""
	               : sensor->class == &iio ? "_raw"
	                                       : "_input");
}

int sensor_find(struct sensor *sensor, struct host_error *error)
{
	char path[SYSFS_PATH_SIZE];
	char name[SYSFS_NAME_SIZE];

	sensor->path[0] = '\0';
	if (sysfs_find(sensor->class, sensor->called, path, error) != 0) {
		return -1;
	}
	name_value(sensor, name);
	if (!sysfs_has(path, name)) {
		return host_error_set(error, "%s %s has no %s", sensor->class->what, sensor->called,
		                      name);
	}
	strcpy(sensor->path, path);
	return 0;
}

/* "in_voltage0_scale", or that of all channels of its kind: "in_voltage_scale". */
static int read_shared(const struct sensor *sensor, const char *what, double *number)
{
	char name[SYSFS_NAME_SIZE];
	int rc;

	(void)snprintf(name, sizeof(name), "%s_%s", sensor->channel, what);
	rc = sysfs_read_number(sensor->path, name, number);
	if (rc == -ENOENT) {
		(void)snprintf(name, sizeof(name), "%s_%s",
		               starts(sensor->channel, VOLTAGE) ? VOLTAGE : TEMP, what);
		rc = sysfs_read_number(sensor->path, name, number);
	}
	return rc;
}

/* Sum of (raw + offset) * scale. */
static int read_scaled(const struct sensor *sensor, unsigned int count, double *sum)
{
	char name[SYSFS_NAME_SIZE];
	double scale;
	double offset;
	double raw;
	int rc = read_shared(sensor, "scale", &scale);

	if (rc != 0) {
		return rc;
	}
	rc = read_shared(sensor, "offset", &offset);
	if (rc == -ENOENT) {
		offset = 0.0;
	} else if (rc != 0) {
		return rc;
	}
	name_value(sensor, name);
	*sum = 0.0;
	for (unsigned int i = 0; i < count; i++) {
		rc = sysfs_read_number(sensor->path, name, &raw);
		if (rc != 0) {
			return rc;
		}
		*sum += (raw + offset) * scale;
	}
	return 0;
}

static int32_t mdegc_of(double number)
{
	return (int32_t)lround(fmax(-TEMP_MAX_MDEGC, fmin(number, TEMP_MAX_MDEGC)));
}

static int read_divider(const struct sensor *sensor, struct thermistor_sysfs_reading *reading)
{
	double sum_mv;
	const int rc = read_scaled(sensor, CONVERSIONS, &sum_mv);

	if (rc != 0) {
		return rc;
	}
	reading->is_divider = true;
	reading->full_uv = sensor->reference_mv * 1000u * CONVERSIONS;
	reading->sum_uv =
		(uint32_t)llround(fmax(0.0, fmin(sum_mv * 1000.0, (double)reading->full_uv)));
	reading->pullup_ohms = sensor->pullup_ohms;
	reading->r25_ohms = sensor->r25_ohms;
	reading->beta_k = sensor->beta_k;
	return 0;
}

/* The chip says itself that nothing is connected. */
static int read_fault(const struct sensor *sensor)
{
	char name[SYSFS_NAME_SIZE];
	double fault;

	(void)snprintf(name, sizeof(name), "%s_fault", sensor->channel);
	return sensor->class == &hwmon && sysfs_read_number(sensor->path, name, &fault) == 0 &&
	                       fault != 0.0
	               ? -EIO
	               : 0;
}

static int read_temperature(const struct sensor *sensor, struct thermistor_sysfs_reading *reading)
{
	char name[SYSFS_NAME_SIZE];
	double number = 0.0;
	int rc;

	name_value(sensor, name);
	rc = sensor->class == &iio ? read_scaled(sensor, 1, &number)
	                           : sysfs_read_number(sensor->path, name, &number);
	reading->temp_mdegc = mdegc_of(number);
	return rc != 0 ? rc : read_fault(sensor);
}

void sensor_read(struct sensor *sensor, struct thermistor_sysfs_reading *reading)
{
	struct host_error ignored;

	*reading = (struct thermistor_sysfs_reading){.error = -ENODEV};
	if (sensor->path[0] == '\0' && sensor_find(sensor, &ignored) != 0) {
		return;
	}
	reading->error = starts(sensor->channel, VOLTAGE) ? read_divider(sensor, reading)
	                                                  : read_temperature(sensor, reading);
	if (reading->error != 0) {
		sensor->path[0] = '\0';
	}
}
