/* SPDX-License-Identifier: Apache-2.0 */
#include "host/console.h"

#include <inttypes.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/clock.h"
#include "host/module.h"
#include "kernel/port.h"

static struct sink errors = SINK_INIT(STDERR_FILENO, CONSOLE_RING, "pharos-stderr");
static struct sink output = SINK_INIT(STDOUT_FILENO, CONSOLE_RING, "pharos-stdout");
static void (*output_drained)(void *arg, int error);
static void *output_arg;
static bool is_running;

static struct {
	uint64_t dropped;
	uint64_t told;    /* so many have been read of, as far as can be known */
	uint64_t telling; /* what the last line about them says */
} state;

uint64_t console_dropped(void)
{
	return state.dropped;
}

/* At once, and as long as it takes. */
static void write_direct(const char *text, size_t length)
{
	while (length > 0) {
		const ssize_t n = write(STDERR_FILENO, text, length);

		if (n <= 0) {
			return;
		}
		text += n;
		length -= (size_t)n;
	}
}

static void tell_dropped(void)
{
	char text[64];
	int length;

	if (state.dropped == state.telling) {
		return;
	}
	length = snprintf(text, sizeof(text), "--- %" PRIu64 " lines dropped ---\n",
	                  state.dropped - state.telling);
	if (sink_put(&errors, text, (size_t)length)) {
		state.telling = state.dropped;
	}
}

void port_console_write(const char *text, size_t length)
{
	if (!is_running) {
		write_direct(text, length);
		return;
	}
	tell_dropped();
	if (state.dropped == state.telling && sink_put(&errors, text, length)) {
		return;
	}
	for (size_t i = 0; i < length; i++) {
		state.dropped += text[i] == '\n' ? 1 : 0;
	}
}

static void on_errors_drained(int error, uint64_t lost_lines)
{
	if (error == 0) {
		state.told = state.telling;
		tell_dropped();
	} else {
		/* told with the next line: now it would fail as well, and again, without end */
		const bool has_told = state.telling != state.told && lost_lines > 0;

		state.dropped += lost_lines - (has_told ? 1 : 0);
		state.telling = state.told;
	}
}

/* A reader that has gone may come back, a full disk may be emptied: all is tried again. */
static void on_drained(struct sink *sink)
{
	const int error = sink_error(sink);
	const uint64_t lines = sink_forgive(sink);

	if (sink == &errors) {
		on_errors_drained(error, lines);
	}
	if (output_drained != NULL) {
		output_drained(output_arg, error);
	}
}

static bool is_one_file(void)
{
	struct stat first;
	struct stat second;

	return fstat(STDERR_FILENO, &first) == 0 && fstat(STDOUT_FILENO, &second) == 0 &&
	       first.st_dev == second.st_dev && first.st_ino == second.st_ino;
}

struct sink *console_output(void (*drained)(void *arg, int error), void *arg)
{
	output_drained = drained;
	output_arg = arg;
	output.drained = on_drained;
	return is_one_file() ? &errors : &output;
}

static int start(void)
{
	carry_register("console", &state, sizeof(state));
	errors.drained = on_drained;
	is_running = !clock_is_virtual();
	return 0;
}

static void finish(void)
{
	if (is_running) {
		tell_dropped();
		(void)sink_finish(&errors, CONSOLE_FINISH_MS);
	}
}

/* What comes after has nobody to wait for. */
static void stop(void)
{
	finish();
	is_running = is_running && sink_room(&errors) < CONSOLE_RING;
}

/* After the loop, by whose means helpers report; before all that writes. */
HOST_MODULE(console_module) = {
	.name = "console",
	.order = HOST_ORDER_BASE,
	.start = start,
	.save = finish,
	.stop = stop,
};
