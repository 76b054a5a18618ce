/* SPDX-License-Identifier: Apache-2.0 */
#include "core/focus.h"

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define S INT64_C(1000000)

static struct focus focus;

static void before(void *fixture)
{
	focus_init(&focus, 4 * S);
}

ZTEST_SUITE(core_focus, NULL, NULL, before, NULL, NULL);

ZTEST(core_focus, test_runs_in_until_it_is_stopped)
{
	zassert_true(focus_command(&focus, 10 * S, FOCUS_ACTION_IN));
	zassert_equal(focus.motor, FOCUS_MOTOR_IN);
	zassert_equal(focus_position_ppm(&focus, 11 * S), 250000);
	zassert_true(focus_command(&focus, 12 * S, FOCUS_ACTION_STOP));
	zassert_equal(focus.motor, FOCUS_MOTOR_STOPPED);
	zassert_equal(focus_position_ppm(&focus, 60 * S), 500000);
	zassert_equal(focus_deadline_us(&focus), TIME_NEVER_US);
}

ZTEST(core_focus, test_runs_into_the_end_and_a_tenth_longer)
{
	zassert_true(focus_command(&focus, 0, FOCUS_ACTION_IN));
	zassert_equal(focus_deadline_us(&focus), 4400000);
	focus_advance(&focus, 4399999);
	zassert_equal(focus.motor, FOCUS_MOTOR_IN);
	zassert_equal(focus_position_ppm(&focus, 4399999), 1000000);
	focus_advance(&focus, 4400000);
	zassert_equal(focus.motor, FOCUS_MOTOR_STOPPED);
	zassert_equal(focus_position_ppm(&focus, 5 * S), 1000000);
	zassert_true(focus_command(&focus, 5 * S, FOCUS_ACTION_IN));
	zassert_equal(focus.motor, FOCUS_MOTOR_STOPPED, "it is there");
}

ZTEST(core_focus, test_moves_to_a_position_from_either_side)
{
	focus_move(&focus, 0, 750000);
	zassert_equal(focus.motor, FOCUS_MOTOR_IN);
	zassert_equal(focus_deadline_us(&focus), 3 * S);
	focus_advance(&focus, 3 * S);
	zassert_equal(focus_position_ppm(&focus, 3 * S), 750000);
	focus_move(&focus, 4 * S, 250000);
	zassert_equal(focus.motor, FOCUS_MOTOR_OUT);
	zassert_equal(focus_deadline_us(&focus), 6 * S);
	zassert_equal(focus_position_ppm(&focus, 5 * S), 500000);
	focus_advance(&focus, 6 * S);
	zassert_equal(focus_position_ppm(&focus, 6 * S), 250000);
}

ZTEST(core_focus, test_turns_round_on_the_way)
{
	zassert_true(focus_command(&focus, 0, FOCUS_ACTION_IN));
	zassert_true(focus_command(&focus, 2 * S, FOCUS_ACTION_OUT));
	zassert_equal(focus.motor, FOCUS_MOTOR_OUT);
	zassert_equal(focus_position_ppm(&focus, 3 * S), 250000);
	zassert_equal(focus_deadline_us(&focus), 4 * S + 400000);
}

/* After a reset of the device nobody knows where the motor stands. */
ZTEST(core_focus, test_reset_runs_the_whole_way_wherever_it_is)
{
	zassert_true(focus_command(&focus, 0, FOCUS_ACTION_RESET));
	zassert_equal(focus.motor, FOCUS_MOTOR_OUT);
	zassert_equal(focus_deadline_us(&focus), 4400000);
	focus_advance(&focus, 4400000);
	zassert_equal(focus_position_ppm(&focus, 5 * S), 0);
	zassert_equal(focus.motor, FOCUS_MOTOR_STOPPED);
}

ZTEST(core_focus, test_unknown_action_is_refused)
{
	zassert_false(focus_command(&focus, 0, 4));
	zassert_equal(focus.motor, FOCUS_MOTOR_STOPPED);
}

ZTEST(core_focus, test_impossible_position_is_a_bug)
{
	expect_assert();
	focus_move(&focus, 0, 1000001);
	zassert_unreachable("no assertion");
}
