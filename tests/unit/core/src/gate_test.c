/* SPDX-License-Identifier: Apache-2.0 */
#include "core/gate.h"

#include <zephyr/ztest.h>

#include "core/limits.h"

static struct gate gate;

static const struct sync_config level_off = {.filter_us = 10, .pulse_us = 1};
static const struct sync_config level_internal = {
	.filter_us = 10, .pulse_us = 1, .timeout_us = 5000, .policy = SYNC_POLICY_INTERNAL};
static const struct light_plan strobing = {
	.on = true, .level_ppm = 1, .period_us = 1000, .on_us = 300};
static const struct light_plan following = {
	.on = true, .external_sync = true, .level_ppm = 1, .period_us = 1000, .on_us = 300};
static const struct light_plan off = {.on = false};

static void before(void *fixture)
{
	gate_init(&gate, 0, &level_off, false);
}

ZTEST_SUITE(core_gate, NULL, NULL, before, NULL, NULL);

ZTEST(core_gate, test_starts_dark)
{
	zassert_false(gate_advance(&gate, 100));
	zassert_equal(gate_deadline_us(&gate), TIME_NEVER_US);
}

ZTEST(core_gate, test_internal_strobe_ignores_the_input)
{
	zassert_true(gate_set(&gate, 100, &strobing));
	zassert_true(gate_input(&gate, 150, true));
	zassert_equal(gate_deadline_us(&gate), 400);
	zassert_false(gate_input(&gate, 500, false));
	zassert_equal(gate_deadline_us(&gate), 1100);
	zassert_true(gate_advance(&gate, 1100));
}

ZTEST(core_gate, test_external_follows_the_input)
{
	zassert_false(gate_set(&gate, 100, &following));
	zassert_false(gate_input(&gate, 200, true));
	zassert_equal(gate_deadline_us(&gate), 210);
	zassert_true(gate_advance(&gate, 210));
	zassert_equal(gate_deadline_us(&gate), TIME_NEVER_US);
}

ZTEST(core_gate, test_input_level_told_before_counts_when_following_begins)
{
	gate_input(&gate, 50, true);
	zassert_true(gate_set(&gate, 100, &following));
}

ZTEST(core_gate, test_off_wins_over_the_input)
{
	gate_set(&gate, 100, &following);
	gate_input(&gate, 200, true);
	zassert_true(gate_advance(&gate, 300));
	zassert_false(gate_set(&gate, 400, &off));
	zassert_equal(gate_deadline_us(&gate), TIME_NEVER_US);
	zassert_false(gate_input(&gate, 500, false));
	zassert_false(gate_input(&gate, 600, true));
}

ZTEST(core_gate, test_internal_strobe_stands_in_after_the_time_out)
{
	gate_configure(&gate, 0, &level_internal);
	zassert_false(gate_set(&gate, 1000, &following));
	zassert_equal(gate_deadline_us(&gate), 6000);
	zassert_true(gate_advance(&gate, 6000));
	zassert_equal(gate_deadline_us(&gate), 6300);
	zassert_false(gate_advance(&gate, 6300));
	zassert_true(gate_advance(&gate, 7000));
	/* The input comes back: inactive is dark, whatever the strobe was at. */
	gate_input(&gate, 7100, true);
	zassert_true(gate_advance(&gate, 7110));
	zassert_equal(gate_deadline_us(&gate), 12110, "no edge of the strobe is left");
	gate_input(&gate, 7200, false);
	zassert_false(gate_advance(&gate, 7210));
	zassert_equal(gate_deadline_us(&gate), 12210);
}

ZTEST(core_gate, test_stand_in_stops_when_the_input_comes_back_dark)
{
	gate_configure(&gate, 0, &level_internal);
	gate_input(&gate, 500, true);
	zassert_true(gate_set(&gate, 1000, &following));
	zassert_true(gate_advance(&gate, 6000), "the strobe begins lit");
	gate_input(&gate, 6050, false);
	zassert_false(gate_advance(&gate, 6060));
	zassert_equal(gate_deadline_us(&gate), 11060, "no edge of the strobe is left");
}

