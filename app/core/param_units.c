/* SPDX-License-Identifier: Apache-2.0 */
#include "core/param_units.h"

/* IEEE 754 binary32. */
#define SIGN          (1u << 31)
#define MANTISSA_BITS 23
#define MANTISSA_MASK ((1u << MANTISSA_BITS) - 1)
#define EXPONENT_MASK 0xFFu
#define EXPONENT_BIAS 127
/* 2^32, which no int32_t holds. */
#define EXPONENT_OVER (EXPONENT_BIAS + 32)

/* A value of the table, times this, fits 64 bits with all the digits that a binary32 needs. */
#define GUARD_BITS 39

static uint32_t scale_of(const struct param_info *info)
{
	uint32_t scale = 1;

	for (uint8_t i = 0; i < info->decimals; i++) {
		scale *= 10;
	}
	return scale;
}

static bool is_whole_only(const struct param_info *info)
{
	return info->unit[0] == '\0';
}

static bool narrow(int64_t wide, int32_t *value)
{
	if (wide < INT32_MIN || wide > INT32_MAX) {
		return false;
	}
	*value = (int32_t)wide;
	return true;
}

uint32_t param_to_real(const struct param_info *info, int32_t value)
{
	const uint32_t scale = scale_of(info);
	/* magnitude * 2^(exponent - EXPONENT_BIAS - MANTISSA_BITS), bits 0…24 in the end */
	uint64_t magnitude = value < 0 ? 0u - (uint32_t)value : (uint32_t)value;
	uint32_t exponent = EXPONENT_BIAS + MANTISSA_BITS - GUARD_BITS;
	bool rest;

	if (magnitude == 0) {
		return 0;
	}
	for (; magnitude < 1u << 24; exponent--) {
		magnitude <<= 1;
	}
	magnitude <<= GUARD_BITS;
	rest = magnitude % scale != 0;
	magnitude /= scale;
	for (; magnitude >= 1u << 25; exponent++) {
		rest = rest || (magnitude & 1) != 0;
		magnitude >>= 1;
	}

	/* One bit too many: it rounds, and may carry into the exponent, which is then right. */
	const bool up = (magnitude & 1) != 0 && (rest || (magnitude & 2) != 0);
	const uint32_t mantissa = (uint32_t)(magnitude >> 1) - (1u << MANTISSA_BITS) + (up ? 1 : 0);

	return (value < 0 ? SIGN : 0) | (((exponent + 1) << MANTISSA_BITS) + mantissa);
}

bool param_from_real(const struct param_info *info, uint32_t real, int32_t *value)
{
	const uint32_t exponent = real >> MANTISSA_BITS & EXPONENT_MASK;
	const uint64_t mantissa = (real & MANTISSA_MASK) | 1u << MANTISSA_BITS;
	/* Below 2^44; of what is too small for a first bit nothing is left below. */
	uint64_t scaled = mantissa * scale_of(info);

	if (exponent >= EXPONENT_OVER) { /* and infinities, and NaN */
		return false;
	}
	if (exponent >= EXPONENT_BIAS + MANTISSA_BITS) {
		scaled <<= exponent - EXPONENT_BIAS - MANTISSA_BITS;
	} else {
		const uint32_t shift = EXPONENT_BIAS + MANTISSA_BITS - exponent;
		const uint64_t dropped = shift < 63 ? scaled & ((1ull << shift) - 1) : scaled;
		const bool is_zero = (real & ~SIGN) == 0;

		if (dropped != 0 && !is_zero && is_whole_only(info)) {
			return false;
		}
		scaled = shift < 63 ? (scaled + (1ull << (shift - 1))) >> shift : 0;
	}
	return narrow((real & SIGN) != 0 ? -(int64_t)scaled : (int64_t)scaled, value);
}

bool param_from_integer(const struct param_info *info, int64_t number, int32_t *value)
{
	if (number < INT32_MIN || number > INT32_MAX) {
		return false;
	}
	return narrow(number * (int64_t)scale_of(info), value);
}

size_t param_print(const struct param_info *info, int32_t value, char text[DECIMAL_TEXT_MAX])
{
	return decimal_print(text, value, info->decimals);
}

bool param_parse(const struct param_info *info, const char *text, size_t length, int32_t *value)
{
	int64_t parsed = 0;

	switch (decimal_parse(text, length, info->decimals, &parsed)) {
	case DECIMAL_NO_NUMBER:
		return false;
	case DECIMAL_ROUNDED:
		return !is_whole_only(info) && narrow(parsed, value);
	case DECIMAL_EXACT:
		break;
	}
	return narrow(parsed, value);
}
