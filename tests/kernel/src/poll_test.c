/* SPDX-License-Identifier: Apache-2.0 */
/* k_poll() and its signals. */
#include "helper.h"

static K_THREAD_STACK_DEFINE(stack_a, HELPER_STACK_SIZE);
static struct k_thread thread_a;

static struct k_poll_signal first, second;
static struct k_poll_event events[2];
static volatile int result_a;

static void begin(void *fixture)
{
	helper_begin();
	k_poll_signal_init(&first);
	k_poll_signal_init(&second);
	events[0] = (struct k_poll_event)K_POLL_EVENT_INITIALIZER(K_POLL_TYPE_SIGNAL,
	                                                          K_POLL_MODE_NOTIFY_ONLY, &first);
	events[1] = (struct k_poll_event)K_POLL_EVENT_INITIALIZER(K_POLL_TYPE_SIGNAL,
	                                                          K_POLL_MODE_NOTIFY_ONLY, &second);
}

static void end_threads(void *fixture)
{
	helper_abort(&thread_a);
}

static void poll_once(void *p1, void *p2, void *p3)
{
	result_a = k_poll(events, ARRAY_SIZE(events), K_FOREVER);
	helper_note('a');
}

static void expect_states(uint32_t first_state, uint32_t second_state)
{
	zassert_equal(events[0].state, first_state);
	zassert_equal(events[1].state, second_state);
}

ZTEST(kernel_poll, test_nothing_ready)
{
	zassert_equal(k_poll(events, ARRAY_SIZE(events), K_NO_WAIT), -EAGAIN);
	zassert_equal(k_poll(events, ARRAY_SIZE(events), K_TICKS(5)), -EAGAIN);
	expect_states(K_POLL_STATE_NOT_READY, K_POLL_STATE_NOT_READY);
}

ZTEST(kernel_poll, test_all_that_are_ready_are_told)
{
	zassert_ok(k_poll_signal_raise(&second, 0));
	zassert_ok(k_poll(events, ARRAY_SIZE(events), K_FOREVER));
	expect_states(K_POLL_STATE_NOT_READY, K_POLL_STATE_SIGNALED);
	zassert_ok(k_poll_signal_raise(&first, 0));
	zassert_ok(k_poll(events, ARRAY_SIZE(events), K_FOREVER), "polling takes nothing");
	expect_states(K_POLL_STATE_SIGNALED, K_POLL_STATE_SIGNALED);
}

ZTEST(kernel_poll, test_signal_wakes)
{
	unsigned int signaled;
	int result;

	k_thread_create(&thread_a, stack_a, K_THREAD_STACK_SIZEOF(stack_a), poll_once, NULL, NULL,
	                NULL, PRIO_HIGH, 0, K_NO_WAIT);
	helper_expect("");
	zassert_ok(k_poll_signal_raise(&second, 0x55));
	helper_expect("a");
	zassert_equal(result_a, 0);
	expect_states(K_POLL_STATE_NOT_READY, K_POLL_STATE_SIGNALED);
	k_poll_signal_check(&second, &signaled, &result);
	zassert_equal(signaled, 1);
	zassert_equal(result, 0x55);
	k_poll_signal_reset(&second);
	k_poll_signal_check(&second, &signaled, &result);
	zassert_equal(signaled, 0);
}

ZTEST_SUITE(kernel_poll, NULL, NULL, begin, end_threads, NULL);
