/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/shell/fixed.h"

#include <zephyr/sys/printk.h>

static bool append_digit(int64_t *value, char digit)
{
	const int64_t units = digit - '0';

	if (*value > (INT64_MAX - units) / 10) {
		return false;
	}
	*value = *value * 10 + units;
	return true;
}

static bool is_digit(char c)
{
	return c >= '0' && c <= '9';
}

bool fixed_parse(const char *text, unsigned int decimals, int64_t *value)
{
	const bool negative = *text == '-';
	const char *at = negative ? text + 1 : text;
	unsigned int missing = decimals;
	int64_t parsed = 0;

	if (!is_digit(*at)) {
		return false;
	}
	for (; is_digit(*at); at++) {
		if (!append_digit(&parsed, *at)) {
			return false;
		}
	}
	if (*at == '.') {
		for (at++; is_digit(*at); at++) {
			if (missing == 0 && *at != '0') {
				return false;
			}
			if (missing > 0) {
				missing--;
				if (!append_digit(&parsed, *at)) {
					return false;
				}
			}
		}
	}
	for (; missing > 0; missing--) {
		if (!append_digit(&parsed, '0')) {
			return false;
		}
	}
	if (*at != '\0') {
		return false;
	}
	*value = negative ? -parsed : parsed;
	return true;
}

void fixed_format(char text[FIXED_TEXT_MAX], int64_t value, unsigned int decimals)
{
	const bool negative = value < 0;
	uint64_t rest = negative ? 0 - (uint64_t)value : (uint64_t)value;
	char digits[FIXED_TEXT_MAX];
	int at = FIXED_TEXT_MAX;
	unsigned int left = decimals;

	digits[--at] = '\0';
	for (; left > 0 && rest % 10 == 0; left--) {
		rest /= 10;
	}
	for (; left > 0; left--) {
		digits[--at] = (char)('0' + rest % 10);
		rest /= 10;
		if (left == 1) {
			digits[--at] = '.';
		}
	}
	do {
		digits[--at] = (char)('0' + rest % 10);
		rest /= 10;
	} while (rest > 0);
	snprintk(text, FIXED_TEXT_MAX, "%s%s", negative ? "-" : "", &digits[at]);
}
