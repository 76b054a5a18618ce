/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A year of commands and schedules for power channels, called at deadlines or late, against an
 * oracle that keeps no timers: it reads the state of an instant out of the log of all commands.
 */
#include "core/power.h"

#include <zephyr/ztest.h>

#include "replay.h"

#define YEAR_US  POWER_SCHEDULE_MAX_US
#define COMMANDS 120
#define CHANNELS 3

struct entry {
	int64_t time_us;
	uint32_t channel;
	enum power_op op;
	int64_t delay_us;
};

static struct entry entries[COMMANDS];
static int count;

ZTEST_SUITE(core_power_sim, NULL, NULL, NULL, NULL, NULL);

/* Does a later command to the channel, before due_us, put an end to what entry `of` scheduled? */
static bool is_replaced(int of, int64_t due_us)
{
	for (int i = of + 1; i < count; i++) {
		if (entries[i].channel == entries[of].channel && entries[i].time_us < due_us &&
		    (entries[i].op == entries[of].op ||
		     entries[i].op == POWER_OP_RESET_SCHEDULES)) {
			return true;
		}
	}
	return false;
}

/* When a schedule of the log switches; TIME_NEVER_US: it is none, or replaced. */
static int64_t due_of(int of)
{
	const struct entry *const entry = &entries[of];
	const int64_t due_us = entry->time_us + entry->delay_us;

	if (entry->op != POWER_OP_SCHEDULE_ON && entry->op != POWER_OP_SCHEDULE_OFF) {
		return TIME_NEVER_US;
	}
	return is_replaced(of, due_us) ? TIME_NEVER_US : due_us;
}

/*
 * The last that switched the channel up to now_us. What falls due at an instant is before the
 * commands of that instant, but a delay of nothing is due after its command.
 */
static bool oracle(uint32_t channel, int64_t now_us, bool at_start)
{
	int64_t off_us = -1; /* when it was restarted last */
	int64_t switched_us = -1;
	bool on = at_start;

	for (;;) {
		int64_t next_us = TIME_NEVER_US;
		bool next = on;
		bool restart = false;

		/* the earliest after switched_us: restarts, schedules on, schedules off, commands
		 */
		if (off_us >= 0 && off_us + POWER_RESTART_US > switched_us) {
			next_us = off_us + POWER_RESTART_US;
			next = true;
		}
		for (int i = 0; i < count; i++) {
			const struct entry *const entry = &entries[i];
			const int64_t due_us = due_of(i);
			const bool commands =
				entry->op == POWER_OP_OFF || entry->op == POWER_OP_ON ||
				entry->op == POWER_OP_TOGGLE || entry->op == POWER_OP_RESTART;
			const int64_t time_us = commands ? entry->time_us : due_us;

			if (entry->channel != channel || time_us == TIME_NEVER_US ||
			    time_us <= switched_us || time_us >= next_us) {
				continue;
			}
			next_us = time_us;
			restart = entry->op == POWER_OP_RESTART;
			next = entry->op == POWER_OP_ON || entry->op == POWER_OP_SCHEDULE_ON ||
			       (entry->op == POWER_OP_TOGGLE && !on);
		}
		if (next_us > now_us) {
			return on;
		}
		on = next;
		switched_us = next_us;
		off_us = restart ? next_us : -1;
	}
}

static void expect(const struct power *power, int64_t now_us, uint32_t at_start)
{
	for (uint32_t channel = 0; channel < CHANNELS; channel++) {
		zassert_equal((power_outputs(power) & (1u << channel)) != 0,
		              oracle(channel, now_us, (at_start & (1u << channel)) != 0),
		              "seed %u: channel %u at %lld us", replay_seed(), channel,
		              (long long)now_us);
	}
}

/* Goes on to until_us: to each deadline, to just before it, or late. */
static void pass(struct power *power, struct dice *dice, int64_t *now_us, int64_t until_us,
                 uint32_t at_start)
{
	while (power_deadline_us(power) <= until_us) {
		const int64_t due_us = power_deadline_us(power);

		if (dice_once_in(dice, 4)) {
			*now_us = dice_between(dice, due_us, until_us);
		} else {
			power_advance(power, due_us - 1);
			expect(power, due_us - 1, at_start);
			*now_us = due_us;
		}
		power_advance(power, *now_us);
		expect(power, *now_us, at_start);
	}
	*now_us = until_us;
}

static void a_year(struct dice *dice)
{
	const uint32_t at_start = dice_next(dice) % (1u << CHANNELS);
	struct power power;
	int64_t now_us = 0;

	count = 0;
	power_init(&power, (1u << CHANNELS) - 1u, at_start);
	while (count < COMMANDS) {
		/* no two at one instant: the oracle's times have no order among themselves */
		const int64_t gap_us =
			dice_once_in(dice, 2) ? 2 * POWER_RESTART_US : 4 * YEAR_US / COMMANDS;
		const int64_t next_us = now_us + dice_between(dice, 1, gap_us);
		struct entry *const entry = &entries[count];

		pass(&power, dice, &now_us, next_us, at_start);
		*entry = (struct entry){
			.time_us = now_us,
			.channel = (uint32_t)dice_between(dice, 0, CHANNELS - 1),
			.op = (enum power_op)(dice_next(dice) % POWER_OPS),
			.delay_us = dice_between(
				dice, 1, dice_once_in(dice, 2) ? YEAR_US : POWER_RESTART_US),
		};
		count++;
		zassert_true(
			power_command(&power, now_us, entry->channel, entry->op, entry->delay_us));
		expect(&power, now_us, at_start);
	}
	pass(&power, dice, &now_us, now_us + YEAR_US, at_start);
	zassert_equal(power_deadline_us(&power), TIME_NEVER_US, "seed %u", replay_seed());
}

ZTEST(core_power_sim, test_a_year_of_schedules_is_exact)
{
	replay_seeds("core_power_sim", a_year);
}