ZTEST(core_gate, test_internal_plan_knows_no_time_out)
{
	const struct light_plan steady = {.on = true, .level_ppm = 1};

	gate_configure(&gate, 0, &level_internal);
	gate_set(&gate, 1000, &following);
	zassert_true(gate_set(&gate, 2000, &steady));
	zassert_equal(gate_deadline_us(&gate), TIME_NEVER_US);
	zassert_true(gate_advance(&gate, 100000));
}

ZTEST(core_gate, test_brightness_alone_does_not_restart_the_time_out)
{
	struct light_plan dimmer = following;

	dimmer.level_ppm = 2;
	gate_configure(&gate, 0, &level_internal);
	gate_set(&gate, 1000, &following);
	gate_set(&gate, 4000, &dimmer);
	zassert_equal(gate_deadline_us(&gate), 6000);
}

ZTEST(core_gate, test_time_that_runs_behind_counts_as_the_last)
{
	gate_set(&gate, 1000, &strobing);
	zassert_true(gate_input(&gate, 900, true));
	zassert_equal(gate_deadline_us(&gate), 1300);
}

/* --- programs --------------------------------------------------------------------------------- */

static const struct light_plan breathing = {
	.on = true, .level_ppm = 400000, .program = {.kind = PROGRAM_FADE, .period_us = 4000000}};
static const struct light_plan morse = {
	.on = true, .level_ppm = 400000, .program = {.kind = PROGRAM_SOS, .unit_us = 200000}};

ZTEST(core_gate, test_program_begins_with_its_plan_and_ends_with_it)
{
	const struct light_plan steady = {.on = true, .level_ppm = 400000};

	zassert_true(gate_set(&gate, 1000, &morse));
	zassert_equal(gate_deadline_us(&gate), 201000);
	zassert_equal(gate_level_ppm(&gate), 400000);
	zassert_false(gate_advance(&gate, 201000));
	zassert_equal(gate_deadline_us(&gate), 401000);
	zassert_true(gate_advance(&gate, 401000));
	zassert_true(gate_set(&gate, 500000, &steady));
	zassert_equal(gate_deadline_us(&gate), TIME_NEVER_US);
	zassert_true(gate_set(&gate, 600000, &morse)); /* from its beginning */
	zassert_equal(gate_deadline_us(&gate), 800000);
	zassert_false(gate_set(&gate, 700000, &off));
	zassert_equal(gate_deadline_us(&gate), TIME_NEVER_US);
}

ZTEST(core_gate, test_program_scales_the_level)
{
	gate_set(&gate, 0, &breathing);
	gate_advance(&gate, 1000000);
	zassert_equal(gate_level_ppm(&gate), 102010); /* 0.505 squared of 400 000 */
	zassert_equal(gate_deadline_us(&gate), 1020000);
}

ZTEST(core_gate, test_brighter_or_darker_does_not_disturb_a_program)
{
	struct light_plan brighter = morse;

	gate_set(&gate, 0, &morse);
	brighter.level_ppm = 800000;
	zassert_true(gate_set(&gate, 150000, &brighter));
	zassert_equal(gate_level_ppm(&gate), 800000);
	zassert_equal(gate_deadline_us(&gate), 200000);
}

ZTEST(core_gate, test_program_with_other_timing_starts_anew)
{
	struct light_plan faster = morse;

	gate_set(&gate, 0, &morse);
	faster.program.unit_us = 100000;
	zassert_true(gate_set(&gate, 250000, &faster));
	zassert_equal(gate_deadline_us(&gate), 350000);
}

ZTEST(core_gate, test_late_program_keeps_to_its_times)
{
	gate_set(&gate, 0, &morse);
	/* 1 000 cycles of 6.8 s later and 10 ms late: in the dash that is lit until 2.2 s */
	zassert_true(gate_advance(&gate, INT64_C(6800000000) + 1610000));
	zassert_equal(gate_deadline_us(&gate), INT64_C(6800000000) + 2200000);
}

ZTEST(core_gate, test_strobe_after_a_program_lights_at_once)
{
	gate_set(&gate, 0, &morse);
	zassert_true(gate_set(&gate, 300000, &strobing));
}
