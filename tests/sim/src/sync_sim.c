/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A bouncing input against an oracle that looks at the line each microsecond: a level counts once
 * the line has had it for filter_us without a break.
 */
#include "core/sync.h"

#include <zephyr/ztest.h>

#include "core/limits.h"
#include "replay.h"

#define HORIZON_US 60000

struct oracle {
	bool active;
	int64_t differs_since_us; /* -1: the line is as filtered */
	int64_t activity_us;
	int64_t pulse_until_us;
};

ZTEST_SUITE(core_sync_sim, NULL, NULL, NULL, NULL, NULL);

static void count_change(struct oracle *oracle, const struct sync_config *config, int64_t now_us)
{
	oracle->active = !oracle->active;
	oracle->activity_us = now_us;
	oracle->differs_since_us = -1;
	if (oracle->active &&
	    (now_us >= oracle->pulse_until_us || config->retrigger == SYNC_RETRIGGER_EXTEND)) {
		oracle->pulse_until_us = now_us + config->pulse_us;
	}
}

static bool is_over(const struct oracle *oracle, const struct sync_config *config, int64_t now_us)
{
	return oracle->differs_since_us >= 0 &&
	       now_us - oracle->differs_since_us >= config->filter_us;
}

static enum sync_output oracle_tick(struct oracle *oracle, const struct sync_config *config,
                                    int64_t now_us, bool line_active)
{
	if (is_over(oracle, config, now_us)) {
		count_change(oracle, config, now_us);
	}
	if (line_active == oracle->active) {
		oracle->differs_since_us = -1;
	} else if (oracle->differs_since_us < 0) {
		oracle->differs_since_us = now_us;
	}
	if (is_over(oracle, config, now_us)) {
		count_change(oracle, config, now_us);
	}
	if (config->timeout_us > 0 && now_us - oracle->activity_us >= config->timeout_us) {
		static const enum sync_output policies[] = {
			[SYNC_POLICY_OFF] = SYNC_OUTPUT_DARK,
			[SYNC_POLICY_ON] = SYNC_OUTPUT_LIT,
			[SYNC_POLICY_INTERNAL] = SYNC_OUTPUT_INTERNAL,
		};

		return policies[config->policy];
	}
	const bool lit = (config->mode == SYNC_MODE_LEVEL) ? oracle->active
	                                                   : now_us < oracle->pulse_until_us;

	return lit ? SYNC_OUTPUT_LIT : SYNC_OUTPUT_DARK;
}

static struct sync_config any_config(struct dice *dice)
{
	return (struct sync_config){
		.mode = dice_next(dice) % 2,
		.polarity = dice_next(dice) % 2,
		.retrigger = dice_next(dice) % 2,
		.policy = dice_next(dice) % 3,
		.filter_us = (uint32_t)dice_between(dice, 0, 120),
		.pulse_us = (uint32_t)dice_between(dice, 1, 800),
		.timeout_us = dice_once_in(dice, 3) ? 0 : (uint32_t)dice_between(dice, 1, 3000),
	};
}

static void against_the_oracle(struct dice *dice)
{
	const struct sync_config config = any_config(dice);
	const uint32_t calm = (uint32_t)dice_between(dice, 100, 4000);
	const bool high_is_active = config.polarity == SYNC_ACTIVE_HIGH;
	bool level = dice_once_in(dice, 2);
	bool bouncing = false;
	struct oracle oracle = {.active = level == high_is_active, .differs_since_us = -1};
	struct sync sync;

	sync_init(&sync, 0, &config, level);
	for (int64_t now_us = 0; now_us < HORIZON_US; now_us++) {
		const bool due = now_us >= sync_deadline_us(&sync);
		bool changes;

		bouncing = bouncing ? !dice_once_in(dice, 300) : dice_once_in(dice, calm);
		changes = bouncing ? dice_once_in(dice, 40) : dice_once_in(dice, calm);
		level = level != changes;
		const enum sync_output expected =
			oracle_tick(&oracle, &config, now_us, level == high_is_active);

		if (changes) {
			sync_input(&sync, now_us, level);
		}
		/* Only at its own deadlines, and now and then: between them nothing may change. */
		const enum sync_output got = (due || changes || dice_once_in(dice, 50))
		                                     ? sync_advance(&sync, now_us)
		                                     : expected;

		zassert_equal(got, expected, "seed %u at %lld: %d, not %d", replay_seed(),
		              (long long)now_us, got, expected);
	}
}

ZTEST(core_sync_sim, test_bouncing_input_agrees_with_the_oracle)
{
	replay_seeds("core_sync_sim", against_the_oracle);
}
