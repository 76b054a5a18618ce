/* SPDX-License-Identifier: Apache-2.0 */
#include "core/sync.h"

#include <zephyr/ztest.h>

#include "assert_hook.h"
#include "core/limits.h"

static struct sync sync_input_line;
#define SYNC (&sync_input_line)

static struct sync_config config;

static void before(void *fixture)
{
	config = (struct sync_config){.filter_us = 100, .pulse_us = 1000};
}

ZTEST_SUITE(core_sync, NULL, NULL, before, NULL, NULL);

static void start(bool level)
{
	sync_init(SYNC, 0, &config, level);
}

static enum sync_output at(int64_t now_us)
{
	return sync_advance(SYNC, now_us);
}

ZTEST(core_sync, test_level_follows_the_input_after_the_filter)
{
	start(false);
	zassert_equal(at(10), SYNC_OUTPUT_DARK);
	sync_input(SYNC, 1000, true);
	zassert_equal(sync_deadline_us(SYNC), 1100);
	zassert_equal(at(1099), SYNC_OUTPUT_DARK);
	zassert_equal(at(1100), SYNC_OUTPUT_LIT);
	zassert_equal(sync_deadline_us(SYNC), TIME_NEVER_US);
	sync_input(SYNC, 2000, false);
	zassert_equal(at(2099), SYNC_OUTPUT_LIT);
	zassert_equal(at(2100), SYNC_OUTPUT_DARK);
	zassert_equal(SYNC->stats.changes, 2);
}

ZTEST(core_sync, test_input_that_is_active_at_start_is_lit)
{
	start(true);
	zassert_equal(at(0), SYNC_OUTPUT_LIT);
}

ZTEST(core_sync, test_active_low_turns_the_input_round)
{
	config.polarity = SYNC_ACTIVE_LOW;
	start(true);
	zassert_equal(at(0), SYNC_OUTPUT_DARK);
	sync_input(SYNC, 10, false);
	zassert_equal(at(110), SYNC_OUTPUT_LIT);
}

ZTEST(core_sync, test_change_shorter_than_the_filter_never_happened)
{
	start(false);
	sync_input(SYNC, 1000, true);
	sync_input(SYNC, 1099, false);
	zassert_equal(sync_deadline_us(SYNC), TIME_NEVER_US);
	zassert_equal(at(5000), SYNC_OUTPUT_DARK);
	zassert_equal(SYNC->stats.glitches, 1);
	zassert_equal(SYNC->stats.changes, 0);
}

ZTEST(core_sync, test_change_as_long_as_the_filter_counts)
{
	start(false);
	sync_input(SYNC, 1000, true);
	sync_input(SYNC, 1100, false);
	zassert_equal(at(1100), SYNC_OUTPUT_LIT);
	zassert_equal(at(1199), SYNC_OUTPUT_LIT);
	zassert_equal(at(1200), SYNC_OUTPUT_DARK);
}

ZTEST(core_sync, test_bounce_counts_from_its_end)
{
	start(false);
	for (int64_t t = 0; t < 500; t += 50) {
		sync_input(SYNC, t, t % 100 == 0);
	}
	sync_input(SYNC, 500, true);
	zassert_equal(at(599), SYNC_OUTPUT_DARK);
	zassert_equal(at(600), SYNC_OUTPUT_LIT);
	zassert_equal(SYNC->stats.glitches, 5);
}

ZTEST(core_sync, test_repeated_level_does_not_restart_the_filter)
{
	start(false);
	sync_input(SYNC, 1000, true);
	sync_input(SYNC, 1050, true);
	zassert_equal(at(1100), SYNC_OUTPUT_LIT);
}

ZTEST(core_sync, test_without_filter_the_change_is_immediate)
{
	config.filter_us = 0;
	start(false);
	sync_input(SYNC, 1000, true);
	zassert_equal(at(1000), SYNC_OUTPUT_LIT);
}

ZTEST(core_sync, test_edge_gives_one_pulse_of_the_given_length)
{
	config.mode = SYNC_MODE_EDGE;
	start(false);
	sync_input(SYNC, 1000, true);
	zassert_equal(at(1100), SYNC_OUTPUT_LIT);
	zassert_equal(sync_deadline_us(SYNC), 2100);
	zassert_equal(at(2099), SYNC_OUTPUT_LIT);
	zassert_equal(at(2100), SYNC_OUTPUT_DARK);
	sync_input(SYNC, 3000, false);
	zassert_equal(at(3500), SYNC_OUTPUT_DARK, "only edges to active");
	zassert_equal(SYNC->stats.pulses, 1);
}

