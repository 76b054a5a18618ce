/* SPDX-License-Identifier: Apache-2.0 */
/* k_poll() and its signals. */
#include "helper.h"

static K_THREAD_STACK_DEFINE(stack_a, HELPER_STACK_SIZE);
static struct k_thread thread_a;

static struct k_sem sem;
static struct k_fifo fifo;
static struct k_msgq msgq;
static char msgq_buffer[4];
static struct k_poll_signal signal_object;
static struct k_poll_event events[4];
static volatile int result_a;

static void begin(void *fixture)
{
	helper_begin();
	k_sem_init(&sem, 0, 1);
	k_fifo_init(&fifo);
	k_msgq_init(&msgq, msgq_buffer, 1, sizeof(msgq_buffer));
	k_poll_signal_init(&signal_object);
	k_poll_event_init(&events[0], K_POLL_TYPE_SEM_AVAILABLE, K_POLL_MODE_NOTIFY_ONLY, &sem);
	k_poll_event_init(&events[1], K_POLL_TYPE_FIFO_DATA_AVAILABLE, K_POLL_MODE_NOTIFY_ONLY,
	                  &fifo);
	k_poll_event_init(&events[2], K_POLL_TYPE_MSGQ_DATA_AVAILABLE, K_POLL_MODE_NOTIFY_ONLY,
	                  &msgq);
	k_poll_event_init(&events[3], K_POLL_TYPE_SIGNAL, K_POLL_MODE_NOTIFY_ONLY, &signal_object);
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

static void start_poller(void)
{
	k_thread_create(&thread_a, stack_a, K_THREAD_STACK_SIZEOF(stack_a), poll_once, NULL, NULL,
	                NULL, PRIO_HIGH, 0, K_NO_WAIT);
	helper_expect("");
}

static void expect_states(uint32_t sem_state, uint32_t fifo_state, uint32_t msgq_state,
                          uint32_t signal_state)
{
	zassert_equal(events[0].state, sem_state);
	zassert_equal(events[1].state, fifo_state);
	zassert_equal(events[2].state, msgq_state);
	zassert_equal(events[3].state, signal_state);
}

ZTEST(kernel_poll, test_nothing_ready)
{
	zassert_equal(k_poll(events, ARRAY_SIZE(events), K_NO_WAIT), -EAGAIN);
	zassert_equal(k_poll(events, ARRAY_SIZE(events), K_TICKS(5)), -EAGAIN);
	expect_states(0, 0, 0, 0);
}

ZTEST(kernel_poll, test_all_that_are_ready_are_told)
{
	char byte = 1;

	k_sem_give(&sem);
	k_msgq_put(&msgq, &byte, K_NO_WAIT);
	zassert_ok(k_poll(events, ARRAY_SIZE(events), K_FOREVER));
	expect_states(K_POLL_STATE_SEM_AVAILABLE, 0, K_POLL_STATE_MSGQ_DATA_AVAILABLE, 0);
	zassert_equal(k_sem_count_get(&sem), 1, "polling takes nothing");
}

ZTEST(kernel_poll, test_semaphore_wakes)
{
	start_poller();
	k_sem_give(&sem);
	helper_expect("a");
	zassert_equal(result_a, 0);
	expect_states(K_POLL_STATE_SEM_AVAILABLE, 0, 0, 0);
}

ZTEST(kernel_poll, test_message_wakes)
{
	char byte = 1;

	start_poller();
	k_msgq_put(&msgq, &byte, K_NO_WAIT);
	k_yield(); /* Zephyr 3.4 does not reschedule here by itself */
	helper_expect("a");
	expect_states(0, 0, K_POLL_STATE_MSGQ_DATA_AVAILABLE, 0);
}

ZTEST(kernel_poll, test_fifo_wakes_and_cancels)
{
	void *item[1];

	start_poller();
	k_fifo_put(&fifo, item);
	helper_expect("a");
	expect_states(0, K_POLL_STATE_FIFO_DATA_AVAILABLE, 0, 0);
	zassert_equal_ptr(k_fifo_get(&fifo, K_NO_WAIT), item);
	begin(NULL);
	start_poller();
	k_fifo_cancel_wait(&fifo);
	helper_expect("a");
	zassert_equal(result_a, -EINTR);
	expect_states(0, K_POLL_STATE_CANCELLED, 0, 0);
}

ZTEST(kernel_poll, test_signal)
{
	unsigned int signaled;
	int result;

	start_poller();
	zassert_ok(k_poll_signal_raise(&signal_object, 0x55));
	helper_expect("a");
	expect_states(0, 0, 0, K_POLL_STATE_SIGNALED);
	k_poll_signal_check(&signal_object, &signaled, &result);
	zassert_equal(signaled, 1);
	zassert_equal(result, 0x55);
	k_poll_signal_reset(&signal_object);
	k_poll_signal_check(&signal_object, &signaled, &result);
	zassert_equal(signaled, 0);
}

ZTEST_SUITE(kernel_poll, NULL, NULL, begin, end_threads, NULL);
