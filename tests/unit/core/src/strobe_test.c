/* SPDX-License-Identifier: Apache-2.0 */
#include "core/strobe.h"

#include <zephyr/ztest.h>

#include "assert_hook.h"
#include "core/limits.h"

#define YEAR_US (INT64_C(31557600) * 1000000) /* 365.25 days */

static struct strobe strobe;

static void before(void *fixture)
{
	strobe_init(&strobe);
}

ZTEST_SUITE(core_strobe, NULL, NULL, before, NULL, NULL);

static bool set(int64_t now_us, uint32_t period_us, uint32_t on_us)
{
	const struct light_plan plan = {.on = true, .period_us = period_us, .on_us = on_us};

	return strobe_set(&strobe, now_us, &plan);
}

static bool set_dark(int64_t now_us)
{
	return strobe_set(&strobe, now_us, &(struct light_plan){.on = false});
}

ZTEST(core_strobe, test_starts_dark_for_ever)
{
	zassert_false(strobe_advance(&strobe, 0));
	zassert_equal(strobe_deadline_us(&strobe), TIME_NEVER_US);
	zassert_false(strobe_advance(&strobe, YEAR_US));
}

ZTEST(core_strobe, test_steady_light_has_no_edges)
{
	zassert_true(set(5, 0, 0));
	zassert_equal(strobe_deadline_us(&strobe), TIME_NEVER_US);
	zassert_true(strobe_advance(&strobe, YEAR_US));
	zassert_equal(strobe.stats.edges, 1);
}

ZTEST(core_strobe, test_first_flash_begins_with_the_plan)
{
	zassert_true(set(1234567, 100000, 30000));
	zassert_equal(strobe_deadline_us(&strobe), 1264567);
}

ZTEST(core_strobe, test_10000_edges_each_on_its_exact_tick)
{
	const int64_t origin_us = 777;

	zassert_true(set(origin_us, 142857, 14286));
	for (int64_t k = 0; k < 5000; k++) {
		const int64_t dark_us = origin_us + k * 142857 + 14286;
		const int64_t lit_us = origin_us + (k + 1) * 142857;

		zassert_equal(strobe_deadline_us(&strobe), dark_us);
		zassert_true(strobe_advance(&strobe, dark_us - 1));
		zassert_false(strobe_advance(&strobe, dark_us));
		zassert_equal(strobe_deadline_us(&strobe), lit_us);
		zassert_false(strobe_advance(&strobe, lit_us - 1));
		zassert_true(strobe_advance(&strobe, lit_us));
	}
	zassert_equal(strobe.stats.edges, 10001);
	zassert_equal(strobe.stats.missed, 0);
}

/* Cycle k begins at k * 142857 us, however large k is. */
ZTEST(core_strobe, test_no_drift_after_a_thousand_years)
{
	set(0, 142857, 1);
	const int64_t k = 1000 * YEAR_US / 142857;

	strobe_advance(&strobe, k * 142857 - 1);
	zassert_equal(strobe_deadline_us(&strobe), k * 142857);
	zassert_true(strobe_advance(&strobe, k * 142857));
	zassert_false(strobe_advance(&strobe, k * 142857 + 1));
	zassert_equal(strobe_deadline_us(&strobe), (k + 1) * 142857);
}

ZTEST(core_strobe, test_late_call_catches_up_without_a_burst)
{
	set(0, 1000, 300);
	/* Edges 300, 1000, 1300, …, 4300, 5000 are over: ten; then it is lit. */
	zassert_true(strobe_advance(&strobe, 5200));
	zassert_equal(strobe.stats.edges, 1, "it was lit and is lit");
	zassert_equal(strobe.stats.missed, 10);
	zassert_equal(strobe_deadline_us(&strobe), 5300);
	/* 5300, 6000, …, 9000, 9300: nine edges, one of them shows. */
	zassert_false(strobe_advance(&strobe, 9999));
	zassert_equal(strobe.stats.edges, 2);
	zassert_equal(strobe.stats.missed, 18);
	zassert_equal(strobe_deadline_us(&strobe), 10000);
}

ZTEST(core_strobe, test_late_by_one_edge_keeps_the_grid)
{
	set(0, 1000, 300);
	zassert_false(strobe_advance(&strobe, 650));
	zassert_equal(strobe_deadline_us(&strobe), 1000);
	zassert_equal(strobe.stats.missed, 0);
}

