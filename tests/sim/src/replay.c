/* SPDX-License-Identifier: Apache-2.0 */
#include "replay.h"

#include <zephyr/ztest.h>

static unsigned int seed;

/* Steele, Lea, Flood: Fast splittable pseudorandom number generators (SplitMix64), 2014. */
uint32_t dice_next(struct dice *dice)
{
	dice->state += UINT64_C(0x9E3779B97F4A7C15);
	uint64_t mixed = dice->state;

	mixed = (mixed ^ (mixed >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
	mixed = (mixed ^ (mixed >> 27)) * UINT64_C(0x94D049BB133111EB);
	return (uint32_t)(mixed >> 32);
}

int64_t dice_between(struct dice *dice, int64_t low, int64_t high)
{
	const uint64_t wide = ((uint64_t)dice_next(dice) << 32) | dice_next(dice);

	return low + (int64_t)(wide % ((uint64_t)(high - low) + 1));
}

bool dice_once_in(struct dice *dice, uint32_t many)
{
	return dice_next(dice) % many == 0;
}

unsigned int replay_seed(void)
{
	return seed;
}

void replay_seeds(const char *suite, void (*run)(struct dice *dice))
{
	TC_PRINT("seeds %u to %u; replay: cmake -DPHAROS_SIM_SEED=SEED -DPHAROS_SIM_RUNS=1, "
	         "then sim_core --test %s\n",
	         (unsigned int)PHAROS_SIM_SEED,
	         (unsigned int)(PHAROS_SIM_SEED + PHAROS_SIM_RUNS - 1), suite);
	for (seed = PHAROS_SIM_SEED; seed < PHAROS_SIM_SEED + PHAROS_SIM_RUNS; seed++) {
		struct dice dice = {.state = seed};

		run(&dice);
	}
}
