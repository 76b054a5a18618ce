/* SPDX-License-Identifier: Apache-2.0 */
/*
 * GPIO lines between the device and the world outside: bit n is line n. The device drives its
 * outputs; outside drives some of the others; what nobody drives follows its pull resistor, else it
 * is low. Plain data.
 */
#ifndef NATIVE_MODELS_LINES_H_
#define NATIVE_MODELS_LINES_H_

#include <stdint.h>

struct lines {
	/* the device's side */
	uint32_t output;
	uint32_t output_level;
	uint32_t pull_up;
	/* the world's side */
	uint32_t driven;
	uint32_t driven_level;
};

/* The level of each line. The device wins over the world on its outputs. */
uint32_t lines_levels(const struct lines *self);

/* The device is in reset: no outputs, no pulls. The world's side stays. */
void lines_reset(struct lines *self);

#endif
