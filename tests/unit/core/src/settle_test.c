/* SPDX-License-Identifier: Apache-2.0 */
#include "core/settle.h"

#include <string.h>

#include <zephyr/ztest.h>

#define S  INT64_C(1000000)
#define MS INT64_C(1000)

static struct settle settle;
static int64_t writes[40000];
static size_t count;

static void before(void *fixture)
{
	memset(&settle, 0, sizeof(settle));
	count = 0;
}

ZTEST_SUITE(core_settle, NULL, NULL, before, NULL, NULL);

/* Lets time pass until then; what is due is written. */
static void pass(int64_t until_us)
{
	while (settle_deadline_us(&settle) <= until_us) {
		const int64_t at_us = settle_deadline_us(&settle);

		writes[count++] = at_us;
		settle_write(&settle, at_us);
	}
}

/* A change every gap_us in [from_us, to_us). */
static void change(int64_t from_us, int64_t to_us, int64_t gap_us)
{
	for (int64_t now_us = from_us; now_us < to_us; now_us += gap_us) {
		pass(now_us);
		settle_change(&settle, now_us);
	}
	pass(to_us);
}

ZTEST(core_settle, test_nothing_is_due_before_a_change)
{
	zassert_equal(settle_deadline_us(&settle), TIME_NEVER_US);
}

ZTEST(core_settle, test_a_change_is_due_a_second_after_it)
{
	settle_change(&settle, 5 * S);
	zassert_equal(settle_deadline_us(&settle), 6 * S);
	settle_write(&settle, 6 * S);
	zassert_equal(settle_deadline_us(&settle), TIME_NEVER_US);
	settle_change(&settle, 8 * S);
	zassert_equal(settle_deadline_us(&settle), 9 * S);
}

ZTEST(core_settle, test_each_change_begins_the_second_anew)
{
	change(10 * S, 12 * S, 400 * MS); /* the last at 11.6 s */
	pass(100 * S);
	zassert_equal(count, 1);
	zassert_equal(writes[0], 12600 * MS);
}

ZTEST(core_settle, test_changes_without_an_end_are_due_half_a_minute_after_the_first)
{
	change(0, 100 * S, 400 * MS);
	zassert_equal(count, 3);
	zassert_equal(writes[0], 30 * S);
	/* The first change after it is that at 30 s. */
	zassert_equal(writes[1], 60 * S);
	zassert_equal(writes[2], 90 * S);
}

ZTEST(core_settle, test_written_with_something_else_it_waits_no_more_and_costs_nothing)
{
	for (int i = 0; i < 1000; i++) {
		settle_change(&settle, i);
		settle_drop(&settle);
	}
	zassert_equal(settle_deadline_us(&settle), TIME_NEVER_US);
	settle_change(&settle, S);
	zassert_equal(settle_deadline_us(&settle), 2 * S);
}

/* However fast or slowly it changes, from whatever instant the hour is counted. */
ZTEST(core_settle, test_no_hour_has_more_than_120_writes)
{
	static const int64_t gaps_us[] = {100 * MS,  400 * MS, 999 * MS, 1001 * MS,
	                                  1500 * MS, 5 * S,    29 * S,   31 * S};

	for (size_t i = 0; i < ARRAY_SIZE(gaps_us); i++) {
		size_t first = 0;

		before(NULL);
		change(0, 4 * 3600 * S, gaps_us[i]);
		for (size_t last = 0; last < count; last++) {
			while (writes[last] - writes[first] > 3600 * S) {
				first++;
			}
			zassert_true(last - first + 1 <= 120, "a change every %d ms: %d writes",
			             (int)(gaps_us[i] / MS), (int)(last - first + 1));
		}
		zassert_true(count >= 400, "and they are used: %d in four hours", (int)count);
	}
}

/* The bound of the header: 30 s; where twenty writes stand behind it, 36 s. */
ZTEST(core_settle, test_no_change_waits_longer_than_told)
{
	int64_t first_us = -1;
	int64_t worst_us = 0;

	for (int64_t now_us = 0; now_us < 4 * 3600 * S; now_us += 1100 * MS) {
		const size_t written = count;

		pass(now_us);
		if (count > written && first_us >= 0) {
			worst_us = MAX(worst_us, writes[count - 1] - first_us);
			first_us = -1;
		}
		if (first_us < 0) {
			first_us = now_us;
		}
		settle_change(&settle, now_us);
	}
	zassert_true(worst_us <= 36 * S, "%d ms", (int)(worst_us / MS));
}
