/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --record FILE: what the board's models do, as a value change dump (IEEE 1364-2005, clause 18)
 * with a time scale of 1 us of board time. It goes on over resets. In real time a disk that is too
 * slow loses changes: a comment says so, in their place, and all values follow.
 */
#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/claim.h"
#include "host/clock.h"
#include "host/module.h"
#include "host/say.h"
#include "host/sink.h"
#include "models/board.h"

#define TEXT_SIZE      16384u
#define LINE_SIZE      128u
#define RING_SIZE      (1u << 18)
#define FLUSH_AFTER_US 1000000

/* Identifier codes: '!' level, '"' temperature, from '#' pulses of servos; then lines from
 * LINE_CODE, probes from PROBE_CODE
 */
#define LEVEL_CODE '!'
#define TEMP_CODE  '"'
#define SERVO_CODE '#'
#define LINE_CODE  'A'
#define PROBE_CODE 'a'

static const char *path;
static struct sink sink = SINK_INIT(-1, RING_SIZE, "pharos-record");
static bool is_lossy; /* changes are missing since the last time mark */
static char text[TEXT_SIZE];
static size_t used;
static int64_t time_us = -1; /* of the last time mark */
static int64_t flushed_us;
static uint32_t lines;

static void check_file(void)
{
	const int error = sink_error(&sink);

	if (sink.fd >= 0 && error != 0) {
		host_say("--record: %s: %s; the recording ends here", path, strerror(error));
		close(sink.fd);
		sink.fd = -1;
	}
}

static void flush(void)
{
	if (sink.fd >= 0) {
		is_lossy = !sink_put(&sink, text, used) || is_lossy;
		check_file();
	}
	used = 0;
}

static void __attribute__((format(printf, 1, 2))) put(const char *format, ...)
{
	va_list args;

	if (used > TEXT_SIZE - LINE_SIZE) {
		flush();
	}
	va_start(args, format);
	used += (size_t)vsnprintf(text + used, LINE_SIZE, format, args);
	va_end(args);
}

static void put_all(int64_t now_us, const char *command);

static void put_time(int64_t now_us)
{
	if (is_lossy) {
		/* from here on it is whole again, as far as it fits */
		is_lossy = false;
		time_us = -1;
		put("$comment changes are missing here $end\n");
		put_all(now_us, "$dumpall");
	}
	if (now_us != time_us) {
		/* somebody may be looking at the file; in virtual time nobody waits for it */
		if (!clock_is_virtual() && now_us - flushed_us >= FLUSH_AFTER_US) {
			flush();
			flushed_us = now_us;
		}
		time_us = now_us;
		put("#%" PRId64 "\n", now_us);
	}
}

/* At least 32 bits, two's complement. */
static void put_number(char code, int64_t value)
{
	char bits[66];
	size_t n = sizeof(bits);
	uint64_t rest = (uint64_t)value & UINT32_MAX;

	bits[--n] = '\0';
	do {
		bits[--n] = (char)('0' + (rest & 1u));
		rest >>= 1;
	} while (rest != 0);
	bits[--n] = 'b';
	put("%s %c\n", bits + n, code);
}

static void put_temp(double temp_c)
{
	put("r%.3f %c\n", temp_c * 1000.0, TEMP_CODE);
}

static void light_changed(int64_t now_us)
{
	put_time(now_us);
	put_number(LEVEL_CODE, board.lamp.level_ppm);
}

static void temperature_known(int64_t now_us, double temp_c)
{
	put_time(now_us);
	put_temp(temp_c);
}

static void servo_changed(int64_t now_us, uint32_t servo)
{
	put_time(now_us);
	put_number((char)(SERVO_CODE + servo), board.servos[servo].pulse_ns);
}

