/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --gpio gpiochip:…: lines of the board (models/board.h) that are lines of a real chip.
 *
 * Outputs follow the board at once. Inputs drive it, each edge with the kernel's time of it. A chip
 * that goes away counts as a fault of the lamp's driver until it is back.
 */
#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "gpio_libgpiod.h"
#include "host/carry.h"
#include "host/clock.h"
#include "host/control.h"
#include "host/guard.h"
#include "host/hardware.h"
#include "host/loop.h"
#include "host/module.h"
#include "host/say.h"
#include "host/sysfs.h"
#include "models/board.h"

enum {
	PATH_SIZE = 96,
	RETRY_MIN_MS = 100,
	RETRY_MAX_MS = 5000,
	CHECK_MS = 500,    /* a chip without inputs does not say that it goes */
	KERNEL_QUEUE = 16, /* edges per line; the kernel drops further ones */
	GUARD_TRIES = 250, /* for the guard of a light that was killed just now to end */
	GUARD_TRY_US = 20000,
	EXIT_OPTION = 2,
};

enum role {
	ROLE_ENABLE,
	ROLE_STROBE,
	ROLE_SYNC,
	ROLE_BUTTON,
	ROLE_FAULT,
	ROLE_COUNT,
};

#define NO_LINE UINT32_MAX

/* Outputs are pulled down where the chip can: what it falls back to when the process is gone. */
static const struct {
	const char *name;
	uint32_t line; /* of the board; NO_LINE: the light itself */
	bool output;
	enum gpiochip_pull pull;
} roles[ROLE_COUNT] = {
	[ROLE_ENABLE] = {"enable", BOARD_LINE_LAMP_ENABLE, true, GPIOCHIP_PULL_DOWN},
	[ROLE_STROBE] = {"strobe", NO_LINE, true, GPIOCHIP_PULL_DOWN},
	[ROLE_SYNC] = {"sync", BOARD_LINE_SYNC, false, GPIOCHIP_PULL_NONE},
	[ROLE_BUTTON] = {"button", BOARD_LINE_BUTTON, false, GPIOCHIP_PULL_UP},
	[ROLE_FAULT] = {"fault", BOARD_LINE_DRIVER_FAULT, false, GPIOCHIP_PULL_UP},
};

struct mapped {
	struct gpiochip_line *line; /* NULL: not mapped, or the chip is away */
	struct loop_source source;  /* inputs */
	unsigned int offset;
	unsigned int burst; /* edges since the queue was last empty */
	bool level;
};

/* From the command line. */
static char path[PATH_SIZE]; /* empty: --gpio sim */
static char wanted[ROLE_COUNT][GPIOCHIP_NAME_SIZE];

static struct gpiochip *chip; /* NULL: away */
static struct mapped mapped[ROLE_COUNT];
static struct guard_output guarded;
static bool is_ours; /* a line was in use, by another light or its guard */
static struct loop_timer check;
static struct loop_timer retry;
static uint32_t retry_ms;

/* Carried over resets. The counts are since power-on. */
static struct {
	bool away; /* the device knows that the chip is: as a fault of the lamp's driver */
	uint64_t edges;
	uint64_t missed; /* times that the kernel has not told of every edge */
	uint64_t losses;
} kept;

static int64_t now_us(void)
{
	return (int64_t)clock_board_us();
}

/* --- opening ------------------------------------------------------------------------------------
 */

static int find_line(struct gpiochip *from, const char *text, unsigned int *offset,
                     struct host_error *error)
{
	const unsigned int count = gpiochip_line_count(from);
	struct host_error ignored;
	struct gpiochip_info info;
	uint64_t number;

	for (*offset = 0; *offset < count; (*offset)++) {
		if (gpiochip_describe(from, *offset, &info) == 0 && strcmp(info.name, text) == 0) {
			return 0;
		}
	}
	if (count > 0 && parse_number(text, 0, count - 1, &number, &ignored) == 0) {
		*offset = (unsigned int)number;
		return 0;
	}
	return host_error_set(error, "%s has no line \"%s\"; its lines are 0 to %u and their names",
	                      path, text, count > 0 ? count - 1 : 0);
}

static int request_error(struct gpiochip *from, enum role role, unsigned int offset, int cause,
                         struct host_error *error)
{
	struct gpiochip_info info = {0};

	if (cause != EBUSY) {
		return host_error_set(error, "%s: line %s of %s: %s", roles[role].name,
		                      wanted[role], path, strerror(cause));
	}
	(void)gpiochip_describe(from, offset, &info);
	is_ours = strcmp(info.consumer, GPIOCHIP_CONSUMER) == 0;
	return host_error_set(error, "%s: line %s of %s is in use by %s", roles[role].name,
	                      wanted[role], path, info.consumer[0] != '\0' ? info.consumer : "?");
}

