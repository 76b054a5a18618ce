/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Decimal numbers for people, as integers scaled by a power of ten. Any context; no state.
 */
#ifndef PHAROS_CORE_DECIMAL_H
#define PHAROS_CORE_DECIMAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DECIMAL_DECIMALS_MAX 9
/* A sign, 19 digits, a point, a terminator. */
#define DECIMAL_TEXT_MAX     24

enum decimal_result {
	DECIMAL_NO_NUMBER, /* or too large for 64 bits */
	DECIMAL_ROUNDED,   /* digits beyond the decimals: the nearest, a half away from zero */
	DECIMAL_EXACT,
};

/*
 * "12", "-0.5", "12.3400" as value * 10^decimals, decimals 0…DECIMAL_DECIMALS_MAX. length: without
 * a terminator, which need not be there. NO_NUMBER: *value is unchanged.
 */
enum decimal_result decimal_parse(const char *text, size_t length, unsigned int decimals,
                                  int64_t *value);

/* A terminated text. False: it is no number, or not one of so few decimals. */
bool decimal_parse_exact(const char *text, unsigned int decimals, int64_t *value);

/* value / 10^decimals into text, terminated, without trailing zeros: "12", "-0.5". Its length. */
size_t decimal_print(char text[DECIMAL_TEXT_MAX], int64_t value, unsigned int decimals);

#endif
