/* SPDX-License-Identifier: Apache-2.0 */
/*
 * An hour of heat, cold and failing sensors per seed. The oracle is the promise itself, in floating
 * point and from the samples alone.
 */
#include "core/thermal.h"

#include <zephyr/ztest.h>

#include "core/limits.h"
#include "replay.h"

#define STEPS 36000 /* an hour of 100 ms */

static const struct thermal_config config = {
	.throttle_mdegc = 70000,
	.shutdown_mdegc = 85000,
	.recover_mdegc = 60000,
	.hysteresis_mdegc = 2000,
	.min_mdegc = -55000,
	.max_mdegc = 150000,
	.noise_mdegc = 1000,
	.max_rate_mdegc_per_s = 20000,
	.floor_ppm = 200000,
	.safe_ppm = 100000,
	.slew_ppm_per_s = 100000,
	.stuck_us = 30000000,
	.missing_us = 500000,
	.good_samples = 10,
};

enum trouble {
	TROUBLE_NONE,
	TROUBLE_OPEN,
	TROUBLE_SHORT,
	TROUBLE_NOISY,
	TROUBLE_STUCK,
	TROUBLE_SILENT,
	TROUBLES,
};

struct world {
	double temp_c;
	double ambient_c;
	enum trouble trouble;
	uint32_t raw;
};

/* Steps with these flags, of all seeds. */
static uint32_t seen[8];

ZTEST_SUITE(core_thermal_sim, NULL, NULL, NULL, NULL, NULL);

static void change_world(struct world *world, struct dice *dice)
{
	if (dice_once_in(dice, 600)) {
		world->ambient_c = (double)dice_between(dice, -30, 110);
	}
	if (dice_once_in(dice, 400)) {
		world->trouble = dice_once_in(dice, 2) ? TROUBLE_NONE : dice_next(dice) % TROUBLES;
	}
	world->temp_c += (world->ambient_c - world->temp_c) / 200; /* 20 s */
}

/* False: no sample. */
static bool take_sample(struct world *world, struct dice *dice, struct thermal_sample *sample)
{
	const double noise_c = (double)dice_between(dice, -200, 200) / 1000;

	*sample = (struct thermal_sample){
		.status = THERMAL_SAMPLE_OK,
		.temp_mdegc = (int32_t)((world->temp_c + noise_c) * 1000),
		.lit = true,
	};
	switch (world->trouble) {
	case TROUBLE_OPEN:
		sample->status = THERMAL_SAMPLE_OPEN;
		break;
	case TROUBLE_SHORT:
		sample->status = THERMAL_SAMPLE_SHORT;
		break;
	case TROUBLE_NOISY:
		sample->temp_mdegc = (int32_t)dice_between(dice, -80000, 200000);
		break;
	case TROUBLE_STUCK:
		sample->raw = world->raw;
		return true;
	case TROUBLE_SILENT:
		return false;
	case TROUBLE_NONE:
	case TROUBLES:
		break;
	}
	world->raw = dice_next(dice);
	sample->raw = world->raw;
	return true;
}

static double allowed_ppm(int32_t temp_mdegc)
{
	if (temp_mdegc >= 85000) {
		return 0;
	}
	return (temp_mdegc <= 70000) ? 1e6 : 1e6 - 0.8e6 * (temp_mdegc - 70000) / 15000.0;
}

static void assert_limit(const struct thermal_report *before, const struct thermal_report *now,
                         const struct thermal_sample *sample, int step)
{
	const bool readable = sample != NULL && sample->status == THERMAL_SAMPLE_OK;

	if (now->sensor == THERMAL_SENSOR_OK && readable) {
		zassert_true(now->limit_ppm <= allowed_ppm(sample->temp_mdegc),
		             "seed %u step %d: above the line", replay_seed(), step);
	}
	if (now->sensor == THERMAL_SENSOR_FAILED) {
		zassert_true(now->limit_ppm <= MIN(config.safe_ppm, before->limit_ppm),
		             "seed %u step %d: brighter by failure", replay_seed(), step);
	}
	if (sample != NULL && !readable) {
		zassert_equal(now->sensor, THERMAL_SENSOR_FAILED, "seed %u step %d", replay_seed(),
		              step);
	}
	if (sample != NULL && (sample->status == THERMAL_SAMPLE_SHORT ||
	                       (readable && sample->temp_mdegc > config.max_mdegc))) {
		zassert_true(now->limit_ppm == 0 && now->state == THERMAL_STATE_SHUTDOWN,
		             "seed %u step %d: hot beyond measure", replay_seed(), step);
	}
	if (before->sensor != THERMAL_SENSOR_WAITING) {
		/* 100 000 ppm/s for 100 ms since the last sample; gaps are failures. */
		zassert_true(now->limit_ppm <= before->limit_ppm + 10000,
		             "seed %u step %d: rises too fast", replay_seed(), step);
	}
}

static void assert_latch(const struct thermal_report *before, const struct thermal_report *now,
                         const struct thermal_sample *sample, int step)
{
	zassert_equal((now->flags & THERMAL_FLAG_SHUTDOWN) != 0,
	              now->state == THERMAL_STATE_SHUTDOWN, "seed %u step %d", replay_seed(), step);
	if (now->state == THERMAL_STATE_SHUTDOWN) {
		zassert_equal(now->limit_ppm, 0, "seed %u step %d", replay_seed(), step);
	}
	if (before->state == THERMAL_STATE_SHUTDOWN && now->state != THERMAL_STATE_SHUTDOWN) {
		zassert_true(now->sensor == THERMAL_SENSOR_OK && sample->temp_mdegc < 60000,
		             "seed %u step %d: unlatched early", replay_seed(), step);
	}
}

static void an_hour(struct dice *dice)
{
	struct world world = {.temp_c = 20, .ambient_c = 20};
	struct thermal thermal;
	bool in_range = false;
	int64_t now_us = 0;

	/* the first sample may already be none */
	world.trouble = dice_once_in(dice, 2) ? TROUBLE_NONE : dice_next(dice) % TROUBLES;
	thermal_init(&thermal, now_us, &config);
	for (int step = 0; step < STEPS; step++) {
		const struct thermal_report before = thermal.report;
		struct thermal_sample sample;

		change_world(&world, dice);
		now_us += 100000;
		const bool sampled = take_sample(&world, dice, &sample);
		const struct thermal_report now =
			thermal_step(&thermal, now_us, sampled ? &sample : NULL);

		assert_limit(&before, &now, sampled ? &sample : NULL, step);
		assert_latch(&before, &now, sampled ? &sample : NULL, step);
		in_range = in_range || (sampled && sample.status == THERMAL_SAMPLE_OK &&
		                        sample.temp_mdegc >= config.min_mdegc &&
		                        sample.temp_mdegc <= config.max_mdegc);
		zassert_true(in_range || now.limit_ppm == 0, "seed %u step %d: lit blindly",
		             replay_seed(), step);
		seen[now.flags]++;
	}
}

ZTEST(core_thermal_sim, test_an_hour_of_abuse_never_exceeds_the_limit)
{
	replay_seeds("core_thermal_sim", an_hour);
	if (PHAROS_SIM_RUNS < 10) {
		return; /* a replay need not have met everything */
	}
	zassert_true(seen[0] > 0, "never at ease");
	for (uint32_t flags = THERMAL_FLAG_THROTTLING; flags <= 6; flags++) {
		/* Throttling and shut down at once is no state. */
		zassert_equal(seen[flags] > 0, flags != 3, "flags %u: %u steps", flags,
		              seen[flags]);
	}
	zassert_equal(seen[7], 0);
}
