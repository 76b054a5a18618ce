/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Board time in real time, over a host's clock that the test moves: clock.c as it is, with its
 * clock_gettime() replaced. Each test is a line; the first that fails ends the program.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#undef main

static int fake_gettime(clockid_t clock, struct timespec *time);

#define clock_gettime fake_gettime
#include "host/clock.c"
#undef clock_gettime

#define MS 1000000ull

static uint64_t host_ns;
static uint64_t cpu_ns;

static int fake_gettime(clockid_t clock, struct timespec *time)
{
	const uint64_t ns = clock == CLOCK_MONOTONIC ? host_ns : cpu_ns;

	*time = (struct timespec){(time_t)(ns / NS_PER_S), (long)(ns % NS_PER_S)};
	return 0;
}

/* What clock.c links to, and no test here needs. */
bool carry_register(const char *name, void *data, size_t size)
{
	return false;
}

int parse_duration_us(const char *text, uint64_t *us, struct host_error *error)
{
	return -1;
}

static void check(bool holds, const char *what, int line)
{
	if (!holds) {
		printf("clock_test.c:%d: %s\n", line, what);
		exit(1);
	}
}

#define CHECK(condition) check(condition, #condition, __LINE__)

static void power_on(void)
{
	memset(&state, 0, sizeof(state));
	memset(&gap, 0, sizeof(gap));
	host_ns = 77 * NS_PER_S;
	cpu_ns = 0;
	wait_ns = 0;
	untold_ns = 0;
	CHECK(start() == 0);
	CHECK(clock_board_us() == 0);
}

/* The host runs on for a while, looking at the clock, as an idle light does. */
static void run_on(uint64_t ns)
{
	const uint64_t end_ns = host_ns + ns;

	while (host_ns < end_ns) {
		clock_wait_begin(host_ns + 10 * MS);
		host_ns += 10 * MS;
		clock_wait_end();
	}
}

static void test_board_time_follows_the_host(void)
{
	power_on();
	clock_wait_begin(host_ns + NS_PER_S);
	host_ns += NS_PER_S;
	clock_wait_end();
	CHECK(clock_board_us() == 1000000);
	host_ns += 100 * MS; /* as late as it may be */
	CHECK(clock_board_us() == 1100000);
	CHECK(clock_stops_get().count == 0);
	/* without end, so nothing is late */
	clock_wait_begin(UINT64_MAX);
	host_ns += 3600 * NS_PER_S;
	clock_wait_end();
	CHECK(clock_board_us() == 3601100000);
}

static void test_a_stop_while_waiting_goes_as_far_as_the_wait(void)
{
	power_on();
	clock_wait_begin(host_ns + 20 * MS);
	host_ns += 1520 * MS;
	clock_wait_end();
	CHECK(clock_board_us() == 20000);
	CHECK(clock_stops_get().count == 1);
	CHECK(clock_stops_get().total_us == 1500000);
	CHECK(clock_take_stop_ms() == 1500);
	CHECK(clock_take_stop_ms() == 0);
}

static void test_a_stop_of_running_code_is_left_out(void)
{
	power_on();
	run_on(NS_PER_S);
	host_ns += 8000 * MS;
	cpu_ns += 2 * MS;
	CHECK(clock_board_us() == 1002000);
	CHECK(clock_stops_get().behind_us == 7998000);
}

static void test_what_the_firmware_computes_is_not_left_out(void)
{
	power_on();
	run_on(NS_PER_S);
	host_ns += 8000 * MS;
	cpu_ns += 8000 * MS;
	CHECK(clock_board_us() == 9000000);
	CHECK(clock_stops_get().count == 0);
}

static void test_small_stops_are_counted_and_not_told(void)
{
	power_on();
	host_ns += 101 * MS;
	CHECK(clock_board_us() == 0);
	CHECK(clock_stops_get().count == 1);
	CHECK(clock_take_stop_ms() == 0);
	host_ns += 400 * MS;
	CHECK(clock_board_us() == 0);
	CHECK(clock_take_stop_ms() == 0);
}

/* 1/64 faster: 1.5 s take 96 s. */
static void test_a_stop_is_made_up_for(void)
{
	uint64_t before_us;

	power_on();
	host_ns += 1500 * MS;
	CHECK(clock_board_us() == 0);
	before_us = clock_board_us();
	for (int i = 0; i < 96; i++) {
		CHECK(clock_stops_get().behind_us > 0);
		run_on(NS_PER_S);
		CHECK(clock_board_us() - before_us == 1015625); /* 65/64 s */
		before_us = clock_board_us();
	}
	CHECK(clock_stops_get().behind_us == 0);
	CHECK(clock_board_us() == 97500000);
	run_on(NS_PER_S);
	CHECK(clock_board_us() == 98500000);
}

static void test_a_wait_for_board_time_is_never_too_long(void)
{
	power_on();
	host_ns += 1500 * MS;
	for (int i = 1; i < 200; i++) {
		const uint64_t due_us = 640000ull * (uint64_t)i;

		while (clock_board_us() < due_us) {
			const uint64_t left_ns = clock_host_until_ns(due_us);

			CHECK(left_ns > 0);
			clock_wait_begin(host_ns + left_ns);
			host_ns += left_ns;
			clock_wait_end();
		}
		CHECK(clock_board_us() - due_us <= 200); /* what is left of one step's rounding */
	}
	CHECK(clock_host_until_ns(1) == 0);
}

static void test_a_reading_of_the_hosts_clock_lies_before_in_or_after_a_stop(void)
{
	power_on();
	run_on(NS_PER_S);
	host_ns += 2000 * MS;
	CHECK(clock_board_us() == 1000000);
	CHECK(clock_board_of_host_us(host_ns - 2010 * MS) == 990000);
	CHECK(clock_board_of_host_us(host_ns - 1990 * MS) == 1000000);
	CHECK(clock_board_of_host_us(host_ns - 1 * MS) == 1000000);
	CHECK(clock_board_of_host_us(host_ns) == 1000000);
	CHECK(clock_board_of_host_us(1) == 0);
}

/* Whatever the host does, board time never goes back, and is behind by what it says. */
static void test_any_stops(void)
{
	uint64_t last_us = 0;
	uint32_t seed = 1;

	power_on();
	for (int i = 0; i < 1000000; i++) {
		uint64_t step_ns;

		seed = seed * 1664525u + 1013904223u;
		step_ns = (uint64_t)seed % (i % 1000 == 0 ? 3000 * MS : 30 * MS);
		if (seed >> 31 != 0) {
			clock_wait_begin(host_ns + seed % (20 * MS));
		}
		host_ns += step_ns;
		cpu_ns += step_ns / 8;
		clock_wait_end();
		CHECK(clock_board_us() >= last_us);
		last_us = clock_board_us();
		CHECK(last_us + clock_stops_get().behind_us <= (host_ns - 77 * NS_PER_S) / 1000u);
		CHECK(last_us + clock_stops_get().behind_us + 1 >=
		      (host_ns - 77 * NS_PER_S) / 1000u);
	}
	CHECK(clock_stops_get().count > 0);
}

int main(void)
{
	test_board_time_follows_the_host();
	test_a_stop_while_waiting_goes_as_far_as_the_wait();
	test_a_stop_of_running_code_is_left_out();
	test_what_the_firmware_computes_is_not_left_out();
	test_small_stops_are_counted_and_not_told();
	test_a_stop_is_made_up_for();
	test_a_wait_for_board_time_is_never_too_long();
	test_a_reading_of_the_hosts_clock_lies_before_in_or_after_a_stop();
	test_any_stops();
	printf("9 tests passed\n");
	return 0;
}
