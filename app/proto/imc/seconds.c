/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/seconds.h"

#include <string.h>

/* IEEE 754 binary64. */
#define SIGN          (1ull << 63)
#define MANTISSA_BITS 52
#define MANTISSA_MASK ((1ull << MANTISSA_BITS) - 1)
#define EXPONENT_MASK 0x7FFu
#define EXPONENT_BIAS 1023

/* Bits of a fraction of a second: 2^43 times 10^6 fits 63 bits. */
#define FRACTION_BITS 43

bool imc_seconds_to_us(double seconds, int64_t *us)
{
	uint64_t bits;

	memcpy(&bits, &seconds, sizeof(bits));

	/* seconds = mantissa / 2^shift; those too small for a first bit are nothing in us */
	const uint64_t mantissa = (bits & MANTISSA_MASK) | 1ull << MANTISSA_BITS;
	const int exponent = (int)(bits >> MANTISSA_BITS & EXPONENT_MASK);
	int shift = EXPONENT_BIAS + MANTISSA_BITS - exponent;

	if (shift <= 0) {
		return false; /* 2^52 s and more, infinite, NaN */
	}

	const uint64_t whole = shift < 64 ? mantissa >> shift : 0;
	uint64_t fraction = shift < 64 ? mantissa & ((1ull << shift) - 1) : mantissa;

	if (whole > TIME_MAX_US / US_PER_S - 1) {
		return false;
	}
	if (shift > FRACTION_BITS) {
		const int excess = shift - FRACTION_BITS;

		fraction = excess < 64 ? fraction >> excess : 0;
		shift = FRACTION_BITS;
	}

	const uint64_t half = 1ull << (shift - 1);
	const int64_t magnitude =
		(int64_t)(whole * US_PER_S + ((fraction * US_PER_S + half) >> shift));

	*us = (bits & SIGN) != 0 ? -magnitude : magnitude;
	return true;
}

double imc_seconds_from_us(int64_t time_us)
{
	const uint64_t whole = (uint64_t)time_us / US_PER_S;
	const uint64_t rest = (uint64_t)time_us % US_PER_S;
	int shift = FRACTION_BITS;
	double seconds;

	if (time_us == 0) {
		return 0;
	}
	while (whole >> (63 - shift) != 0) {
		shift--;
	}

	/* seconds = value / 2^shift, from here with its first bit at MANTISSA_BITS */
	uint64_t value = (whole << shift) + (rest << shift) / US_PER_S;
	uint64_t dropped = 0;

	while (value >> (MANTISSA_BITS + 1) != 0) {
		dropped = value & 1;
		value >>= 1;
		shift--;
	}
	while (value >> MANTISSA_BITS == 0) {
		value <<= 1;
		shift++;
	}
	value += dropped; /* may carry into the exponent, which is then right */

	const uint64_t bits =
		((uint64_t)(EXPONENT_BIAS + MANTISSA_BITS - shift - 1) << MANTISSA_BITS) + value;

	memcpy(&seconds, &bits, sizeof(seconds));
	return seconds;
}
