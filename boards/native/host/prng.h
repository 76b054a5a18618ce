/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Randomness of the simulated world. Each user has its own generator, derived from --seed and its
 * name, so that one more user changes nothing for the others. splitmix64 (Steele, Lea, Flood 2014).
 * Plain data: may be carried over a reset.
 */
#ifndef NATIVE_HOST_PRNG_H_
#define NATIVE_HOST_PRNG_H_

#include <stdbool.h>
#include <stdint.h>

struct prng {
	uint64_t state;
};

/* The value of --seed; 1 when it was not given. */
uint64_t prng_seed(void);

/* It was given. */
bool prng_is_seeded(void);

void prng_init(struct prng *prng, const char *name);

uint64_t prng_next(struct prng *prng);

/* 0…limit-1, limit > 0. */
uint32_t prng_below(struct prng *prng, uint32_t limit);

/* True with the given probability, 0…1 000 000. 0 draws nothing. */
bool prng_chance(struct prng *prng, uint32_t ppm);

#endif
