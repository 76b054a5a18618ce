/* SPDX-License-Identifier: Apache-2.0 */
#include "core/decimal.h"

#include <string.h>

static bool is_digit(char c)
{
	return c >= '0' && c <= '9';
}

static bool append_digit(int64_t *value, char digit)
{
	const int64_t units = digit - '0';

	if (*value > (INT64_MAX - units) / 10) {
		return false;
	}
	*value = *value * 10 + units;
	return true;
}

struct parser {
	int64_t value;
	unsigned int missing; /* decimals yet to come */
	bool dropped;         /* digits beyond them that are not 0 */
	bool up;              /* the first of those is 5 or more */
};

/* False: too large. */
static bool add_fraction(struct parser *parser, const char *digits, size_t count)
{
	bool first = true;

	for (size_t i = 0; i < count; i++) {
		if (parser->missing > 0) {
			parser->missing--;
			if (!append_digit(&parser->value, digits[i])) {
				return false;
			}
			continue;
		}
		parser->up = parser->up || (first && digits[i] >= '5');
		parser->dropped = parser->dropped || digits[i] != '0';
		first = false;
	}
	for (; parser->missing > 0; parser->missing--) {
		if (!append_digit(&parser->value, '0')) {
			return false;
		}
	}
	return true;
}

static size_t count_digits(const char *text, size_t at, size_t length)
{
	size_t count = 0;

	while (at + count < length && is_digit(text[at + count])) {
		count++;
	}
	return count;
}

enum decimal_result decimal_parse(const char *text, size_t length, unsigned int decimals,
                                  int64_t *value)
{
	const bool negative = length > 0 && text[0] == '-';
	struct parser parser = {.missing = decimals};
	size_t at = negative ? 1 : 0;
	const size_t whole = count_digits(text, at, length);
	size_t fraction = 0;

	for (size_t i = 0; i < whole; i++) {
		if (!append_digit(&parser.value, text[at++])) {
			return DECIMAL_NO_NUMBER;
		}
	}
	if (at < length && text[at] == '.') {
		fraction = count_digits(text, ++at, length);
	}
	if (whole == 0 || at + fraction != length || !add_fraction(&parser, &text[at], fraction) ||
	    (parser.up && parser.value == INT64_MAX)) {
		return DECIMAL_NO_NUMBER;
	}
	parser.value += parser.up ? 1 : 0;
	*value = negative ? -parser.value : parser.value;
	return parser.dropped ? DECIMAL_ROUNDED : DECIMAL_EXACT;
}

bool decimal_parse_exact(const char *text, unsigned int decimals, int64_t *value)
{
	int64_t parsed;

	if (decimal_parse(text, strlen(text), decimals, &parsed) != DECIMAL_EXACT) {
		return false;
	}
	*value = parsed;
	return true;
}

size_t decimal_print(char text[DECIMAL_TEXT_MAX], int64_t value, unsigned int decimals)
{
	uint64_t rest = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
	char digits[DECIMAL_TEXT_MAX];
	size_t at = DECIMAL_TEXT_MAX;
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
	if (value < 0) {
		digits[--at] = '-';
	}
	memcpy(text, &digits[at], DECIMAL_TEXT_MAX - at);
	return DECIMAL_TEXT_MAX - 1 - at;
}
