/* SPDX-License-Identifier: Apache-2.0 */
#include "core/arbiter.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "assert_hook.h"

static struct arbiter arbiter;
static struct arbiter_config config;

static void before(void *fixture)
{
	config = (struct arbiter_config){.hold_us = 5000};
	arbiter_init(&arbiter, &config);
}

ZTEST_SUITE(core_arbiter, NULL, NULL, before, NULL, NULL);

static enum arbiter_verdict command(int64_t now_us, enum arbiter_source source)
{
	const enum arbiter_verdict verdict = arbiter_check(&arbiter, now_us, source);

	if (verdict == ARBITER_GRANTED) {
		arbiter_commit(&arbiter, now_us, source);
	}
	return verdict;
}

ZTEST(core_arbiter, test_last_command_wins)
{
	zassert_equal(arbiter.commander, ARBITER_SOURCE_NONE);
	for (enum arbiter_source source = ARBITER_SOURCE_MAVLINK; source <= ARBITER_SOURCE_SHELL;
	     source++) {
		zassert_equal(command(source, source), ARBITER_GRANTED);
		zassert_equal(arbiter.commander, source);
		zassert_equal(arbiter.commanded_us, source);
	}
}

ZTEST(core_arbiter, test_check_alone_takes_no_command)
{
	command(1, ARBITER_SOURCE_MAVLINK);
	arbiter_check(&arbiter, 2, ARBITER_SOURCE_SHELL);
	zassert_equal(arbiter.commander, ARBITER_SOURCE_MAVLINK);
}

ZTEST(core_arbiter, test_excluded_source_is_refused)
{
	config.excluded = 2; /* LGT_SRC_EXCL: 2 is DroneCAN */
	arbiter_configure(&arbiter, &config);
	zassert_equal(command(1, ARBITER_SOURCE_DRONECAN), ARBITER_EXCLUDED);
	zassert_equal(command(1, ARBITER_SOURCE_MAVLINK), ARBITER_GRANTED);
	zassert_equal(command(1, ARBITER_SOURCE_IMC), ARBITER_GRANTED);
	zassert_equal(command(1, ARBITER_SOURCE_SHELL), ARBITER_GRANTED);
	zassert_equal(arbiter.stats.refused[ARBITER_SOURCE_DRONECAN], 1);
}

ZTEST(core_arbiter, test_priority_outranks_for_the_hold_time)
{
	config.priority = ARBITER_SOURCE_DRONECAN;
	arbiter_configure(&arbiter, &config);
	zassert_equal(command(0, ARBITER_SOURCE_MAVLINK), ARBITER_GRANTED, "no one yet");
	zassert_equal(command(1000, ARBITER_SOURCE_DRONECAN), ARBITER_GRANTED);
	zassert_equal(command(5999, ARBITER_SOURCE_MAVLINK), ARBITER_OUTRANKED);
	zassert_equal(arbiter.commander, ARBITER_SOURCE_DRONECAN);
	zassert_equal(command(6000, ARBITER_SOURCE_MAVLINK), ARBITER_GRANTED);
	zassert_equal(command(6001, ARBITER_SOURCE_DRONECAN), ARBITER_GRANTED);
	zassert_equal(arbiter.stats.refused[ARBITER_SOURCE_MAVLINK], 1);
}

ZTEST(core_arbiter, test_priority_of_an_excluded_source_holds_no_one_off)
{
	config.priority = ARBITER_SOURCE_IMC;
	arbiter_configure(&arbiter, &config);
	command(0, ARBITER_SOURCE_IMC);
	config.excluded = ARBITER_SOURCE_BIT(ARBITER_SOURCE_IMC);
	arbiter_configure(&arbiter, &config);
	zassert_equal(command(1, ARBITER_SOURCE_SHELL), ARBITER_GRANTED);
}

ZTEST(core_arbiter, test_silence_is_told_once)
{
	config.loss_us = 1000;
	config.fallback = ILLUMINATOR_FALLBACK_OFF;
	arbiter_configure(&arbiter, &config);
	zassert_equal(arbiter_deadline_us(&arbiter), TIME_NEVER_US, "no one was there yet");
	zassert_false(arbiter_advance(&arbiter, 1000000));
	command(2000000, ARBITER_SOURCE_MAVLINK);
	arbiter_heard(&arbiter, 2000500, ARBITER_SOURCE_MAVLINK);
	zassert_equal(arbiter_deadline_us(&arbiter), 2001500);
	zassert_false(arbiter_advance(&arbiter, 2001499));
	zassert_true(arbiter_advance(&arbiter, 2001500));
	zassert_equal(arbiter.commander, ARBITER_SOURCE_FALLBACK);
	zassert_false(arbiter_advance(&arbiter, 2001501));
	zassert_equal(arbiter_deadline_us(&arbiter), TIME_NEVER_US);
	arbiter_heard(&arbiter, 3000000, ARBITER_SOURCE_SHELL);
	zassert_true(arbiter_advance(&arbiter, 3001000), "a new loss");
	zassert_equal(arbiter.stats.losses, 2);
}

ZTEST(core_arbiter, test_fallback_keep_leaves_the_commander)
{
	config.loss_us = 1000;
	config.fallback = ILLUMINATOR_FALLBACK_KEEP;
	arbiter_configure(&arbiter, &config);
	command(0, ARBITER_SOURCE_IMC);
	zassert_true(arbiter_advance(&arbiter, 1000));
	zassert_equal(arbiter.commander, ARBITER_SOURCE_IMC);
}

ZTEST(core_arbiter, test_excluded_source_is_no_sign_of_life)
{
	config.loss_us = 1000;
	config.excluded = ARBITER_SOURCE_BIT(ARBITER_SOURCE_IMC);
	arbiter_configure(&arbiter, &config);
	command(0, ARBITER_SOURCE_MAVLINK);
	arbiter_heard(&arbiter, 900, ARBITER_SOURCE_IMC);
	zassert_equal(arbiter_deadline_us(&arbiter), 1000);
}

ZTEST(core_arbiter, test_sources_have_names)
{
	zassert_equal(strcmp(arbiter_source_name(ARBITER_SOURCE_MAVLINK), "mavlink"), 0);
	zassert_equal(strcmp(arbiter_source_name(ARBITER_SOURCE_FALLBACK), "fallback"), 0);
}

ZTEST(core_arbiter, test_fallback_cannot_ask)
{
	expect_assert();
	arbiter_check(&arbiter, 0, ARBITER_SOURCE_FALLBACK);
	zassert_unreachable("no assertion");
}