ZTEST(core_sync, test_edge_mode_needs_an_edge)
{
	config.mode = SYNC_MODE_EDGE;
	start(true);
	zassert_equal(at(0), SYNC_OUTPUT_DARK);
}

/* Edges accepted at 1100 and 1500, during the first one's pulse until 2100. */
static void two_edges(void)
{
	config.mode = SYNC_MODE_EDGE;
	start(false);
	sync_input(SYNC, 1000, true);
	sync_input(SYNC, 1200, false);
	sync_input(SYNC, 1400, true);
}

ZTEST(core_sync, test_edge_during_a_pulse_is_ignored)
{
	two_edges();
	zassert_equal(at(2099), SYNC_OUTPUT_LIT);
	zassert_equal(at(2100), SYNC_OUTPUT_DARK);
	zassert_equal(SYNC->stats.ignored, 1);
}

ZTEST(core_sync, test_edge_during_a_pulse_prolongs_it)
{
	config.retrigger = SYNC_RETRIGGER_EXTEND;
	two_edges();
	zassert_equal(at(2499), SYNC_OUTPUT_LIT);
	zassert_equal(at(2500), SYNC_OUTPUT_DARK);
	zassert_equal(SYNC->stats.pulses, 2);
}

ZTEST(core_sync, test_silence_brings_the_policy_and_activity_ends_it)
{
	static const enum sync_output expected[] = {SYNC_OUTPUT_DARK, SYNC_OUTPUT_LIT,
	                                            SYNC_OUTPUT_INTERNAL};

	config.timeout_us = 50000;
	for (enum sync_policy policy = SYNC_POLICY_OFF; policy <= SYNC_POLICY_INTERNAL; policy++) {
		config.policy = policy;
		start(true);
		zassert_equal(sync_deadline_us(SYNC), 50000);
		zassert_equal(at(49999), SYNC_OUTPUT_LIT);
		zassert_equal(at(50000), expected[policy]);
		zassert_equal(sync_deadline_us(SYNC), TIME_NEVER_US);
		sync_input(SYNC, 60000, false);
		zassert_equal(at(60099), expected[policy], "not before the filter");
		zassert_equal(at(60100), SYNC_OUTPUT_DARK);
		zassert_equal(sync_deadline_us(SYNC), 110100);
		zassert_equal(SYNC->stats.timeouts, 1);
	}
}

ZTEST(core_sync, test_glitches_are_no_activity)
{
	config.timeout_us = 1000;
	config.policy = SYNC_POLICY_ON;
	start(false);
	for (int64_t t = 100; t < 1000; t += 100) {
		sync_input(SYNC, t, true);
		sync_input(SYNC, t + 50, false);
	}
	zassert_equal(at(1000), SYNC_OUTPUT_LIT);
}

ZTEST(core_sync, test_late_call_passes_time_out_change_and_time_out)
{
	config.timeout_us = 1000;
	config.policy = SYNC_POLICY_INTERNAL;
	start(false);
	sync_input(SYNC, 1500, true);
	zassert_equal(at(9000), SYNC_OUTPUT_INTERNAL);
	zassert_equal(SYNC->stats.timeouts, 2);
	zassert_equal(SYNC->stats.changes, 1);
}

ZTEST(core_sync, test_time_out_shorter_than_the_filter_comes_before_and_after_the_change)
{
	config.timeout_us = 50;
	config.policy = SYNC_POLICY_INTERNAL;
	start(false);
	sync_input(SYNC, 10, true);
	zassert_equal(at(9000), SYNC_OUTPUT_INTERNAL); /* 50, change at 110, 160 */
	zassert_equal(SYNC->stats.timeouts, 2);
	zassert_equal(SYNC->stats.changes, 1);
}

ZTEST(core_sync, test_old_timestamp_counts_as_now)
{
	start(false);
	at(5000);
	sync_input(SYNC, 4000, true);
	zassert_equal(SYNC->stats.late, 1);
	zassert_equal(sync_deadline_us(SYNC), 5100);
}

ZTEST(core_sync, test_new_config_starts_anew_and_keeps_counting)
{
	start(false);
	sync_input(SYNC, 100, true);
	zassert_equal(at(300), SYNC_OUTPUT_LIT);
	config.polarity = SYNC_ACTIVE_LOW;
	sync_configure(SYNC, 400, &config, true);
	zassert_equal(at(400), SYNC_OUTPUT_DARK);
	zassert_equal(SYNC->stats.changes, 1);
}

ZTEST(core_sync, test_pulse_without_length_is_a_bug)
{
	config.pulse_us = 0;
	expect_assert();
	start(false);
	zassert_unreachable("no assertion");
}
