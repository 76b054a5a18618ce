/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Programs shown by the gate, called late and seldom and disturbed by changes of brightness,
 * against an oracle that knows each pattern as a list of lengths and walks through it from where
 * the program began, part by part: it neither divides nor skips.
 */
#include "core/gate.h"

#include <zephyr/ztest.h>

#include "core/limits.h"
#include "replay.h"

#define UNIT_MAX_US 3000

struct oracle {
	int64_t lengths_us[18]; /* lit, dark, lit, … */
	size_t count;
	size_t part;
	int64_t end_us;
};

ZTEST_SUITE(core_program_sim, NULL, NULL, NULL, NULL, NULL);

static void begin(struct oracle *oracle, const struct program *program, int64_t now_us)
{
	/* S, O, S in dots: ITU-R M.1677-1 */
	static const uint8_t sos[18] = {1, 1, 1, 1, 1, 3, 3, 1, 3, 1, 3, 3, 1, 1, 1, 1, 1, 7};
	const int64_t unit_us = program->unit_us;
	const int64_t period_us = program->period_us;

	oracle->part = 0;
	switch (program->kind) {
	case PROGRAM_ANTI_COLLISION:
		oracle->lengths_us[0] = unit_us;
		oracle->lengths_us[1] = period_us - unit_us;
		oracle->count = 2;
		break;
	case PROGRAM_DOUBLE_FLASH:
		oracle->lengths_us[0] = unit_us;
		oracle->lengths_us[1] = unit_us;
		oracle->lengths_us[2] = unit_us;
		oracle->lengths_us[3] = period_us - 3 * unit_us;
		oracle->count = 4;
		break;
	case PROGRAM_SOS:
		for (size_t i = 0; i < 18; i++) {
			oracle->lengths_us[i] = sos[i] * unit_us;
		}
		oracle->count = 18;
		break;
	case PROGRAM_NONE:
	case PROGRAM_FADE:
		zassert_unreachable("not a pattern of flashes");
		break;
	}
	oracle->end_us = now_us + oracle->lengths_us[0];
}

static bool lit_at(struct oracle *oracle, int64_t now_us)
{
	while (now_us >= oracle->end_us) {
		oracle->part = oracle->part + 1 == oracle->count ? 0 : oracle->part + 1;
		oracle->end_us += oracle->lengths_us[oracle->part];
	}
	return oracle->part % 2 == 0;
}

static struct program any_program(struct dice *dice)
{
	static const enum program_kind kinds[] = {PROGRAM_ANTI_COLLISION, PROGRAM_DOUBLE_FLASH,
	                                          PROGRAM_SOS};
	struct program program = {.kind = kinds[dice_between(dice, 0, 2)]};

	program.unit_us = (uint32_t)dice_between(dice, 1, UNIT_MAX_US);
	if (program.kind != PROGRAM_SOS) {
		program.period_us =
			3 * program.unit_us + (uint32_t)dice_between(dice, 1, 5 * UNIT_MAX_US);
	}
	return program;
}

static void flashes(struct dice *dice)
{
	const struct sync_config sync = {.pulse_us = 1};
	int64_t now_us = dice_between(dice, 0, 1000000000);
	struct light_plan plan = {.on = true, .level_ppm = PPM_ONE};
	struct oracle oracle;
	struct gate gate;

	gate_init(&gate, now_us, &sync, false);
	plan.program = any_program(dice);
	gate_set(&gate, now_us, &plan);
	begin(&oracle, &plan.program, now_us);
	for (int i = 0; i < 2000; i++) {
		bool lit;

		now_us = dice_once_in(dice, 3) ? now_us + dice_between(dice, 0, 100000)
		                               : gate_deadline_us(&gate);
		if (dice_once_in(dice, 100)) {
			plan.program = any_program(dice);
			lit = gate_set(&gate, now_us, &plan);
			begin(&oracle, &plan.program, now_us);
		} else if (dice_once_in(dice, 5)) {
			plan.level_ppm = (uint32_t)dice_between(dice, 1, PPM_ONE);
			lit = gate_set(&gate, now_us, &plan);
		} else {
			lit = gate_advance(&gate, now_us);
		}
		zassert_equal(lit, lit_at(&oracle, now_us), "seed %u at %lld", replay_seed(),
		              (long long)now_us);
		zassert_equal(gate_deadline_us(&gate), oracle.end_us, "seed %u at %lld",
		              replay_seed(), (long long)now_us);
		zassert_equal(gate_level_ppm(&gate), lit ? plan.level_ppm : 0, "seed %u at %lld",
		              replay_seed(), (long long)now_us);
	}
}

ZTEST(core_program_sim, test_flashes_agree_with_the_oracle)
{
	replay_seeds("core_program_sim", flashes);
}

/* Whatever is asked of it at whatever time, a fade is no brighter than its lamp was told to be. */
static void fades(struct dice *dice)
{
	const struct program program = {
		.kind = PROGRAM_FADE,
		.period_us = (uint32_t)dice_between(dice, 500000, 60000000),
	};
	int64_t now_us = dice_between(dice, 0, TIME_MAX_US / 2);

	for (int i = 0; i < 2000; i++) {
		const struct program_phase phase = program_at(&program, now_us);

		zassert_true(phase.scale_ppm <= PPM_ONE, "seed %u", replay_seed());
		zassert_true(phase.until_us > now_us, "seed %u", replay_seed());
		zassert_true(phase.until_us - now_us <= PROGRAM_FADE_STEP_US, "seed %u",
		             replay_seed());
		now_us += dice_between(dice, 0, 100000);
	}
}

ZTEST(core_program_sim, test_a_fade_is_never_brighter_than_its_lamp)
{
	replay_seeds("core_program_sim", fades);
}