static void lines_changed(int64_t now_us, uint32_t levels)
{
	const uint32_t changed = levels ^ lines;

	lines = levels;
	put_time(now_us);
	for (uint32_t line = 0; line < BOARD_LINE_COUNT; line++) {
		if ((changed & (1u << line)) != 0) {
			put("%u%c\n", (levels >> line) & 1u, LINE_CODE + (int)line);
		}
	}
}

static void probe_set(int64_t now_us, unsigned int channel, int64_t value)
{
	if (board_probe_name(channel) != NULL) {
		put_time(now_us);
		put_number((char)(PROBE_CODE + channel), value);
	}
}

static void put_header(void)
{
	put("$version pharos $end\n$timescale 1 us $end\n$scope module pharos $end\n");
	put("$var integer 32 %c level_ppm $end\n", LEVEL_CODE);
	put("$var real 64 %c temp_mdegc $end\n", TEMP_CODE);
	for (uint32_t servo = 0; servo < BOARD_SERVO_COUNT; servo++) {
		put("$var integer 32 %c %s_pulse_ns $end\n", SERVO_CODE + (int)servo,
		    board_servo_name(servo));
	}
	for (uint32_t line = 0; line < BOARD_LINE_COUNT; line++) {
		put("$var wire 1 %c %s $end\n", LINE_CODE + (int)line, board_line_name(line));
	}
	for (unsigned int channel = 0; channel < BOARD_PROBE_COUNT; channel++) {
		if (board_probe_name(channel) != NULL) {
			put("$var integer 32 %c %s $end\n", PROBE_CODE + (int)channel,
			    board_probe_name(channel));
		}
	}
	put("$upscope $end\n$enddefinitions $end\n");
}

static void put_all(int64_t now_us, const char *command)
{
	put_time(now_us);
	put("%s\n", command);
	put_number(LEVEL_CODE, board.lamp.level_ppm);
	put_temp(board.housing.temp_c);
	for (uint32_t servo = 0; servo < BOARD_SERVO_COUNT; servo++) {
		put_number((char)(SERVO_CODE + servo), board.servos[servo].pulse_ns);
	}
	for (uint32_t line = 0; line < BOARD_LINE_COUNT; line++) {
		put("%u%c\n", (lines >> line) & 1u, LINE_CODE + (int)line);
	}
	for (unsigned int channel = 0; channel < BOARD_PROBE_COUNT; channel++) {
		if (board_probe_name(channel) != NULL) {
			put_number((char)(PROBE_CODE + channel), board.probes[channel]);
		}
	}
	put("$end\n");
}

static int parse_record(const char *value, struct host_error *error)
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
	sink.fd = claim_output(path, !carry_is_reset(), &error);
	if (sink.fd < 0) {
		host_say("--record: %s", error.text);
		return -1;
	}
	lines = board_lines_read();
	if (!carry_is_reset()) {
		put_header();
		put_all((int64_t)clock_board_us(), "$dumpvars");
	}
	board_listener = (struct board_listener){
		.light = light_changed,
		.temperature = temperature_known,
		.servo = servo_changed,
		.lines = lines_changed,
		.probe = probe_set,
	};
	return 0;
}

static void save(void)
{
	/* The end needs room too: it may be what says that changes are missing. */
	if (sink_finish(&sink, HELPER_FINISH_MS)) {
		flush();
		(void)sink_finish(&sink, HELPER_FINISH_MS);
	}
	check_file();
}

static void stop(void)
{
	if (sink.fd >= 0) {
		put_time((int64_t)clock_board_us());
		save();
	}
	if (sink.fd >= 0) {
		close(sink.fd);
		sink.fd = -1;
	}
}

static const struct host_option options[] = {
	{"record", "FILE", "write light, temperature and commands to FILE as a value change dump",
         parse_record},
	{0},
};

/* By name after "board", whose models it listens to. */
HOST_MODULE(recorder_module) = {
	.name = "recorder",
	.order = HOST_ORDER_BOARD,
	.options = options,
	.start = start,
	.save = save,
	.stop = stop,
};
