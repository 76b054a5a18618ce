/* SPDX-License-Identifier: Apache-2.0 */
#include "ntc_math.h"

#define LOG2_FRACTION_BITS 20

/* ln 2 = 0.693147180559945 */
#define LN2_E9 693147181

/* 1 / 298.15 K = 0.003354016434680530 1/K */
#define INVERSE_T25_E12 INT64_C(3354016435)

#define ZERO_C_MK 273150

/* log2(x) with LOG2_FRACTION_BITS fraction bits; x > 0. Squares the mantissa once for each bit. */
static int32_t log2_fixed(uint32_t x)
{
	int32_t whole = 0;
	uint32_t fraction = 0;
	uint64_t mantissa; /* 1.0…2.0 as 2^31…2^32 */

	for (uint32_t rest = x; rest > 1; rest >>= 1) {
		whole++;
	}
	mantissa = (uint64_t)x << (31 - whole);
	for (int bit = LOG2_FRACTION_BITS - 1; bit >= 0; bit--) {
		mantissa = (mantissa * mantissa) >> 31;
		if (mantissa >= (UINT64_C(1) << 32)) {
			mantissa >>= 1;
			fraction |= UINT32_C(1) << bit;
		}
	}
	return whole * (1 << LOG2_FRACTION_BITS) + (int32_t)fraction;
}

int32_t ntc_temp_mdegc(const struct ntc_divider *divider, uint32_t code, uint32_t full)
{
	/* R / r25 = (code * pullup) / ((full - code) * r25) */
	const int32_t log2_ratio = log2_fixed(code) - log2_fixed(full - code) +
	                           log2_fixed(divider->pullup_ohms) - log2_fixed(divider->r25_ohms);
	/* at most 64 * 2^20 * 0.7e9 = 4.7e16; then 4.5e10 * 1000 */
	const int64_t ln_ratio_e9 = ((int64_t)log2_ratio * LN2_E9) / (1 << LOG2_FRACTION_BITS);
	const int64_t inverse_t_e12 =
		INVERSE_T25_E12 + (ln_ratio_e9 * 1000) / (int64_t)divider->beta_k;

	if (inverse_t_e12 <= 0) {
		return INT32_MAX;
	}

	const int64_t t_mk = INT64_C(1000000000000000) / inverse_t_e12;

	return t_mk > INT32_MAX ? INT32_MAX : (int32_t)t_mk - ZERO_C_MK;
}
