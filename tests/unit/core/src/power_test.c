/* SPDX-License-Identifier: Apache-2.0 */
#include "core/power.h"

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define S    INT64_C(1000000)
#define YEAR (INT64_C(31536000) * S)

static struct power power;

static void before(void *fixture)
{
	power_init(&power, 0x0F, 0x03);
}

ZTEST_SUITE(core_power, NULL, NULL, before, NULL, NULL);

static bool command(int64_t now_us, uint32_t channel, uint32_t op)
{
	return power_command(&power, now_us, channel, op, 0);
}

/* The lines' controller failed at this start; at the next one it may not. */
ZTEST(core_power, test_channels_that_are_not_there_today_stay_saved)
{
	power_init(&power, 0x00, 0x0B);
	zassert_equal(power.on, 0x00);
	zassert_equal(power.saved, 0x0B);
	power_init(&power, 0x01, 0x0B);
	zassert_true(power_command(&power, 0, 0, POWER_OP_OFF, 0));
	zassert_true(power_command(&power, 0, 0, POWER_OP_SAVE, 0));
	zassert_equal(power.saved, 0x0A);
}

ZTEST(core_power, test_starts_with_what_was_given)
{
	zassert_equal(power_outputs(&power), 0x03);
	zassert_equal(power_deadline_us(&power), TIME_NEVER_US);
}

ZTEST(core_power, test_off_on_toggle)
{
	zassert_true(command(1, 0, POWER_OP_OFF));
	zassert_equal(power_outputs(&power), 0x02);
	zassert_true(command(2, 3, POWER_OP_ON));
	zassert_equal(power_outputs(&power), 0x0A);
	zassert_true(command(3, 3, POWER_OP_TOGGLE));
	zassert_true(command(4, 0, POWER_OP_TOGGLE));
	zassert_equal(power_outputs(&power), 0x03);
}

ZTEST(core_power, test_what_is_not_there_is_refused)
{
	zassert_false(command(1, 4, POWER_OP_ON));
	zassert_false(command(1, 8, POWER_OP_ON));
	zassert_false(command(1, UINT32_MAX, POWER_OP_ON));
	zassert_false(command(1, 0, 8));
	zassert_equal(power_outputs(&power), 0x03);
}

/* IMC has seconds from now; who sends Unix time means another thing. */
ZTEST(core_power, test_delays_from_nothing_to_a_year)
{
	zassert_false(power_command(&power, 1, 2, POWER_OP_SCHEDULE_ON, -1));
	zassert_false(power_command(&power, 1, 2, POWER_OP_SCHEDULE_ON, YEAR + 1));
	zassert_equal(power_deadline_us(&power), TIME_NEVER_US);
	zassert_true(power_command(&power, 1, 2, POWER_OP_SCHEDULE_ON, 0));
	zassert_equal(power_outputs(&power), 0x07, "at once");
	zassert_true(power_command(&power, 1, 2, POWER_OP_SCHEDULE_OFF, YEAR));
	zassert_equal(power_deadline_us(&power), 1 + YEAR);
	zassert_true(power_command(&power, 1, 2, POWER_OP_ON, -1), "an on has no delay");
}

ZTEST(core_power, test_schedules_are_exact_after_a_year)
{
	zassert_true(power_command(&power, 7, 2, POWER_OP_SCHEDULE_ON, YEAR - 1));
	zassert_true(power_command(&power, 7, 2, POWER_OP_SCHEDULE_OFF, YEAR));
	/* a year of seconds in between moves nothing */
	for (int64_t day = 1; day < 365; day++) {
		power_advance(&power, 7 + day * 86400 * S);
	}
	zassert_equal(power_deadline_us(&power), 7 + YEAR - 1);
	power_advance(&power, 7 + YEAR - 2);
	zassert_equal(power_outputs(&power), 0x03);
	power_advance(&power, 7 + YEAR - 1);
	zassert_equal(power_outputs(&power), 0x07);
	zassert_equal(power_deadline_us(&power), 7 + YEAR);
	power_advance(&power, 7 + YEAR);
	zassert_equal(power_outputs(&power), 0x03);
	zassert_equal(power_deadline_us(&power), TIME_NEVER_US);
}

