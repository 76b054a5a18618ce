/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Standard error that nobody reads: the console, its sink and its helper as they are, over a pipe
 * of one page, with the loop played by the test. The first check that fails ends the program.
 */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#undef main

#include "host/console.c"
#include "host/loop.h"

enum {
	LINES = 4000,
	LINE = 64,
	PIPE = 4096,
	PATIENCE_S = 60,
};

static int report; /* standard output, before the test has taken it */
static int reader;
static struct loop_source *source;
static bool output_was_drained;
static int output_error;

/* What the modules link to. */
bool clock_is_virtual(void)
{
	return false;
}

bool carry_register(const char *name, void *data, size_t size)
{
	return false;
}

void loop_add(struct loop_source *added, uint32_t events)
{
	source = added;
}

static void check(bool holds, const char *what, int line)
{
	if (!holds) {
		dprintf(report, "console_test.c:%d: %s\n", line, what);
		_exit(1);
	}
}

#define CHECK(condition) check(condition, #condition, __LINE__)

static void open_pipe(void)
{
	int ends[2];

	CHECK(pipe2(ends, O_CLOEXEC) == 0);
	CHECK(fcntl(ends[1], F_SETPIPE_SZ, PIPE) == PIPE);
	CHECK(dup2(ends[1], STDERR_FILENO) == STDERR_FILENO);
	close(ends[1]);
	if (reader != 0) {
		close(reader);
	}
	reader = ends[0];
}

/* Reads until that text has come, the loop running. */
static void read_until(char *text, size_t size, const char *end)
{
	size_t length = 0;

	do {
		struct pollfd polled[] = {{.fd = reader, .events = POLLIN},
		                          {.fd = source->fd, .events = POLLIN}};

		CHECK(poll(polled, 2, PATIENCE_S * 1000) > 0);
		if (polled[0].revents != 0) {
			const ssize_t n = read(reader, text + length, size - length - 1);

			CHECK(n > 0);
			length += (size_t)n;
		}
		if (polled[1].revents != 0) {
			source->ready(source, EPOLLIN);
		}
		text[length] = '\0';
	} while (strstr(text, end) == NULL);
}

static void write_line(int number)
{
	char line[LINE + 1];

	snprintf(line, sizeof(line), "%0*d\n", LINE - 1, number);
	port_console_write(line, LINE);
}

/* Returning at all is what is tested: it is the alarm that ends a writer that waits. */
static void test_unread_lines_are_dropped_counted_and_told(void)
{
	static char text[LINES * LINE];
	char told[64];
	uint64_t dropped;

	for (int i = 0; i < LINES; i++) {
		write_line(i);
	}
	dropped = console_dropped();
	CHECK(dropped >= LINES - (CONSOLE_RING + PIPE) / LINE);
	CHECK(dropped < LINES);
	snprintf(told, sizeof(told), "--- %d lines dropped ---\n", (int)dropped);
	read_until(text, sizeof(text), told);
	for (int i = 0; i < LINES - (int)dropped; i++) {
		CHECK(atoi(text + (size_t)i * LINE) == i);
	}
	CHECK(strstr(text, told) == text + (LINES - dropped) * LINE);
	write_line(LINES);
	read_until(text, sizeof(text), "\n");
	CHECK(atoi(text) == LINES);
	CHECK(console_dropped() == dropped);
}

static void on_output_drained(void *arg, int error)
{
	output_was_drained = true;
	output_error = error;
}

static void test_output_to_the_same_file_stays_in_order(void)
{
	char text[2 * LINE + 1];

	CHECK(console_output(on_output_drained, NULL) == &output);
	CHECK(dup2(STDERR_FILENO, STDOUT_FILENO) == STDOUT_FILENO);
	CHECK(console_output(on_output_drained, NULL) == &errors);
	write_line(1);
	CHECK(sink_put(console_output(on_output_drained, NULL), "prompt\n", 7));
	read_until(text, sizeof(text), "prompt\n");
	CHECK(atoi(text) == 1);
	while (!output_was_drained) {
		CHECK(poll(&(struct pollfd){.fd = source->fd, .events = POLLIN}, 1,
		           PATIENCE_S * 1000) > 0);
		source->ready(source, EPOLLIN);
	}
	CHECK(output_error == 0);
}

static void test_a_reader_that_has_gone_ends_nothing(void)
{
	const uint64_t before = console_dropped();
	char text[PIPE];

	close(reader);
	reader = 0;
	write_line(1);
	CHECK(poll(&(struct pollfd){.fd = source->fd, .events = POLLIN}, 1, PATIENCE_S * 1000) > 0);
	source->ready(source, EPOLLIN);
	CHECK(output_error == EPIPE);
	CHECK(console_dropped() == before + 1);
	/* and keeps nobody busy */
	CHECK(!errors.is_submitted);
	write_line(2);
	CHECK(poll(&(struct pollfd){.fd = source->fd, .events = POLLIN}, 1, PATIENCE_S * 1000) > 0);
	source->ready(source, EPOLLIN);
	CHECK(console_dropped() == before + 2);
	open_pipe();
	write_line(3);
	read_until(text, sizeof(text), "3\n");
	CHECK(console_dropped() == before + 2);
	CHECK(strncmp(text, "--- 2 lines dropped ---\n", 24) == 0);
}

static void test_the_end_does_not_wait_for_a_reader(void)
{
	for (int i = 0; i < LINES; i++) {
		write_line(i);
	}
	stop();
	write_line(LINES);
}

int main(void)
{
	report = dup(STDOUT_FILENO);
	signal(SIGPIPE, SIG_IGN);
	alarm(PATIENCE_S);
	open_pipe();
	CHECK(console_module.start() == 0);
	test_unread_lines_are_dropped_counted_and_told();
	test_output_to_the_same_file_stays_in_order();
	test_a_reader_that_has_gone_ends_nothing();
	test_the_end_does_not_wait_for_a_reader();
	dprintf(report, "4 tests passed\n");
	_exit(0);
}
