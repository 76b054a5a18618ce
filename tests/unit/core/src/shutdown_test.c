/* SPDX-License-Identifier: Apache-2.0 */
#include "core/shutdown.h"

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define S    INT64_C(1000000)
#define YEAR (INT64_C(31536000) * S)

static struct shutdown shut;
static struct shutdown_notice told;

static void before(void *fixture)
{
	shutdown_init(&shut, 3 * S);
}

ZTEST_SUITE(core_shutdown, NULL, NULL, before, NULL, NULL);

static bool command(int64_t now_us, uint32_t op, int64_t time_us)
{
	return shutdown_command(&shut, now_us, op, time_us);
}

static void expect(int64_t now_us, enum shutdown_op op, int64_t remain_us)
{
	zassert_true(shutdown_advance(&shut, now_us, &told), "nothing told at %lld",
	             (long long)now_us);
	zassert_equal(told.op, op);
	zassert_equal(told.remain_us, remain_us);
}

static void expect_nothing(int64_t now_us)
{
	zassert_false(shutdown_advance(&shut, now_us, &told), "something told at %lld",
	              (long long)now_us);
}

ZTEST(core_shutdown, test_going_down_is_told_each_second)
{
	expect_nothing(9 * S);
	zassert_true(command(10 * S, SHUTDOWN_OP_DOWN, 0));
	expect(10 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 3 * S);
	expect_nothing(10 * S);
	zassert_equal(shut.state, SHUTDOWN_STATE_GOING_DOWN);
	zassert_equal(shutdown_deadline_us(&shut), 11 * S);
	expect(11 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 2 * S);
	expect(12 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 1 * S);
	zassert_equal(shut.state, SHUTDOWN_STATE_GOING_DOWN);
	expect(13 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 0);
	zassert_equal(shut.state, SHUTDOWN_STATE_DOWN);
	expect_nothing(14 * S);
	zassert_equal(shutdown_deadline_us(&shut), TIME_NEVER_US);
}

ZTEST(core_shutdown, test_the_sender_may_say_how_long)
{
	zassert_true(command(0, SHUTDOWN_OP_DOWN, 1500000));
	expect(0, SHUTDOWN_OP_DOWN_IN_PROGRESS, 1500000);
	zassert_equal(shutdown_deadline_us(&shut), 500000);
	expect(500000, SHUTDOWN_OP_DOWN_IN_PROGRESS, 1 * S);
	expect(1500000, SHUTDOWN_OP_DOWN_IN_PROGRESS, 0);
}

/* Who repeats the command each second shall not put the end off for ever. */
ZTEST(core_shutdown, test_a_repeated_command_does_not_begin_anew)
{
	zassert_true(command(0, SHUTDOWN_OP_DOWN, 0));
	expect(0, SHUTDOWN_OP_DOWN_IN_PROGRESS, 3 * S);
	zassert_true(command(1 * S, SHUTDOWN_OP_DOWN, 3 * S));
	expect(1 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 2 * S);
}

ZTEST(core_shutdown, test_abort)
{
	zassert_true(command(0, SHUTDOWN_OP_DOWN, 0));
	expect(0, SHUTDOWN_OP_DOWN_IN_PROGRESS, 3 * S);
	zassert_true(command(1, SHUTDOWN_OP_DOWN_ABORTED, 0));
	expect(1, SHUTDOWN_OP_DOWN_ABORTED, 0);
	expect_nothing(60 * S);
	zassert_equal(shut.state, SHUTDOWN_STATE_UP);
}

ZTEST(core_shutdown, test_up_ends_a_power_down_and_brings_it_back)
{
	zassert_true(command(0, SHUTDOWN_OP_UP, 0));
	expect_nothing(0);
	zassert_true(command(0, SHUTDOWN_OP_DOWN, 0));
	expect(0, SHUTDOWN_OP_DOWN_IN_PROGRESS, 3 * S);
	zassert_true(command(1, SHUTDOWN_OP_UP, 0));
	expect(1, SHUTDOWN_OP_DOWN_ABORTED, 0);
	zassert_true(command(10 * S, SHUTDOWN_OP_DOWN, 0));
	expect(10 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 3 * S);
	expect(13 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 0);
	zassert_true(command(20 * S, SHUTDOWN_OP_DOWN_ABORTED, 0));
	expect_nothing(20 * S);
	zassert_equal(shut.state, SHUTDOWN_STATE_DOWN, "too late");
	zassert_true(command(21 * S, SHUTDOWN_OP_UP, 0));
	expect(21 * S, SHUTDOWN_OP_UP_IN_PROGRESS, 0);
	zassert_equal(shut.state, SHUTDOWN_STATE_UP);
}

ZTEST(core_shutdown, test_scheduled_down_and_up_are_exact_over_a_year)
{
	zassert_true(command(5, SHUTDOWN_OP_SCHEDULE_DOWN, YEAR - 10 * S));
	zassert_true(command(5, SHUTDOWN_OP_SCHEDULE_UP, YEAR));
	zassert_equal(shutdown_deadline_us(&shut), 5 + YEAR - 10 * S);
	expect_nothing(5 + YEAR - 10 * S - 1);
	expect(5 + YEAR - 10 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 3 * S);
	expect(5 + YEAR - 7 * S, SHUTDOWN_OP_DOWN_IN_PROGRESS, 0);
	zassert_equal(shutdown_deadline_us(&shut), 5 + YEAR);
	expect_nothing(5 + YEAR - 1);
	expect(5 + YEAR, SHUTDOWN_OP_UP_IN_PROGRESS, 0);
	zassert_equal(shutdown_deadline_us(&shut), TIME_NEVER_US);
}

ZTEST(core_shutdown, test_abort_clears_a_scheduled_down_and_leaves_a_scheduled_up)
{
	zassert_true(command(0, SHUTDOWN_OP_SCHEDULE_DOWN, 5 * S));
	zassert_true(command(0, SHUTDOWN_OP_SCHEDULE_UP, 9 * S));
	zassert_true(command(1, SHUTDOWN_OP_DOWN_ABORTED, 0));
	expect_nothing(1);
	zassert_equal(shutdown_deadline_us(&shut), 9 * S);
	expect_nothing(9 * S);
}

ZTEST(core_shutdown, test_what_others_tell_is_no_command)
{
	zassert_true(command(0, SHUTDOWN_OP_DOWN_IN_PROGRESS, 0));
	zassert_true(command(0, SHUTDOWN_OP_UP_IN_PROGRESS, 0));
	expect_nothing(60 * S);
}

ZTEST(core_shutdown, test_out_of_range_is_refused)
{
	zassert_false(command(0, 7, 0));
	zassert_false(command(0, SHUTDOWN_OP_DOWN, -1));
	zassert_false(command(0, SHUTDOWN_OP_DOWN, 3600 * S + 1));
	zassert_false(command(0, SHUTDOWN_OP_SCHEDULE_DOWN, -1));
	zassert_false(command(0, SHUTDOWN_OP_SCHEDULE_UP, YEAR + 1));
	zassert_equal(shutdown_deadline_us(&shut), TIME_NEVER_US);
	zassert_true(command(0, SHUTDOWN_OP_DOWN, 3600 * S));
}

ZTEST(core_shutdown, test_impossible_grace_is_a_bug)
{
	expect_assert();
	shutdown_init(&shut, -1);
	zassert_unreachable("no assertion");
}
