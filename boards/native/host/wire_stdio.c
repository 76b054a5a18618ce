/* SPDX-License-Identifier: Apache-2.0 */
/*
 * stdio: standard input and output. On a terminal: raw, but for ^C, ^\ and the line feeds of the
 * output; restored at the end. The console's own terminal hands on ^C as well: the shell there says
 * how to leave. Pipes and files do as well; the end of the input ends nothing,
 * unless it is "stdio:eof=exit".
 *
 * The descriptors stay blocking, since they are shared with other programs. Nothing is read before
 * epoll said that it can be; what is written goes through a sink (host/console.h) in real time, and
 * in virtual time, which stands still meanwhile, waits for poll().
 */
#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/clock.h"
#include "host/console.h"
#include "host/crash.h"
#include "host/wire.h"
#include "kernel/port.h"

enum {
	WRITE_MAX = 4096, /* PIPE_BUF: a pipe that can be written takes this much at once */
	WRITE_RETRY_MS = 10,
	VIRTUAL_WAIT_MS = 10000, /* time stands still, so that a slow reader loses nothing */
	BACKGROUND_MS = 500,
	FINISH_MS = 100,
};

struct stdio {
	bool eof_exits;
	struct loop_source input;
	struct loop_timer input_timer;  /* in the background: the terminal is another's for now */
	struct loop_timer output_timer; /* virtual time */
	struct sink *output;            /* real time */
	struct buffer backlog;
	struct stdio_carried {
		bool is_terminal;
		bool ended; /* input is at its end */
		struct termios settings;
	} kept;
};

static bool in_background(const struct stdio *stdio)
{
	const pid_t group = tcgetpgrp(STDIN_FILENO);

	/* -1: not our controlling terminal, so nobody can stop us for reading it. */
	return stdio->kept.is_terminal && group != -1 && group != getpgrp();
}

/* Nobody but the shell would know what to do with a ^C. */
static bool has_shell(const struct wire *wire)
{
	return strcmp(wire->name, "console") == 0 && isatty(STDOUT_FILENO);
}

