/* SPDX-License-Identifier: Apache-2.0 */
#include "models/noise.h"

/* 48 fair coins have variance 12; a uniform fraction between two heads' counts adds 1/12. */
#define COINS      48
#define STD_DEV    3.476108936769968 /* sqrt(12 + 1/12) */
#define UNIFORM_16 65536.0

/* splitmix64: Steele, Lea, Flood 2014 */
static uint64_t next(struct noise *self)
{
	uint64_t z = self->state += UINT64_C(0x9E3779B97F4A7C15);

	z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
	z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
	return z ^ (z >> 31);
}

double noise_next(struct noise *self)
{
	const uint64_t bits = next(self);
	const int heads = __builtin_popcountll(bits >> (64 - COINS));
	const double fraction = ((double)(bits & 0xFFFFu) + 0.5) / UNIFORM_16 - 0.5;

	return (heads - COINS / 2 + fraction) / STD_DEV;
}
