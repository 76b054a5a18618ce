/* SPDX-License-Identifier: Apache-2.0 */
/* Light programs: their patterns to the microsecond, no drift, and what is valid. */
#include "core/program.h"

#include <string.h>

#include <zephyr/ztest.h>

ZTEST_SUITE(core_program, NULL, NULL, NULL, NULL, NULL);

static const struct program anti_collision = {
	.kind = PROGRAM_ANTI_COLLISION, .period_us = 1000000, .unit_us = 100000};
static const struct program double_flash = {
	.kind = PROGRAM_DOUBLE_FLASH, .period_us = 1500000, .unit_us = 50000};
static const struct program fade = {.kind = PROGRAM_FADE, .period_us = 4000000};
static const struct program sos = {.kind = PROGRAM_SOS, .unit_us = 200000};

/* Edges from the origin on: lit until edges[0], dark until edges[1], … */
static void assert_edges(const struct program *program, int64_t origin_us, const int64_t *edges,
                         size_t count)
{
	int64_t at_us = origin_us;

	for (size_t i = 0; i < count; i++) {
		const struct program_phase phase = program_at(program, at_us);

		zassert_equal(phase.scale_ppm, i % 2 == 0 ? 1000000 : 0, "part %u", (unsigned)i);
		zassert_equal(phase.until_us, origin_us + edges[i], "part %u", (unsigned)i);
		/* its last microsecond is the same part */
		zassert_equal(program_at(program, phase.until_us - 1).until_us, phase.until_us);
		at_us = phase.until_us;
	}
}

ZTEST(core_program, test_anti_collision_flashes_once_a_cycle)
{
	static const int64_t edges[] = {100000, 1000000, 1100000, 2000000};

	assert_edges(&anti_collision, 0, edges, 4);
}

ZTEST(core_program, test_double_flash_is_two_flashes_a_cycle)
{
	static const int64_t edges[] = {50000, 100000, 150000, 1500000, 1550000};

	assert_edges(&double_flash, 0, edges, 5);
}

/*
 * ITU-R M.1677-1: a dash is three dots; signals of a letter are one dot apart, letters three,
 * words seven. With a dot of 200 ms:
 * S 0.2 on .2 off .2 on .2 off .2 on | .6 off | O .6 on .2 off … | .6 off | S | 1.4 off = 6.8 s
 */
ZTEST(core_program, test_sos_is_morse)
{
	static const int64_t edges[] = {
		200000,  400000,  600000,  800000,  1000000, 1600000, /* S */
		2200000, 2400000, 3000000, 3200000, 3800000, 4400000, /* O */
		4600000, 4800000, 5000000, 5200000, 5400000, 6800000, /* S */
	};

	assert_edges(&sos, 0, edges, 18);
	zassert_equal(program_period_us(&sos), 6800000);
}

ZTEST(core_program, test_ten_years_later_nothing_has_drifted)
{
	/* 315 360 000 s of whole seconds; the first multiple of 6.8 s after that is 46 376 471 */
	static const int64_t ten_years_us = INT64_C(315360000000000);
	static const int64_t edges[] = {200000, 400000, 600000, 800000, 1000000, 1600000, 2200000};
	static const int64_t flash[] = {100000, 1000000};

	assert_edges(&anti_collision, ten_years_us, flash, 2);
	assert_edges(&sos, INT64_C(46376471) * 6800000, edges, 7);
}

ZTEST(core_program, test_fade_rises_and_falls_evenly_to_the_eye)
{
	int64_t at_us = 0;
	uint32_t before_ppm = 0;

	for (int step = 0; step < 200; step++) { /* 4 s in steps of 20 ms */
		const struct program_phase phase = program_at(&fade, at_us);

		zassert_equal(phase.until_us, at_us + 20000);
		if (step > 0 && step < 100) {
			zassert_true(phase.scale_ppm > before_ppm, "step %d", step);
		} else if (step > 100) {
			zassert_true(phase.scale_ppm < before_ppm, "step %d", step);
		}
		before_ppm = phase.scale_ppm;
		at_us = phase.until_us;
	}
	/* the middle of step 25 is 0.51 s of the 2 s up: 0.255 squared */
	zassert_equal(program_at(&fade, 500000).scale_ppm, 65025);
	/* of step 50, 1.01 s: 0.505 squared, and the same on the way down */
	zassert_equal(program_at(&fade, 1000000).scale_ppm, 255025);
	zassert_equal(program_at(&fade, 2980000).scale_ppm, 255025);
	/* of the last before the top: 0.995 squared */
	zassert_equal(program_at(&fade, 1980000).scale_ppm, 990025);
	zassert_true(program_at(&fade, 0).scale_ppm < 100);
	/* the next breath is the same */
	zassert_equal(program_at(&fade, INT64_C(4000000) * 1000 + 1000000).scale_ppm, 255025);
}

ZTEST(core_program, test_a_fade_whose_period_is_no_multiple_of_the_step_ends_with_a_shorter_one)
{
	const struct program odd = {.kind = PROGRAM_FADE, .period_us = 501000};

	zassert_equal(program_at(&odd, 500000).until_us, 501000);
	zassert_equal(program_at(&odd, 501000).until_us, 521000);
}

ZTEST(core_program, test_what_does_not_fit_is_not_valid)
{
	static const struct program bad[] = {
		{.kind = PROGRAM_ANTI_COLLISION, .period_us = 100000, .unit_us = 100000},
		{.kind = PROGRAM_ANTI_COLLISION, .period_us = 100000, .unit_us = 0},
		{.kind = PROGRAM_ANTI_COLLISION, .period_us = 0, .unit_us = 0},
		{.kind = PROGRAM_DOUBLE_FLASH, .period_us = 300000, .unit_us = 100000},
		{.kind = PROGRAM_FADE, .period_us = 39999},
		{.kind = PROGRAM_FADE, .period_us = 3600000001u},
		{.kind = PROGRAM_SOS, .unit_us = 0},
		{.kind = PROGRAM_SOS, .unit_us = 200000000},
		{.kind = (enum program_kind)5},
	};
	const struct program none = {.kind = PROGRAM_NONE};

	for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
		zassert_false(program_valid(&bad[i]), "%u", (unsigned)i);
	}
	zassert_true(program_valid(&none));
	zassert_true(program_valid(&anti_collision));
	zassert_true(program_valid(&double_flash));
	zassert_true(program_valid(&fade));
	zassert_true(program_valid(&sos));
}

ZTEST(core_program, test_names)
{
	for (int i = 0; i < PROGRAM_KINDS; i++) {
		for (int k = 0; k < i; k++) {
			zassert_not_equal(strcmp(program_name((enum program_kind)i),
			                         program_name((enum program_kind)k)),
			                  0);
		}
	}
	zassert_equal(strcmp(program_name(PROGRAM_SOS), "sos"), 0);
}
