/* SPDX-License-Identifier: Apache-2.0 */
/* A second thread, and a record of the order in which things happened. */
#ifndef KERNEL_TEST_HELPER_H_
#define KERNEL_TEST_HELPER_H_

#include <string.h>

#include <zephyr/irq_offload.h>
#include <zephyr/kernel.h>
#include <zephyr/ztest.h>

#define HELPER_STACK_SIZE 2048

/* More and less urgent than the test's own thread once it called helper_begin(). */
#define PRIO_TEST K_PRIO_PREEMPT(5)
#define PRIO_HIGH K_PRIO_PREEMPT(3)
#define PRIO_LOW  K_PRIO_PREEMPT(7)

/* One letter for each event. */
static char helper_log[32];

/* A test begins with a tick: where time passes while code runs, it has a whole one to prepare. */
static inline void helper_begin(void)
{
	memset(helper_log, 0, sizeof(helper_log));
	k_thread_priority_set(k_current_get(), PRIO_TEST);
	k_sleep(K_TICKS(1));
}

static inline void helper_note(char event)
{
	const size_t length = strlen(helper_log);

	zassert_true(length < sizeof(helper_log) - 1, "too many events");
	helper_log[length] = event;
}

/* Whether or not it was ever created, and has ended since. */
static inline void helper_abort(struct k_thread *thread)
{
	static const struct k_thread never;

	if (memcmp(thread, &never, sizeof(never)) != 0) {
		k_thread_abort(thread);
	}
}

#define helper_expect(expected)                                                                    \
	zassert_equal(strcmp(helper_log, expected), 0, "\"%s\" is not \"%s\"", helper_log, expected)

#endif
