/* SPDX-License-Identifier: Apache-2.0 */
/* Timeouts, timers, conversions. */
#include "helper.h"

#define EXPIRIES_MAX 2048

static int64_t expiries[EXPIRIES_MAX];
static volatile unsigned int expiry_count, stop_count;

static void expired(struct k_timer *timer)
{
	zassert_true(k_is_in_isr());
	if (expiry_count < EXPIRIES_MAX) {
		expiries[expiry_count] = k_uptime_ticks();
	}
	expiry_count++;
}

static void stopped(struct k_timer *timer)
{
	stop_count++;
}

static K_TIMER_DEFINE(timer, expired, stopped);

static void begin(void *fixture)
{
	helper_begin();
	k_timer_stop(&timer);
	expiry_count = 0;
	stop_count = 0;
}

ZTEST(kernel_time, test_periodic_timer_does_not_drift)
{
	k_timer_start(&timer, K_TICKS(30), K_TICKS(7));
	while (expiry_count < 1000) {
		k_sleep(K_TICKS(11));
		k_busy_wait(k_ticks_to_us_floor32(5));
	}
	k_timer_stop(&timer);
	for (int i = 1; i < 1000; i++) {
		zassert_equal(expiries[i] - expiries[i - 1], 7, "expiry %d", i);
	}
	zassert_equal(stop_count, 1);
}

ZTEST(kernel_time, test_absolute_timer)
{
	const int64_t at = k_uptime_ticks() + 50;

	k_timer_start(&timer, K_TIMEOUT_ABS_TICKS(at), K_NO_WAIT);
	zassert_equal(k_timer_expires_ticks(&timer), at);
	zassert_equal(k_timer_remaining_ticks(&timer), 50);
	k_sleep(K_TICKS(100));
	zassert_equal(expiry_count, 1);
	zassert_equal(expiries[0], at);
	zassert_equal(k_timer_remaining_ticks(&timer), 0);
}

ZTEST(kernel_time, test_absolute_sleep)
{
	const int64_t at = k_uptime_ticks() + 40;

	k_sleep(K_TIMEOUT_ABS_TICKS(at));
	zassert_equal(k_uptime_ticks(), at);
	k_sleep(K_TIMEOUT_ABS_TICKS(at - 20));
	zassert_equal(k_uptime_ticks(), at + 1, "a date in the past is the next tick");
}

#ifdef CONFIG_BOARD_NATIVE
/* Ten years: further than 2^64 / 10^12 s, where a product of µs and µs per second would overflow.
 */
ZTEST(kernel_time, test_sleep_of_ten_years)
{
	const int64_t before = k_uptime_get();

	k_sleep(K_HOURS(10 * 365 * 24));
	zassert_within(k_uptime_get() - before, INT64_C(315360000000), 1);
}
#endif

ZTEST(kernel_time, test_restart_replaces)
{
	k_timer_start(&timer, K_TICKS(10), K_NO_WAIT);
	k_timer_start(&timer, K_TICKS(100), K_NO_WAIT);
	k_sleep(K_TICKS(50));
	zassert_equal(expiry_count, 0);
	zassert_equal(stop_count, 0);
	k_timer_stop(&timer);
	k_timer_stop(&timer);
	zassert_equal(stop_count, 1);
}

ZTEST(kernel_time, test_busy_wait_lets_timers_run)
{
	k_timer_start(&timer, K_TICKS(10), K_NO_WAIT);
	k_busy_wait(k_ticks_to_us_ceil32(30));
	zassert_equal(expiry_count, 1);
}

ZTEST(kernel_time, test_locked_interrupts_delay_timers)
{
	const unsigned int key = irq_lock();

	k_timer_start(&timer, K_TICKS(10), K_NO_WAIT);
	k_busy_wait(k_ticks_to_us_ceil32(30));
	zassert_equal(expiry_count, 0);
	irq_unlock(key);
	k_busy_wait(k_ticks_to_us_ceil32(1));
	zassert_equal(expiry_count, 1);
}

static struct k_timer order_timers[3];

static void note_order(struct k_timer *which)
{
	helper_note((char)('0' + (which - order_timers)));
}

ZTEST(kernel_time, test_timers_of_one_tick_run_in_the_order_of_their_start)
{
	const k_timeout_t at = K_TIMEOUT_ABS_TICKS(k_uptime_ticks() + 20);

	for (int i = 0; i < 3; i++) {
		k_timer_init(&order_timers[i], note_order, NULL);
	}
	k_timer_start(&order_timers[2], at, K_NO_WAIT);
	k_timer_start(&order_timers[0], at, K_NO_WAIT);
	k_timer_start(&order_timers[1], K_TIMEOUT_ABS_TICKS(k_uptime_ticks() + 10), K_NO_WAIT);
	k_sleep(K_TICKS(30));
	helper_expect("120");
}

ZTEST(kernel_time, test_uptime)
{
	int64_t reference = k_uptime_get();

	k_msleep(50);
	zassert_between_inclusive(k_uptime_delta(&reference), 50, 51);
	zassert_equal(reference, k_uptime_get());
	zassert_equal(k_uptime_get_32(), (uint32_t)k_uptime_get());
}

/* Rounding: by the names of the functions. 1 tick: 1 s / CONFIG_SYS_CLOCK_TICKS_PER_SEC. */
ZTEST(kernel_time, test_conversions)
{
	zassert_equal(k_ms_to_ticks_ceil64(1000), CONFIG_SYS_CLOCK_TICKS_PER_SEC);
	zassert_equal(k_ticks_to_ms_floor64(3 * CONFIG_SYS_CLOCK_TICKS_PER_SEC + 1), 3000);
	zassert_equal(k_ticks_to_us_ceil64(1),
	              (999999 + CONFIG_SYS_CLOCK_TICKS_PER_SEC) / CONFIG_SYS_CLOCK_TICKS_PER_SEC);
	/* 1 tick + 1 ns: up to 2, down to 1. */
	const uint64_t ns = NSEC_PER_SEC / CONFIG_SYS_CLOCK_TICKS_PER_SEC + 1;

	zassert_equal(k_ns_to_ticks_ceil64(ns), 2);
	zassert_equal(k_ns_to_ticks_near64(ns), 1);
	zassert_equal(k_ns_to_ticks_floor64(ns), 1);
	/* 1.5 ticks. */
	zassert_equal(k_ns_to_ticks_near64(3 * (ns - 1) / 2), 2);
	/* 100 years in ms: the intermediate product does not overflow. */
	zassert_equal(k_ms_to_ticks_floor64(3155760000000ULL),
	              3155760000ULL * CONFIG_SYS_CLOCK_TICKS_PER_SEC);
}

ZTEST_SUITE(kernel_time, NULL, NULL, begin, NULL, NULL);