static bool output_level(enum role role)
{
	if (roles[role].line == NO_LINE) {
		return board.lamp.level_ppm > 0;
	}
	/* what the firmware drives; what the control socket does is the model's */
	return (board.lines.output & board.lines.output_level & (1u << roles[role].line)) != 0;
}

static int request_line(struct gpiochip *from, enum role role, struct host_error *error)
{
	struct mapped *to = &mapped[role];

	if (find_line(from, wanted[role], &to->offset, error) != 0) {
		return -1;
	}
	for (int other = 0; other < (int)role; other++) {
		if (mapped[other].line != NULL && mapped[other].offset == to->offset) {
			return host_error_set(error, "%s and %s are the same line of %s",
			                      roles[other].name, roles[role].name, path);
		}
	}
	to->burst = 0;
	to->level = roles[role].output && output_level(role);
	to->line = roles[role].output
	                   ? gpiochip_output(from, to->offset, to->level, roles[role].pull)
	                   : gpiochip_input(from, to->offset, roles[role].pull);
	return to->line != NULL ? 0 : request_error(from, role, to->offset, errno, error);
}

static void close_all(struct gpiochip *from)
{
	for (int role = 0; role < ROLE_COUNT; role++) {
		loop_remove(&mapped[role].source);
		mapped[role].line = NULL;
	}
	gpiochip_close(from);
	if (guarded.is_open) {
		guarded.is_open = false;
		(void)guard_renew(); /* what else there is to guard */
	}
}

static void drive(enum role role, bool level, int64_t edge_us)
{
	mapped[role].level = level;
	board_line_drive_late(now_us(), roles[role].line, level, edge_us);
}

static void on_edge(struct loop_source *source, uint32_t events);

/* In the guard. */
static void make_safe(void)
{
	for (int role = 0; role < ROLE_COUNT; role++) {
		if (mapped[role].line != NULL && roles[role].output) {
			(void)gpiochip_set(mapped[role].line, false);
		}
	}
}

/* Lines are anonymous inodes of the kernel: gpio-line, gpio-linehandle. */
static bool keeps(int fd, const char *target)
{
	(void)fd;
	return strstr(target, "gpio-line") != NULL;
}

static int start_guard(struct host_error *error)
{
	int rc;

	guarded.is_open = mapped[ROLE_ENABLE].line != NULL || mapped[ROLE_STROBE].line != NULL;
	rc = guarded.is_open ? guard_renew() : 0;
	return rc == 0 ? 0
	               : host_error_set(error, "no process to guard the lamp: %s", strerror(-rc));
}

/* Requesting an output makes it safe, so --off goes on after one that fails; inputs are not its. */
static int request_lines(struct gpiochip *from, struct host_error *error)
{
	int rc = 0;

	for (int role = 0; role < ROLE_COUNT; role++) {
		if (wanted[role][0] == '\0' || (hardware_is_only_off() && !roles[role].output)) {
			continue;
		}
		if (request_line(from, (enum role)role, error) != 0) {
			rc = -1;
		}
		if (rc != 0 && !hardware_is_only_off()) {
			break;
		}
	}
	return rc;
}

/* All lines or none. */
static int open_chip(struct host_error *error)
{
	struct gpiochip *opened = gpiochip_open(path);

	if (opened == NULL) {
		return errno == ENOTSUP ? host_error_set(error, "%s: %s", path, gpiochip_backend())
		                        : host_error_set(error, "%s: %s", path, strerror(errno));
	}
	if (request_lines(opened, error) != 0 || start_guard(error) != 0) {
		close_all(opened);
		return -1;
	}
	chip = opened;
	loop_timer_start(&check, CHECK_MS);
	for (int role = 0; role < ROLE_COUNT; role++) {
		struct mapped *input = &mapped[role];

		if (input->line != NULL && !roles[role].output) {
			input->source.fd = gpiochip_fd(input->line);
			input->source.ready = on_edge;
			input->source.owner = input;
			loop_add(&input->source, EPOLLIN);
			drive((enum role)role, gpiochip_get(input->line) == 1, now_us());
		}
	}
	return 0;
}

/* --- losing the chip, and finding it again ------------------------------------------------------
 */

static void set_away(bool away)
{
	kept.away = away;
	if (away) {
		board_line_drive(now_us(), BOARD_LINE_DRIVER_FAULT, false);
	} else if (mapped[ROLE_FAULT].line == NULL) {
		board_line_release(now_us(), BOARD_LINE_DRIVER_FAULT);
	}
}

