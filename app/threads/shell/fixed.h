/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Decimal numbers for people, as integers scaled by a power of ten.
 */
#ifndef PHAROS_THREADS_FIXED_H
#define PHAROS_THREADS_FIXED_H

#include <stdbool.h>
#include <stdint.h>

#define FIXED_DECIMALS_MAX 9
/* A sign, 19 digits, a point, a terminator. */
#define FIXED_TEXT_MAX     24

/*
 * "12", "-0.5", "12.3400" as value * 10^decimals; digits beyond the decimals must be 0, decimals
 * 0…FIXED_DECIMALS_MAX. False: not such a number, or too large for 64 bits; *value unchanged.
 */
bool fixed_parse(const char *text, unsigned int decimals, int64_t *value);

/* value / 10^decimals into text, without trailing zeros: "12", "-0.5". */
void fixed_format(char text[FIXED_TEXT_MAX], int64_t value, unsigned int decimals);

#endif
