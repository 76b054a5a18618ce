/* SPDX-License-Identifier: Apache-2.0 */
/* Gaussian noise from a seed. Plain data; the same seed gives the same numbers on every machine. */
#ifndef NATIVE_MODELS_NOISE_H_
#define NATIVE_MODELS_NOISE_H_

#include <stdint.h>

struct noise {
	uint64_t state; /* the seed at first */
};

/* Mean 0, standard deviation 1, never beyond ±7.1. */
double noise_next(struct noise *self);

#endif
