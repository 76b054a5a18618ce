/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Random plans at random instants against an oracle that knows only the rule in strobe.h: at each
 * microsecond, a phase that is as long as the plan in force gives it ends. It has no grid, no
 * deadlines and no edges.
 */
#include "core/strobe.h"

#include <zephyr/ztest.h>

#include "core/limits.h"
#include "replay.h"

#define HORIZON_US 100000
#define UNENDING   INT64_MAX

struct oracle {
	struct light_plan plan;
	int64_t since_us;
	bool lit;
	int64_t shortest_us; /* that any plan in force during this phase gives it */
	int64_t longest_us;
};

ZTEST_SUITE(core_strobe_sim, NULL, NULL, NULL, NULL, NULL);

static int64_t given(const struct light_plan *plan, bool lit)
{
	if (!plan->on) {
		return lit ? 0 : UNENDING;
	}
	if (plan->period_us == 0) {
		return lit ? UNENDING : 0;
	}
	return lit ? plan->on_us : plan->period_us - plan->on_us;
}

static void note_plan(struct oracle *oracle)
{
	const int64_t length_us = given(&oracle->plan, oracle->lit);

	oracle->shortest_us = MIN(oracle->shortest_us, length_us);
	oracle->longest_us = MAX(oracle->longest_us, length_us);
}

static void begin_phase(struct oracle *oracle, int64_t now_us)
{
	oracle->lit = !oracle->lit;
	oracle->since_us = now_us;
	oracle->shortest_us = UNENDING;
	oracle->longest_us = 0;
	note_plan(oracle);
}

/* now_us is one microsecond after the call before. */
static void oracle_tick(struct oracle *oracle, int64_t now_us, const struct light_plan *change)
{
	if (now_us - oracle->since_us >= given(&oracle->plan, oracle->lit)) {
		begin_phase(oracle, now_us);
	}
	if (change == NULL) {
		return;
	}
	oracle->plan = *change;
	note_plan(oracle);
	if (now_us - oracle->since_us >= given(&oracle->plan, oracle->lit)) {
		const int64_t length_us = now_us - oracle->since_us;

		zassert_true(length_us >= oracle->shortest_us && length_us <= oracle->longest_us,
		             "seed %u at %lld", replay_seed(), (long long)now_us);
		begin_phase(oracle, now_us);
	}
}

static struct light_plan any_plan(struct dice *dice)
{
	struct light_plan plan = {.on = !dice_once_in(dice, 8), .level_ppm = dice_next(dice)};

	if (plan.on && !dice_once_in(dice, 8)) {
		plan.period_us = (uint32_t)dice_between(dice, STROBE_PERIOD_FLOOR_US, 900);
		plan.on_us = (uint32_t)dice_between(dice, 1, plan.period_us - 1);
	}
	return plan;
}

static void against_the_oracle(struct dice *dice)
{
	const uint32_t calm = (uint32_t)dice_between(dice, 10, 3000);
	struct strobe strobe;
	/* Dark for longer than any plan asks. */
	struct oracle oracle = {.since_us = -1000000, .shortest_us = UNENDING};

	strobe_init(&strobe);
	note_plan(&oracle);
	for (int64_t now_us = 0; now_us < HORIZON_US; now_us++) {
		const bool due = now_us >= strobe_deadline_us(&strobe);
		const bool changes = dice_once_in(dice, calm);
		const struct light_plan plan = changes ? any_plan(dice) : oracle.plan;

		oracle_tick(&oracle, now_us, changes ? &plan : NULL);
		if (changes) {
			strobe_set(&strobe, now_us, &plan);
		} else if (due || dice_once_in(dice, 50)) {
			strobe_advance(&strobe, now_us);
		}
		zassert_equal(strobe.lit, oracle.lit, "seed %u at %lld", replay_seed(),
		              (long long)now_us);
		zassert_true(strobe_deadline_us(&strobe) > now_us, "seed %u at %lld", replay_seed(),
		             (long long)now_us);
	}
	zassert_equal(strobe.stats.missed, 0, "seed %u", replay_seed());
}

ZTEST(core_strobe_sim, test_any_change_at_any_instant_agrees_with_the_oracle)
{
	replay_seeds("core_strobe_sim", against_the_oracle);
}

/* Called late and seldom: the gate is where a punctual one is, and every edge is accounted for. */
static void late_calls(struct dice *dice)
{
	struct strobe late;
	struct strobe punctual;
	int64_t now_us = dice_between(dice, 0, 1000000000);

	strobe_init(&late);
	strobe_init(&punctual);
	for (int i = 0; i < 300; i++) {
		const struct light_plan plan = any_plan(dice);
		const bool changes = dice_once_in(dice, 10);

		now_us += dice_between(dice, 0, 5000);
		while (strobe_deadline_us(&punctual) <= now_us) {
			strobe_advance(&punctual, strobe_deadline_us(&punctual));
		}
		if (changes) {
			strobe_set(&punctual, now_us, &plan);
			strobe_set(&late, now_us, &plan);
		} else {
			strobe_advance(&late, now_us);
		}
		zassert_equal(late.lit, punctual.lit, "seed %u, call %d", replay_seed(), i);
		zassert_equal(strobe_deadline_us(&late), strobe_deadline_us(&punctual),
		              "seed %u, call %d", replay_seed(), i);
		zassert_equal(late.stats.edges + late.stats.missed, punctual.stats.edges,
		              "seed %u, call %d", replay_seed(), i);
	}
}

ZTEST(core_strobe_sim, test_late_calls_end_where_punctual_ones_do)
{
	replay_seeds("core_strobe_sim", late_calls);
}
