/* SPDX-License-Identifier: Apache-2.0 */
/* Message queues. */
#include "helper.h"

static K_THREAD_STACK_DEFINE(stack_a, HELPER_STACK_SIZE);
static struct k_thread thread_a;

static struct k_msgq msgq;
static uint32_t msgq_buffer[3];
static volatile int result_a;

static void begin(void *fixture)
{
	helper_begin();
	k_msgq_init(&msgq, (char *)msgq_buffer, sizeof(uint32_t), ARRAY_SIZE(msgq_buffer));
}

static void end_threads(void *fixture)
{
	helper_abort(&thread_a);
}

static void start_a(k_thread_entry_t entry)
{
	k_thread_create(&thread_a, stack_a, K_THREAD_STACK_SIZEOF(stack_a), entry, NULL, NULL, NULL,
	                PRIO_HIGH, 0, K_NO_WAIT);
}

static void put(uint32_t value)
{
	zassert_ok(k_msgq_put(&msgq, &value, K_NO_WAIT));
}

static void expect_get(uint32_t expected)
{
	uint32_t value = 0;

	zassert_ok(k_msgq_get(&msgq, &value, K_NO_WAIT));
	zassert_equal(value, expected, "%u", value);
}

ZTEST(kernel_msgq, test_order_and_limits)
{
	uint32_t value = 0;

	zassert_equal(k_msgq_get(&msgq, &value, K_NO_WAIT), -ENOMSG);
	zassert_equal(k_msgq_get(&msgq, &value, K_TICKS(3)), -EAGAIN);
	put(1);
	put(2);
	put(3);
	zassert_equal(k_msgq_put(&msgq, &value, K_NO_WAIT), -ENOMSG);
	zassert_equal(k_msgq_put(&msgq, &value, K_TICKS(3)), -EAGAIN);
	expect_get(1);
	put(4);
	zassert_equal(k_msgq_num_used_get(&msgq), 3);
	zassert_equal(k_msgq_num_free_get(&msgq), 0);
	expect_get(2);
	expect_get(3);
	expect_get(4);
}

static void put_seven(void *p1, void *p2, void *p3)
{
	const uint32_t value = 7;

	result_a = k_msgq_put(&msgq, &value, K_FOREVER);
	helper_note('a');
}

static void get_one(void *p1, void *p2, void *p3)
{
	uint32_t value;

	zassert_ok(k_msgq_get(&msgq, &value, K_FOREVER));
	result_a = (int)value;
	helper_note('a');
}

ZTEST(kernel_msgq, test_waiting_writer_comes_last)
{
	put(1);
	put(2);
	put(3);
	start_a(put_seven);
	helper_expect("");
	expect_get(1);
	helper_expect("a");
	expect_get(2);
	expect_get(3);
	expect_get(7);
}

ZTEST(kernel_msgq, test_purge_wakes_writers)
{
	put(1);
	put(2);
	put(3);
	start_a(put_seven);
	k_msgq_purge(&msgq);
	helper_expect("a");
	zassert_equal(result_a, -ENOMSG);
	zassert_equal(k_msgq_num_used_get(&msgq), 0);
}

ZTEST(kernel_msgq, test_waiting_reader_gets_at_once)
{
	start_a(get_one);
	put(9);
	helper_expect("a");
	zassert_equal(result_a, 9);
	zassert_equal(k_msgq_num_used_get(&msgq), 0);
}

ZTEST_SUITE(kernel_msgq, NULL, NULL, begin, end_threads, NULL);