static void make_raw(const struct wire *wire)
{
	const struct stdio *stdio = wire->state;
	struct termios raw = stdio->kept.settings;

	cfmakeraw(&raw);
	raw.c_lflag |= ISIG;
	raw.c_oflag |= OPOST | ONLCR;
	if (has_shell(wire)) {
		raw.c_cc[VINTR] = _POSIX_VDISABLE;
	}
	raw.c_cc[VSUSP] = _POSIX_VDISABLE; /* ^Z would leave a stopped light and a raw terminal */
	crash_restore_terminal(STDIN_FILENO, &stdio->kept.settings);
	tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

static void on_end(struct wire *wire)
{
	struct stdio *stdio = wire->state;

	loop_remove(&stdio->input);
	stdio->kept.ended = true;
	if (stdio->eof_exits) {
		port_exit(0);
	}
}

static void read_later(struct stdio *stdio)
{
	loop_remove(&stdio->input);
	loop_timer_start(&stdio->input_timer, BACKGROUND_MS);
}

static void on_input(struct loop_source *source, uint32_t events)
{
	static uint8_t bytes[WIRE_READ];
	struct wire *wire = source->owner;
	struct stdio *stdio = wire->state;
	ssize_t n;

	(void)events;
	if (in_background(stdio)) {
		read_later(stdio);
		return;
	}
	if (wire->paused && (events & (EPOLLHUP | EPOLLERR)) == 0) {
		return;
	}
	n = read(STDIN_FILENO, bytes, sizeof(bytes));
	if (n > 0) {
		wire_received(wire, bytes, (size_t)n);
		wire_received_all(wire);
	} else if (n == 0 || (errno != EINTR && errno != EAGAIN)) {
		on_end(wire);
	}
}

static void start_input(struct wire *wire)
{
	struct stdio *stdio = wire->state;

	if (stdio->kept.ended) {
		return;
	}
	if (in_background(stdio)) {
		read_later(stdio);
		return;
	}
	if (stdio->kept.is_terminal) {
		make_raw(wire);
	}
	stdio->input.fd = STDIN_FILENO;
	stdio->input.ready = on_input;
	stdio->input.owner = wire;
	loop_add(&stdio->input, wire->paused ? 0 : EPOLLIN);
}

static void on_input_timer(struct loop_timer *timer)
{
	start_input(timer->owner);
}

static bool can_write(int timeout_ms)
{
	struct pollfd poll_fd = {.fd = STDOUT_FILENO, .events = POLLOUT};

	return poll(&poll_fd, 1, timeout_ms) > 0;
}

/* What does not fit in the sink waits in the backlog until that is empty. */
static void drain_to_sink(struct stdio *stdio)
{
	struct buffer *backlog = &stdio->backlog;
	size_t length = sink_room(stdio->output);

	length = length < buffer_length(backlog) ? length : buffer_length(backlog);
	if (length > 0 && sink_put(stdio->output, buffer_bytes(backlog), length)) {
		buffer_consume(backlog, length);
	}
}

static void on_sink_drained(void *arg, int error)
{
	struct wire *wire = arg;

	wire->kept.counts.errors += error != 0 ? 1 : 0;
	drain_to_sink(wire->state);
}

static void drain(struct wire *wire, int timeout_ms)
{
	struct stdio *stdio = wire->state;
	struct buffer *backlog = &stdio->backlog;

	if (stdio->output != NULL) {
		drain_to_sink(stdio);
		return;
	}

	while (buffer_length(backlog) > 0 && can_write(timeout_ms)) {
		const size_t length = buffer_length(backlog);
		const ssize_t n = write(STDOUT_FILENO, buffer_bytes(backlog),
		                        length < WRITE_MAX ? length : WRITE_MAX);

		if (n > 0) {
			buffer_consume(backlog, (size_t)n);
		} else if (errno != EINTR && errno != EAGAIN) {
			/* The reader has gone; the light stays. */
			wire->kept.counts.errors++;
			wire_dropped(wire, length);
			buffer_consume(backlog, length);
		}
	}
	if (buffer_length(backlog) > 0) {
		loop_timer_start(&stdio->output_timer, WRITE_RETRY_MS);
	}
}

/* The end or a reset: the last of it. */
static void finish(struct wire *wire)
{
	struct stdio *stdio = wire->state;

	drain(wire, FINISH_MS);
	if (stdio->output != NULL) {
		(void)sink_finish(stdio->output, FINISH_MS);
	}
}

static void on_output_timer(struct loop_timer *timer)
{
	drain(timer->owner, 0);
}

static void send_all(struct wire *wire, const uint8_t *data, const uint32_t *length, size_t count)
{
	struct stdio *stdio = wire->state;
	size_t bytes = 0;

	for (size_t i = 0; i < count; i++) {
		bytes += length[i];
	}
	if (buffer_append(&stdio->backlog, data, bytes, wire_backlog_max())) {
		wire_sent(wire, bytes, count);
	} else {
		wire_dropped(wire, bytes);
	}
	drain(wire, VIRTUAL_WAIT_MS);
}

static void carry_name(char *name, size_t size, const struct wire *wire)
{
	snprintf(name, size, "wire/%s/stdio", wire->name);
}

static void start(struct wire *wire)
{
	struct stdio *stdio = wire->state;
	char name[48];
	size_t size;
	const void *old;

	stdio->input_timer = (struct loop_timer){.fire = on_input_timer, .owner = wire};
	stdio->output_timer = (struct loop_timer){.fire = on_output_timer, .owner = wire};
	if (!clock_is_virtual()) {
		stdio->output = console_output(on_sink_drained, wire);
	}
	carry_name(name, sizeof(name), wire);
	old = carry_get(name, &size);
	if (old != NULL && size == sizeof(stdio->kept)) {
		memcpy(&stdio->kept, old, size);
	} else {
		/* After a reset the terminal is raw already: these are the settings to go back to.
		 */
		stdio->kept.is_terminal = tcgetattr(STDIN_FILENO, &stdio->kept.settings) == 0;
	}
	start_input(wire);
}

static void stop(struct wire *wire)
{
	struct stdio *stdio = wire->state;

	finish(wire);
	loop_timer_stop(&stdio->input_timer);
	loop_timer_stop(&stdio->output_timer);
	loop_remove(&stdio->input);
	buffer_free(&stdio->backlog);
	crash_restore();
}

static void pause_reading(struct wire *wire, bool paused)
{
	struct stdio *stdio = wire->state;

	loop_want(&stdio->input, paused ? 0 : EPOLLIN);
}

static void save(struct wire *wire)
{
	struct stdio *stdio = wire->state;
	char name[48];

	finish(wire);
	carry_name(name, sizeof(name), wire);
	carry_put(name, &stdio->kept, sizeof(stdio->kept));
}

static int parse(struct wire *wire, const char *rest, struct host_error *error)
{
	struct stdio *stdio = wire->state;

	if (rest[0] != '\0' && strcmp(rest, "eof=exit") != 0) {
		return host_error_set(error, "\"stdio:%.40s\": say stdio, or stdio:eof=exit", rest);
	}
	stdio->eof_exits = rest[0] != '\0';
	return 0;
}

const struct wire_type wire_stdio = {
	.scheme = "stdio",
	.syntax = "stdio[:eof=exit]",
	.help = "standard input and output; eof=exit: the end of the input ends the program",
	.state_size = sizeof(struct stdio),
	.parse = parse,
	.start = start,
	.stop = stop,
	.send = send_all,
	.pause = pause_reading,
	.save = save,
};
