/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/remote_actions.h"

#include "core/assert.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define ACTIONS "Light=Button;Strobe=Button;Brightness=Slider"
#define AXES    ";Pan=Axis;Tilt=Axis"

#define RANGE127       127
#define DECIMALS       6 /* PPM_ONE is 10^6; further ones are cut off */
#define INTEGER_DIGITS 3

_Static_assert(PPM_ONE == 1000000, "a share has as many decimals");

/* A part of a text. */
struct span {
	const char *bytes;
	size_t length;
};

struct pair {
	struct span name;
	struct span value;
};

const char *imc_remote_actions_report(bool gimbal, bool decimal)
{
	static const char *const reports[2][2] = {
		{ACTIONS ";Ranges=Range127", ACTIONS ";Ranges=Decimal"},
		{ACTIONS AXES ";Ranges=Range127", ACTIONS AXES ";Ranges=Decimal"},
	};

	return reports[gimbal ? 1 : 0][decimal ? 1 : 0];
}

static struct span trimmed(struct span span)
{
	while (span.length > 0 && span.bytes[0] == ' ') {
		span.bytes++;
		span.length--;
	}
	while (span.length > 0 && span.bytes[span.length - 1] == ' ') {
		span.length--;
	}
	return span;
}

static bool span_is(struct span span, const char *string)
{
	return span.length == strlen(string) && memcmp(span.bytes, string, span.length) == 0;
}

/* Up to any of the separators; takes it and the separator off *rest. */
static struct span cut(struct span *rest, const char *separators)
{
	struct span part = {.bytes = rest->bytes};

	while (part.length < rest->length && strchr(separators, rest->bytes[part.length]) == NULL) {
		part.length++;
	}
	const size_t used = part.length + (part.length < rest->length ? 1 : 0);

	rest->bytes += used;
	rest->length -= used;
	return trimmed(part);
}

static bool next_pair(struct span *rest, struct pair *pair)
{
	if (rest->length == 0) {
		return false;
	}
	struct span item = cut(rest, ";,");

	pair->name = cut(&item, "=");
	pair->value = trimmed(item);
	return true;
}

static bool is_digit(char byte)
{
	return byte >= '0' && byte <= '9';
}

/* A decimal number, in millionths. False: it is none, or has more than INTEGER_DIGITS digits. */
static bool parse_number(struct span span, int32_t *millionths)
{
	const bool negative = span.length > 0 && span.bytes[0] == '-';
	size_t at = (negative || (span.length > 0 && span.bytes[0] == '+')) ? 1 : 0;
	const size_t first = at;
	int32_t value = 0;
	int decimals = 0;

	for (; at < span.length && is_digit(span.bytes[at]); at++) {
		if (at - first == INTEGER_DIGITS) {
			return false;
		}
		value = value * 10 + (span.bytes[at] - '0');
	}
	bool any = at > first;

	if (at < span.length && span.bytes[at] == '.') {
		for (at++; at < span.length && is_digit(span.bytes[at]); at++) {
			any = true;
			if (decimals < DECIMALS) {
				value = value * 10 + (span.bytes[at] - '0');
				decimals++;
			}
		}
	}
	for (; decimals < DECIMALS; decimals++) {
		value *= 10;
	}
	*millionths = negative ? -value : value;
	return any && at == span.length;
}

_Static_assert(INT64_C(1000) * PPM_ONE < INT32_MAX, "three digits and six decimals fit");

/* -PPM_ONE…PPM_ONE, rounded to the nearest. */
static bool parse_share(struct span span, bool decimal, int32_t *share_ppm)
{
	const int32_t full = decimal ? 1 : RANGE127;
	int32_t value;

	if (!parse_number(span, &value) || value > full * (int32_t)PPM_ONE ||
	    value < -full * (int32_t)PPM_ONE) {
		return false;
	}
	*share_ppm = (value + (value < 0 ? -full : full) / 2) / full;
	return true;
}

static bool take(const struct pair *pair, bool decimal, struct remote_input *input)
{
	const bool light = span_is(pair->name, "Light");
	const bool brightness = span_is(pair->name, "Brightness");
	const bool pan = span_is(pair->name, "Pan");
	int32_t share_ppm;

	if (!light && !brightness && !pan && !span_is(pair->name, "Strobe") &&
	    !span_is(pair->name, "Tilt")) {
		return true;
	}
	if (!parse_share(pair->value, decimal, &share_ppm)) {
		return false;
	}
	if (light) {
		input->light = share_ppm != 0;
	} else if (brightness) {
		input->brightness_ppm = (share_ppm > 0) ? (uint32_t)share_ppm : 0;
		return share_ppm >= 0;
	} else if (pan) {
		input->pan_ppm = share_ppm;
	} else if (span_is(pair->name, "Tilt")) {
		input->tilt_ppm = share_ppm;
	} else {
		input->strobe = share_ppm != 0;
	}
	return true;
}

bool imc_remote_actions_parse(const struct imc_text *actions, bool decimal,
                              struct remote_input *input)
{
	struct span rest = {.bytes = actions->bytes, .length = actions->length};
	struct pair pair;

	memset(input, 0, sizeof(*input));
	while (next_pair(&rest, &pair)) {
		if (!take(&pair, decimal, input)) {
			return false;
		}
	}
	return true;
}

void imc_remote_actions_ranges(const struct imc_text *actions, bool *decimal)
{
	struct span rest = {.bytes = actions->bytes, .length = actions->length};
	struct pair pair;

	while (next_pair(&rest, &pair)) {
		if (span_is(pair.name, "Ranges") && span_is(pair.value, "Decimal")) {
			*decimal = true;
		} else if (span_is(pair.name, "Ranges") && span_is(pair.value, "Range127")) {
			*decimal = false;
		}
	}
}
