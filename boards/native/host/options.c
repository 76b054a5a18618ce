/* SPDX-License-Identifier: Apache-2.0 */
#include "host/options.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

int parse_number(const char *text, uint64_t low, uint64_t high, uint64_t *number,
                 struct host_error *error)
{
	char *end;
	unsigned long long value;

	errno = 0;
	value = strtoull(text, &end, 10);
	if (!isdigit((unsigned char)text[0]) || *end != '\0' || errno != 0 || value < low ||
	    value > high) {
		return host_error_set(
			error, "\"%.60s\" is not a whole number from %" PRIu64 " to %" PRIu64, text,
			low, high);
	}
	*number = value;
	return 0;
}

int parse_duration_us(const char *text, uint64_t *us, struct host_error *error)
{
	static const struct {
		const char *unit;
		double us;
	} units[] = {{"us", 1},     {"ms", 1e3},   {"s", 1e6},
	             {"min", 60e6}, {"h", 3600e6}, {"d", 86400e6}};
	char *end;
	const double value = strtod(text, &end);

	if (isdigit((unsigned char)text[0]) && isfinite(value)) {
		for (size_t i = 0; i < sizeof(units) / sizeof(units[0]); i++) {
			/* A thousand years of microseconds still fit, exactly enough, in a double.
			 */
			if (strcmp(end, units[i].unit) == 0 && value * units[i].us < 3.2e16) {
				*us = (uint64_t)llround(value * units[i].us);
				return 0;
			}
		}
	}
	return host_error_set(error, "\"%.60s\" is not a duration such as 500ms, 2s, 10min or 24h",
	                      text);
}
