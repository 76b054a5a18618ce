/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Random runs that can be replayed: the same seed gives the same run on any machine.
 *
 * A simulation is a function of a source of randomness. replay_seeds runs it with each of
 * PHAROS_SIM_RUNS seeds from PHAROS_SIM_SEED on, and prints before the first how to run them again;
 * a failure's message carries replay_seed().
 */
#ifndef TESTS_SIM_REPLAY_H
#define TESTS_SIM_REPLAY_H

#include <stdbool.h>
#include <stdint.h>

struct dice {
	uint64_t state;
};

void replay_seeds(const char *suite, void (*run)(struct dice *dice));

/* Of the run that is going on. */
unsigned int replay_seed(void);

/* 0…2^32 - 1. */
uint32_t dice_next(struct dice *dice);

/* low…high, both included. */
int64_t dice_between(struct dice *dice, int64_t low, int64_t high);

/* True once in so many. */
bool dice_once_in(struct dice *dice, uint32_t many);

#endif