ZTEST(core_strobe, test_same_timing_leaves_the_grid)
{
	set(0, 1000, 300);
	zassert_false(set(555, 1000, 300));
	zassert_equal(strobe_deadline_us(&strobe), 1000);
	zassert_true(set(1299, 1000, 300));
	zassert_equal(strobe_deadline_us(&strobe), 1300);
}

ZTEST(core_strobe, test_lit_phase_takes_the_new_length)
{
	set(0, 1000, 300);
	zassert_true(set(100, 2000, 500));
	zassert_equal(strobe_deadline_us(&strobe), 500);
	zassert_false(strobe_advance(&strobe, 500));
	zassert_equal(strobe_deadline_us(&strobe), 2000);
}

ZTEST(core_strobe, test_lit_phase_that_is_longer_than_the_new_one_ends_now)
{
	set(0, 1000, 300);
	zassert_false(set(200, 1000, 50));
	zassert_equal(strobe_deadline_us(&strobe), 1150); /* 950 dark from 200 */
}

ZTEST(core_strobe, test_dark_phase_takes_the_new_length)
{
	set(0, 1000, 300);
	strobe_advance(&strobe, 300);
	zassert_false(set(400, 4000, 2000));
	zassert_equal(strobe_deadline_us(&strobe), 2300);
	zassert_true(strobe_advance(&strobe, 2300));
	zassert_equal(strobe_deadline_us(&strobe), 4300);
}

ZTEST(core_strobe, test_dark_phase_that_is_longer_than_the_new_one_ends_now)
{
	set(0, 1000, 300);
	strobe_advance(&strobe, 300);
	zassert_true(set(800, 1000, 600));
	zassert_equal(strobe_deadline_us(&strobe), 1400);
}

ZTEST(core_strobe, test_off_is_dark_at_once)
{
	set(0, 1000, 300);
	zassert_false(set_dark(1));
	zassert_equal(strobe_deadline_us(&strobe), TIME_NEVER_US);
	zassert_false(strobe_advance(&strobe, YEAR_US));
}

ZTEST(core_strobe, test_on_after_off_waits_for_the_dark_phase_only)
{
	set(0, 1000, 300);
	set_dark(100);
	zassert_false(set(200, 1000, 300));
	zassert_equal(strobe_deadline_us(&strobe), 800); /* dark since 100, 700 long */
	set_dark(300);
	zassert_true(set(900, 1000, 300), "it was dark for 800");
	zassert_equal(strobe_deadline_us(&strobe), 1200);
}

ZTEST(core_strobe, test_on_after_off_is_immediate_when_steady)
{
	set(0, 0, 0);
	set_dark(100);
	zassert_true(set(100, 0, 0));
}

ZTEST(core_strobe, test_steady_to_strobe_and_back)
{
	set(0, 0, 0);
	zassert_true(set(100, 1000, 300));
	zassert_equal(strobe_deadline_us(&strobe), 300, "lit since 0");
	strobe_advance(&strobe, 300);
	zassert_true(set(301, 0, 0), "steady light is lit at once");
	zassert_equal(strobe_deadline_us(&strobe), TIME_NEVER_US);
	zassert_false(set(5000, 1000, 300), "it was lit for longer than 300");
	zassert_equal(strobe_deadline_us(&strobe), 5700);
}

ZTEST(core_strobe, test_many_changes_cannot_hold_a_phase)
{
	set(0, 1000, 300);
	for (int64_t now_us = 1; now_us < 400; now_us++) {
		const bool lit = set(now_us, 1000, 300 + (uint32_t)(now_us % 2));

		zassert_equal(lit, now_us < 300 + now_us % 2);
	}
}

ZTEST(core_strobe, test_change_that_comes_late_catches_up_first)
{
	set(0, 1000, 300);
	/* By the grid the present phase is the dark one since 5300. */
	zassert_false(set(5600, 1000, 500));
	zassert_equal(strobe_deadline_us(&strobe), 5800);
}

ZTEST(core_strobe, test_a_step_back_in_time_is_a_bug)
{
	set(1000, 1000, 300);
	expect_assert();
	strobe_advance(&strobe, 999);
	zassert_unreachable("no assertion");
}

ZTEST(core_strobe, test_strobe_without_dark_phase_is_a_bug)
{
	expect_assert();
	set(0, 1000, 1000);
	zassert_unreachable("no assertion");
}
