/* SPDX-License-Identifier: Apache-2.0 */
/* Work queues. */
#include "helper.h"

static K_THREAD_STACK_DEFINE(queue_stack, HELPER_STACK_SIZE);
static struct k_work_q queue; /* less urgent than the test */
static struct k_work work, other;
static struct k_work_delayable delayed;

static void note_w(struct k_work *item)
{
	helper_note('w');
}

static void note_o(struct k_work *item)
{
	helper_note('o');
}

static void slow(struct k_work *item)
{
	helper_note('<');
	k_sleep(K_TICKS(20));
	helper_note('>');
}

static void *setup(void)
{
	k_work_queue_init(&queue);
	k_work_queue_start(&queue, queue_stack, K_THREAD_STACK_SIZEOF(queue_stack), PRIO_LOW, NULL);
	return NULL;
}

static void begin(void *fixture)
{
	helper_begin();
	k_work_init(&work, note_w);
	k_work_init(&other, note_o);
	k_work_init_delayable(&delayed, note_w);
}

ZTEST(kernel_work, test_submitted_twice_runs_once)
{
	zassert_equal(k_work_submit_to_queue(&queue, &work), 1);
	zassert_equal(k_work_submit_to_queue(&queue, &other), 1);
	zassert_equal(k_work_submit_to_queue(&queue, &work), 0);
	zassert_equal(k_work_busy_get(&work), K_WORK_QUEUED);
	k_sleep(K_TICKS(5));
	helper_expect("wo");
	zassert_equal(k_work_busy_get(&work), 0);
}

ZTEST(kernel_work, test_running_item_is_queued_again)
{
	k_work_init(&work, slow);
	k_work_submit_to_queue(&queue, &work);
	k_sleep(K_TICKS(5));
	zassert_equal(k_work_busy_get(&work), K_WORK_RUNNING);
	zassert_equal(k_work_submit_to_queue(&queue, &work), 2);
	k_sleep(K_TICKS(50));
	helper_expect("<><>");
	zassert_equal(k_work_busy_get(&work), 0);
}

ZTEST(kernel_work, test_delay_schedule_and_reschedule)
{
	zassert_equal(k_work_schedule_for_queue(&queue, &delayed, K_TICKS(10)), 1);
	zassert_equal(k_work_schedule_for_queue(&queue, &delayed, K_TICKS(1)), 0);
	k_sleep(K_TICKS(5));
	helper_expect("");
	zassert_equal(k_work_reschedule_for_queue(&queue, &delayed, K_TICKS(20)), 1);
	k_sleep(K_TICKS(15));
	helper_expect("");
	zassert_true(k_work_delayable_is_pending(&delayed));
	k_sleep(K_TICKS(15));
	helper_expect("w");
	zassert_false(k_work_delayable_is_pending(&delayed));
}

ZTEST(kernel_work, test_without_a_queue)
{
	struct k_work_q idle_queue;

	k_work_queue_init(&idle_queue);
	zassert_equal(k_work_submit_to_queue(NULL, &work), -EINVAL);
	zassert_equal(k_work_submit_to_queue(&idle_queue, &work), -ENODEV);
}

ZTEST(kernel_work, test_system_queue_preempts)
{
	zassert_equal(k_work_submit(&work), 1);
	helper_expect("w");
}

ZTEST_SUITE(kernel_work, NULL, setup, begin, NULL, NULL);
