/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --trace FILE: one line per event of the kernel and its devices, "<board time in us> <kind> <name>
 * <value>". In virtual time the same seed and the same inputs give the same file. In real time a
 * disk that is too slow loses events, in whole lines: "lost trace N" says how many, in their place.
 */
#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/claim.h"
#include "host/clock.h"
#include "host/module.h"
#include "host/say.h"
#include "host/sink.h"
#include "kernel/port.h"

enum {
	TRACE_BUFFER = 1 << 16,
	TRACE_RING = 1 << 19,
	TRACE_WORD = 64,
	TRACE_LINE = 2 * TRACE_WORD + 48
};

static const char *path;
static char text[TRACE_BUFFER];
static size_t used;
static uint64_t events; /* in text */
static uint64_t lost;
static struct sink sink = SINK_INIT(-1, TRACE_RING, "pharos-trace");

static void close_file(void)
{
	close(sink.fd);
	sink.fd = -1;
}

static void check_file(void)
{
	const int error = sink_error(&sink);

	if (error != 0) {
		host_say("%s: %s; the trace ends here", path, strerror(error));
		close_file();
	}
}

static void put_lost(void)
{
	char line[64];
	const int length = snprintf(line, sizeof(line), "%" PRIu64 " lost trace %" PRIu64 "\n",
	                            clock_board_us(), lost);

	if (lost > 0 && sink_put(&sink, line, (size_t)length)) {
		lost = 0;
	}
}

static void flush(void)
{
	put_lost();
	if (lost > 0 || !sink_put(&sink, text, used)) {
		lost += events;
	}
	used = 0;
	events = 0;
	check_file();
}

static void put_number(uint64_t value)
{
	char digits[20];
	size_t n = 0;

	do {
		digits[n++] = (char)('0' + value % 10);
		value /= 10;
	} while (value != 0);
	while (n > 0) {
		text[used++] = digits[--n];
	}
}

static void put_word(const char *word)
{
	const size_t length = strnlen(word, TRACE_WORD);

	text[used++] = ' ';
	memcpy(text + used, word, length);
	used += length;
}

void port_trace(const char *kind, const char *name, int64_t value)
{
	if (sink.fd < 0) {
		return;
	}
	if (used > sizeof(text) - TRACE_LINE) {
		flush();
	}
	put_number(clock_board_us());
	put_word(kind);
	put_word(name != NULL && name[0] != '\0' ? name : "-");
	text[used++] = ' ';
	if (value < 0) {
		text[used++] = '-';
	}
	put_number(value < 0 ? 0 - (uint64_t)value : (uint64_t)value);
	text[used++] = '\n';
	events++;
}

static int parse_trace(const char *value, struct host_error *error)
{
	if (value[0] == '\0') {
		return host_error_set(error, "a file name is missing");
	}
	path = value;
	return 0;
}

static int start(void)
{
	struct host_error error;

	if (path == NULL) {
		return 0;
	}
	/* Appending, so that the events after a reset follow those before it. */
	sink.fd = claim_output(path, !carry_is_reset(), &error);
	if (sink.fd < 0) {
		host_say("--trace: %s", error.text);
		return -1;
	}
	return 0;
}

static void save(void)
{
	/* The end needs room too: it may be what says how many are lost. */
	if (sink.fd >= 0 && sink_finish(&sink, HELPER_FINISH_MS)) {
		flush();
		(void)sink_finish(&sink, HELPER_FINISH_MS);
	}
	if (sink.fd >= 0) {
		check_file();
	}
}

static void stop(void)
{
	save();
	if (sink.fd >= 0) {
		close_file();
	}
}

static const struct host_option options[] = {
	{"trace", "FILE", "write every event of the kernel to FILE, one a line", parse_trace},
	{0},
};

HOST_MODULE(trace_module) = {
	.name = "trace",
	.order = HOST_ORDER_BASE,
	.options = options,
	.start = start,
	.save = save,
	.stop = stop,
};
