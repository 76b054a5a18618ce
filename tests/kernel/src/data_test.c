/* SPDX-License-Identifier: Apache-2.0 */
/* Message queues, FIFOs, LIFOs, stacks. */
#include "helper.h"

static K_THREAD_STACK_DEFINE(stack_a, HELPER_STACK_SIZE);
static struct k_thread thread_a;

static struct k_msgq msgq;
static uint32_t msgq_buffer[3];
static struct k_fifo fifo;
static struct k_lifo lifo;
static struct k_stack stack;
static stack_data_t stack_buffer[2];
static volatile int result_a;

struct item {
	void *reserved;
	int value;
};

static void begin(void *fixture)
{
	helper_begin();
	k_msgq_init(&msgq, (char *)msgq_buffer, sizeof(uint32_t), ARRAY_SIZE(msgq_buffer));
	k_fifo_init(&fifo);
	k_lifo_init(&lifo);
	k_stack_init(&stack, stack_buffer, ARRAY_SIZE(stack_buffer));
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

ZTEST(kernel_data, test_msgq_order_and_limits)
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
	zassert_ok(k_msgq_peek(&msgq, &value));
	zassert_equal(value, 2);
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

ZTEST(kernel_data, test_msgq_waiting_writer_comes_last)
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

ZTEST(kernel_data, test_msgq_purge_wakes_writers)
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

ZTEST(kernel_data, test_msgq_waiting_reader_gets_at_once)
{
	start_a(get_one);
	put(9);
	helper_expect("a");
	zassert_equal(result_a, 9);
	zassert_equal(k_msgq_num_used_get(&msgq), 0);
}

ZTEST(kernel_data, test_fifo_and_lifo_order)
{
	struct item items[3];

	for (int i = 0; i < 3; i++) {
		k_fifo_put(&fifo, &items[i]);
	}
	zassert_equal_ptr(k_fifo_peek_head(&fifo), &items[0]);
	zassert_equal_ptr(k_fifo_peek_tail(&fifo), &items[2]);
	for (int i = 0; i < 3; i++) {
		zassert_equal_ptr(k_fifo_get(&fifo, K_NO_WAIT), &items[i]);
	}
	zassert_is_null(k_fifo_get(&fifo, K_NO_WAIT));
	zassert_true(k_fifo_is_empty(&fifo));
	for (int i = 0; i < 3; i++) {
		k_lifo_put(&lifo, &items[i]);
	}
	for (int i = 2; i >= 0; i--) {
		zassert_equal_ptr(k_lifo_get(&lifo, K_NO_WAIT), &items[i]);
	}
	zassert_is_null(k_lifo_get(&lifo, K_TICKS(2)));
}

ZTEST(kernel_data, test_queue_insert_remove_and_lists)
{
	struct item items[4];
	struct k_queue queue;

	k_queue_init(&queue);
	items[1].reserved = &items[3];
	items[3].reserved = NULL;
	zassert_ok(k_queue_append_list(&queue, &items[1], &items[3]));
	k_queue_prepend(&queue, &items[0]);
	k_queue_insert(&queue, &items[1], &items[2]);
	zassert_false(k_queue_unique_append(&queue, &items[3]));
	zassert_true(k_queue_remove(&queue, &items[1]));
	zassert_false(k_queue_remove(&queue, &items[1]));
	zassert_true(k_queue_unique_append(&queue, &items[1]));
	zassert_equal_ptr(k_queue_get(&queue, K_NO_WAIT), &items[0]);
	zassert_equal_ptr(k_queue_get(&queue, K_NO_WAIT), &items[2]);
	zassert_equal_ptr(k_queue_get(&queue, K_NO_WAIT), &items[3]);
	zassert_equal_ptr(k_queue_get(&queue, K_NO_WAIT), &items[1]);
	zassert_equal(k_queue_append_list(&queue, NULL, NULL), -EINVAL);
}

static void get_item(void *p1, void *p2, void *p3)
{
	result_a = k_fifo_get(&fifo, K_FOREVER) == NULL;
	helper_note('a');
}

ZTEST(kernel_data, test_fifo_cancel_wait)
{
	start_a(get_item);
	helper_expect("");
	k_fifo_cancel_wait(&fifo);
	helper_expect("a");
	zassert_equal(result_a, 1);
}

ZTEST(kernel_data, test_stack)
{
	stack_data_t value;

	zassert_ok(k_stack_push(&stack, 1));
	zassert_ok(k_stack_push(&stack, 2));
	zassert_equal(k_stack_push(&stack, 3), -ENOMEM);
	zassert_ok(k_stack_pop(&stack, &value, K_NO_WAIT));
	zassert_equal(value, 2);
	zassert_ok(k_stack_pop(&stack, &value, K_NO_WAIT));
	zassert_equal(value, 1);
	zassert_equal(k_stack_pop(&stack, &value, K_NO_WAIT), -EBUSY);
	zassert_equal(k_stack_pop(&stack, &value, K_TICKS(2)), -EAGAIN);
}

ZTEST_SUITE(kernel_data, NULL, NULL, begin, end_threads, NULL);