/* Any context: the device is told later, from the loop. */
static void lose(int error)
{
	host_say("gpio: %s is lost: %s; trying again", path, strerror(error));
	loop_timer_stop(&check);
	close_all(chip);
	chip = NULL;
	kept.losses++;
	retry_ms = 0;
	loop_timer_start(&retry, 0);
}

static void on_check(struct loop_timer *timer)
{
	for (int role = 0; role < ROLE_COUNT; role++) {
		if (mapped[role].line != NULL) {
			const int level = gpiochip_get(mapped[role].line);

			if (level < 0) {
				lose(-level);
				return;
			}
		}
	}
	loop_timer_start(timer, CHECK_MS);
}

static void on_retry(struct loop_timer *timer)
{
	struct host_error error;

	if (!kept.away) {
		set_away(true);
	} else if (open_chip(&error) == 0) {
		set_away(false);
		host_say("gpio: %s is back", path);
		return;
	}
	retry_ms = retry_ms == 0 ? RETRY_MIN_MS : 2 * retry_ms;
	if (retry_ms > RETRY_MAX_MS) {
		retry_ms = RETRY_MAX_MS;
	}
	loop_timer_start(timer, retry_ms);
}

/* --- running ------------------------------------------------------------------------------------
 */

/* The board's outputs have changed, perhaps. */
static void follow(void)
{
	for (int role = 0; role < ROLE_COUNT; role++) {
		struct mapped *output = &mapped[role];
		bool level;
		int rc;

		if (output->line == NULL || !roles[role].output) {
			continue;
		}
		level = output_level((enum role)role);
		if (level == output->level) {
			continue;
		}
		output->level = level;
		rc = gpiochip_set(output->line, level);
		if (rc != 0) {
			lose(-rc);
			return;
		}
	}
}

/* The kernel's queue was full and is read: edges are missing, perhaps the last ones. */
static void resync(enum role role)
{
	const int level = gpiochip_get(mapped[role].line);

	if (level < 0) {
		lose(-level);
	} else if (mapped[role].level != (level == 1)) {
		kept.missed++;
		drive(role, level == 1, now_us());
	}
}

static bool is_readable(int fd)
{
	struct pollfd poll_fd = {.fd = fd, .events = POLLIN};

	return poll(&poll_fd, 1, 0) == 1;
}

/* One edge at a time, so that each is an interrupt of its own. */
static void on_edge(struct loop_source *source, uint32_t events)
{
	struct mapped *input = source->owner;
	const enum role role = (enum role)(input - mapped);
	struct gpiochip_edge edge;
	int64_t edge_us;
	int rc;

	if ((events & EPOLLIN) == 0) {
		lose(ENODEV); /* hung up */
		return;
	}
	rc = gpiochip_read(input->line, &edge);
	if (rc != 0) {
		if (rc != -EAGAIN && rc != -EINTR) {
			lose(-rc);
		}
		return;
	}
	kept.edges++;
	kept.missed += edge.level == input->level ? 1 : 0;
	edge_us = (int64_t)clock_board_of_host_us(edge.time_ns);
	drive(role, edge.level, edge_us < now_us() ? edge_us : now_us());
	input->burst++;
	if (is_readable(source->fd)) {
		return;
	}
	if (input->burst >= KERNEL_QUEUE) {
		resync(role);
	}
	input->burst = 0;
}

/* --- the module ---------------------------------------------------------------------------------
 */

static int parse_line(char *word, struct host_error *error)
{
	char *equals = strchr(word, '=');

	if (equals != NULL) {
		*equals = '\0';
	}
	for (int role = 0; role < ROLE_COUNT; role++) {
		if (strcmp(word, roles[role].name) != 0) {
			continue;
		}
		if (equals == NULL || equals[1] == '\0' ||
		    strlen(equals + 1) >= sizeof(wanted[0])) {
			return host_error_set(error, "%s needs a line: %s=NAME or %s=NUMBER", word,
			                      word, word);
		}
		if (wanted[role][0] != '\0') {
			return host_error_set(error, "%s is given twice", word);
		}
		strcpy(wanted[role], equals + 1);
		return 0;
	}
	return host_error_set(error,
	                      "\"%.40s\" is no use for a line; enable, strobe, sync, button and "
	                      "fault are",
	                      word);
}