ZTEST(core_power, test_the_two_schedules_are_independent)
{
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_ON, 10 * S));
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_OFF, 5 * S));
	zassert_true(command(1 * S, 2, POWER_OP_ON));
	power_advance(&power, 5 * S);
	zassert_equal(power_outputs(&power), 0x03);
	power_advance(&power, 10 * S);
	zassert_equal(power_outputs(&power), 0x07);
}

ZTEST(core_power, test_a_late_call_does_them_in_their_order)
{
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_ON, 10 * S));
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_OFF, 5 * S));
	zassert_true(power_command(&power, 0, 1, POWER_OP_SCHEDULE_ON, 5 * S));
	zassert_true(power_command(&power, 0, 1, POWER_OP_SCHEDULE_OFF, 10 * S));
	power_advance(&power, 60 * S);
	zassert_equal(power_outputs(&power), 0x05);
}

ZTEST(core_power, test_both_at_the_same_instant_end_off)
{
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_OFF, 5 * S));
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_ON, 5 * S));
	power_advance(&power, 5 * S);
	zassert_equal(power_outputs(&power), 0x03);
}

ZTEST(core_power, test_a_new_schedule_replaces_the_old_one)
{
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_ON, 5 * S));
	zassert_true(power_command(&power, 1 * S, 2, POWER_OP_SCHEDULE_ON, 10 * S));
	power_advance(&power, 10 * S);
	zassert_equal(power_outputs(&power), 0x03);
	power_advance(&power, 11 * S);
	zassert_equal(power_outputs(&power), 0x07);
}

ZTEST(core_power, test_reset_clears_both)
{
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_ON, 5 * S));
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_OFF, 6 * S));
	zassert_true(power_command(&power, 0, 1, POWER_OP_SCHEDULE_OFF, 7 * S));
	zassert_true(command(1 * S, 2, POWER_OP_RESET_SCHEDULES));
	zassert_equal(power_deadline_us(&power), 7 * S, "the other channel's stays");
}

ZTEST(core_power, test_restart_is_off_then_on)
{
	zassert_true(command(1 * S, 0, POWER_OP_RESTART));
	zassert_equal(power_outputs(&power), 0x02);
	zassert_equal(power_deadline_us(&power), 3 * S);
	power_advance(&power, 3 * S);
	zassert_equal(power_outputs(&power), 0x03);
	zassert_equal(power_deadline_us(&power), TIME_NEVER_US);
}

ZTEST(core_power, test_a_command_ends_a_restart)
{
	zassert_true(command(1 * S, 0, POWER_OP_RESTART));
	zassert_true(command(2 * S, 0, POWER_OP_OFF));
	power_advance(&power, 60 * S);
	zassert_equal(power_outputs(&power), 0x02);
}

ZTEST(core_power, test_save_keeps_what_is_on_now)
{
	zassert_equal(power.saved, 0x03);
	zassert_true(command(1, 3, POWER_OP_ON));
	zassert_true(command(1, 0, POWER_OP_OFF));
	zassert_equal(power.saved, 0x03);
	zassert_true(command(1, 3, POWER_OP_SAVE));
	zassert_equal(power.saved, 0x0B);
	zassert_true(command(1, 0, POWER_OP_SAVE));
	zassert_equal(power.saved, 0x0A);
}

ZTEST(core_power, test_save_amid_a_restart_keeps_it_on)
{
	zassert_true(command(1, 0, POWER_OP_RESTART));
	zassert_true(command(1, 0, POWER_OP_SAVE));
	zassert_equal(power.saved, 0x03);
}

ZTEST(core_power, test_down_nothing_has_power_and_schedules_go_on)
{
	power.down = true;
	zassert_equal(power_outputs(&power), 0);
	zassert_true(power_command(&power, 0, 2, POWER_OP_SCHEDULE_ON, 5 * S));
	power_advance(&power, 5 * S);
	zassert_equal(power_outputs(&power), 0);
	power.down = false;
	zassert_equal(power_outputs(&power), 0x07);
}

ZTEST(core_power, test_only_channels_that_are_there_come_on)
{
	power_init(&power, 0x05, 0xFF);
	zassert_equal(power_outputs(&power), 0x05);
}

ZTEST(core_power, test_more_channels_than_fit_are_a_bug)
{
	expect_assert();
	power_init(&power, 0x100, 0);
	zassert_unreachable("no assertion");
}
