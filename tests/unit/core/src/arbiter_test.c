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

static bool command(int64_t now_us, enum arbiter_source source)
{
	const bool granted = !arbiter_is_outranked(&arbiter, now_us, source);

	if (granted) {
		arbiter_commit(&arbiter, now_us, source);
	}
	return granted;
}

ZTEST(core_arbiter, test_last_command_wins)
{
	zassert_equal(arbiter.commander, ARBITER_SOURCE_NONE);
	for (enum arbiter_source source = ARBITER_SOURCE_MAVLINK; source <= ARBITER_SOURCE_SHELL;
	     source++) {
		zassert_true(command(source, source));
		zassert_equal(arbiter.commander, source);
		zassert_equal(arbiter.commanded_us, source);
	}
}

ZTEST(core_arbiter, test_check_alone_takes_no_command)
{
	command(1, ARBITER_SOURCE_MAVLINK);
	zassert_false(arbiter_is_outranked(&arbiter, 2, ARBITER_SOURCE_SHELL));
	zassert_equal(arbiter.commander, ARBITER_SOURCE_MAVLINK);
}

ZTEST(core_arbiter, test_priority_outranks_for_the_hold_time)
{
	config.priority = ARBITER_SOURCE_DRONECAN;
	arbiter_configure(&arbiter, &config);
	zassert_true(command(0, ARBITER_SOURCE_MAVLINK), "no one yet");
	zassert_true(command(1000, ARBITER_SOURCE_DRONECAN));
	zassert_false(command(5999, ARBITER_SOURCE_MAVLINK));
	zassert_equal(arbiter.commander, ARBITER_SOURCE_DRONECAN);
	zassert_true(command(6000, ARBITER_SOURCE_MAVLINK));
	zassert_true(command(6001, ARBITER_SOURCE_DRONECAN));
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

ZTEST(core_arbiter, test_sources_have_names)
{
	zassert_equal(strcmp(arbiter_source_name(ARBITER_SOURCE_MAVLINK), "mavlink"), 0);
	zassert_equal(strcmp(arbiter_source_name(ARBITER_SOURCE_FALLBACK), "fallback"), 0);
}

ZTEST(core_arbiter, test_fallback_cannot_ask)
{
	expect_assert();
	arbiter_is_outranked(&arbiter, 0, ARBITER_SOURCE_FALLBACK);
	zassert_unreachable("no assertion");
}