static int parse_gpio(const char *value, struct host_error *error)
{
	char text[PATH_SIZE + ROLE_COUNT * (GPIOCHIP_NAME_SIZE + 16)];
	char *rest = text;
	char *word;

	path[0] = '\0';
	memset(wanted, 0, sizeof(wanted));
	if (strcmp(value, "sim") == 0) {
		return 0;
	}
	if (strncmp(value, "gpiochip:", 9) != 0) {
		return host_error_set(error, "\"%.60s\" is neither sim nor gpiochip:PATH,USE=LINE",
		                      value);
	}
	if (strlen(value + 9) >= sizeof(text)) {
		return host_error_set(error, "longer than %zu characters", sizeof(text) - 1);
	}
	strcpy(text, value + 9);
	word = strsep(&rest, ",");
	if (word[0] == '\0' || strlen(word) >= sizeof(path)) {
		return host_error_set(error, "gpiochip: needs a device such as /dev/gpiochip0");
	}
	if (rest == NULL) {
		return host_error_set(error, "gpiochip:%s needs a line: ,enable=LINE", word);
	}
	strcpy(path, word);
	while ((word = strsep(&rest, ",")) != NULL) {
		if (parse_line(word, error) != 0) {
			return -1;
		}
	}
	return 0;
}

static int start(void)
{
	struct host_error error;
	bool opened = false;

	carry_register("gpio", &kept, sizeof(kept));
	if (path[0] == '\0') {
		return 0;
	}
	if (clock_is_virtual()) {
		fprintf(stderr, "pharos: --gpio: a real chip needs --time real\n");
		return EXIT_OPTION;
	}
	if (wanted[ROLE_ENABLE][0] != '\0' || wanted[ROLE_STROBE][0] != '\0') {
		if (!sysfs_is_real() && !hardware_is_only_off()) {
			fprintf(stderr, "pharos: --gpio: a real lamp does not go with --sysfs: its "
			                "files are no sensor\n");
			return EXIT_OPTION;
		}
		hardware_lamp("--gpio");
	}
	guarded.make_safe = make_safe;
	guarded.keeps = keeps;
	guard_add(&guarded);
	check.fire = on_check;
	retry.fire = on_retry;
	board_outside = follow;
	for (int i = 0; !opened && (i == 0 || (is_ours && i < GUARD_TRIES)); i++) {
		if (i > 0) {
			usleep(GUARD_TRY_US);
		}
		is_ours = false;
		opened = open_chip(&error) == 0;
	}
	if (opened) {
		if (kept.away) {
			set_away(false);
		}
		return 0;
	}
	if (carry_is_reset()) {
		lose(ENODEV);
		return 0;
	}
	fprintf(stderr, "pharos: --gpio: %s\n", error.text);
	return EXIT_OPTION;
}

static void stop(void)
{
	loop_timer_stop(&check);
	loop_timer_stop(&retry);
	board_outside = NULL;
	close_all(chip);
	chip = NULL;
}

static enum control_result run_gpiochip(struct control_call *call)
{
	json_t *lines = json_object();

	for (int role = 0; role < ROLE_COUNT; role++) {
		if (wanted[role][0] != '\0') {
			control_put_integer(lines, roles[role].name, mapped[role].level);
		}
	}
	control_put_string(call->reply, "backend", gpiochip_backend());
	control_put_string(call->reply, "path", path);
	control_put_bool(call->reply, "present", chip != NULL);
	json_object_set_new(call->reply, "lines", lines);
	control_put_integer(call->reply, "edges", (int64_t)kept.edges);
	control_put_integer(call->reply, "missed", (int64_t)kept.missed);
	control_put_integer(call->reply, "losses", (int64_t)kept.losses);
	return CONTROL_OK;
}

static const struct host_option options[] = {
	{"gpio", "LINES",
         "where the board's lines are (sim); LINES is one of these:\n"
         "sim                  lines of the model; the control socket drives them\n"
         "gpiochip:DEVICE,USE=LINE,USE=LINE…\n"
         "                     a chip such as /dev/gpiochip0; LINE is a name or a\n"
         "                     number; USE: enable (out: the lamp), strobe (out: the\n"
         "                     same, for others), sync, button and fault (in; the\n"
         "                     last two: low is active)",
         parse_gpio},
	{0},
};

static const struct control_op ops[] = {
	{"gpiochip",
         "the real chip behind --gpio: backend, path, present, level of each line; edges read, "
         "missed ones, losses",
         run_gpiochip},
	{0},
};

HOST_MODULE(gpio_module) = {
	.name = "gpio",
	.order = HOST_ORDER_BOARD + 1,
	.drives = true,
	.options = options,
	.ops = ops,
	.start = start,
	.stop = stop,
};
