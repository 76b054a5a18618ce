/* SPDX-License-Identifier: Apache-2.0 */
#include "host/prng.h"

#include "host/module.h"

static uint64_t seed = 1;
static bool is_seeded;

uint64_t prng_seed(void)
{
	return seed;
}

bool prng_is_seeded(void)
{
	return is_seeded;
}

uint64_t prng_next(struct prng *prng)
{
	uint64_t z = (prng->state += 0x9E3779B97F4A7C15u);

	z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
	z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
	return z ^ (z >> 31);
}

void prng_init(struct prng *prng, const char *name)
{
	prng->state = seed;
	for (; *name != '\0'; name++) {
		prng->state = prng_next(prng) ^ (uint8_t)*name;
	}
}

uint32_t prng_below(struct prng *prng, uint32_t limit)
{
	return (uint32_t)(((prng_next(prng) >> 32) * limit) >> 32);
}

bool prng_chance(struct prng *prng, uint32_t ppm)
{
	return ppm != 0 && prng_below(prng, 1000000) < ppm;
}

static int parse_seed(const char *value, struct host_error *error)
{
	is_seeded = true;
	return parse_number(value, 0, UINT64_MAX, &seed, error);
}

static const struct host_option options[] = {
	{"seed", "N", "seed of all randomness: noise, injected faults (1)", parse_seed},
	{0},
};

HOST_MODULE(prng_module) = {
	.name = "simulation",
	.order = HOST_ORDER_BASE,
	.options = options,
};
