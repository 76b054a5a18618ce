/* SPDX-License-Identifier: Apache-2.0 */
/*
 * pty:LINK            a new pseudo-terminal with a symbolic link to it; programs come and go at its
 * other end serial:DEV,BAUD     a serial port, 8N1, raw; it may be unplugged and come back
 */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/claim.h"
#include "host/options.h"
#include "host/stream.h"

enum {
	SLAVE_POLL_MS = 50
};

struct tty {
	char path[WIRE_URL_MAX]; /* of the link, or of the device */
	uint32_t baud;
	struct stream stream;
	struct tty_carried {
		int master; /* pty; 0: none. The stream has a copy while the slave is open. */
		int claim;  /* on the link; 0: none */
		char slave[32];
	} kept;
	struct loop_timer slave_timer;
};

static void carry_name(char *name, size_t size, const struct wire *wire)
{
	snprintf(name, size, "wire/%s/tty", wire->name);
}

static void send_all(struct wire *wire, const uint8_t *data, const uint32_t *length, size_t count)
{
	struct tty *tty = wire->state;
	size_t bytes = 0;

	for (size_t i = 0; i < count; i++) {
		bytes += length[i];
	}
	if (stream_send(&tty->stream, data, bytes)) {
		wire_sent(wire, bytes, count);
	} else {
		wire_dropped(wire, bytes);
	}
}

static void pause_reading(struct wire *wire, bool paused)
{
	struct tty *tty = wire->state;

	stream_pause(&tty->stream, paused);
}

/* --- pty -----------------------------------------------------------------------------------------
 */

/* Nobody at the other end: what the device writes is lost, as on any UART. epoll would report it
 * without end. */
static void look_for_slave(struct wire *wire)
{
	struct tty *tty = wire->state;
	struct pollfd poll_fd = {.fd = tty->kept.master, .events = POLLIN};

	if (tty->kept.master == 0 || tty->stream.open) {
		return;
	}
	if (poll(&poll_fd, 1, 0) >= 0 && (poll_fd.revents & POLLHUP) == 0) {
		loop_timer_stop(&tty->slave_timer);
		stream_open(&tty->stream,
		            fcntl(tty->kept.master, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
	} else {
		loop_timer_start(&tty->slave_timer, SLAVE_POLL_MS);
	}
}

static void on_slave_timer(struct loop_timer *timer)
{
	look_for_slave(timer->owner);
}

/* The last program closed the slave: the master lives on. */
static void on_slave_closed(struct stream *stream, int error)
{
	(void)error;
	look_for_slave(stream->wire);
}

/* Before the link of another light would be taken for one that was left. */
static bool claim_link(struct tty *tty)
{
	if (tty->kept.claim == 0) {
		const int claim = claim_name(tty->path);

		tty->kept.claim = claim < 0 ? 0 : claim;
	}
	return tty->kept.claim != 0;
}

static void remove_link(const struct tty *tty)
{
	char target[sizeof(tty->kept.slave)] = "";

	if (readlink(tty->path, target, sizeof(target) - 1) > 0 &&
	    strcmp(target, tty->kept.slave) == 0) {
		unlink(tty->path);
	}
}

static int open_pty(struct tty *tty)
{
	struct termios settings;
	struct stat status;
	int master;
	int slave;

	if (openpty(&master, &slave, NULL, NULL, NULL) != 0) {
		return -1;
	}
	tcgetattr(slave, &settings);
	cfmakeraw(&settings);
	tcsetattr(slave, TCSANOW, &settings);
	ttyname_r(slave, tty->kept.slave, sizeof(tty->kept.slave));
	close(slave);
	fcntl(master, F_SETFD, FD_CLOEXEC);
	fcntl(master, F_SETFL, O_RDWR | O_NONBLOCK);
	/* A link left by an earlier run is replaced; anything else is somebody's file. */
	if (lstat(tty->path, &status) == 0 && S_ISLNK(status.st_mode)) {
		unlink(tty->path);
	}
	if (symlink(tty->kept.slave, tty->path) != 0) {
		const int error = errno;

		close(master);
		errno = error;
		return -1;
	}
	return master;
}

static void pty_start(struct wire *wire)
{
	struct tty *tty = wire->state;
	char name[48];
	size_t size;
	const void *old;

	tty->stream.wire = wire;
	tty->stream.voice = WIRE_VOICES;
	tty->stream.closed = on_slave_closed;
	tty->slave_timer.fire = on_slave_timer;
	tty->slave_timer.owner = wire;
	snprintf(name, sizeof(name), "wire/%s/master", wire->name);
	old = carry_get(name, &size);
	if (old != NULL && size == sizeof(tty->kept)) {
		memcpy(&tty->kept, old, size);
		carry_name(name, sizeof(name), wire);
		stream_restore(&tty->stream, name);
	} else {
		tty->kept.master = claim_link(tty) ? open_pty(tty) : -1;
	}
	if (tty->kept.master < 0) {
		tty->kept.master = 0;
		wire_error(wire, "open", errno);
		wire_retry(wire);
		return;
	}
	wire_works(wire);
	look_for_slave(wire);
}

static void pty_stop(struct wire *wire)
{
	struct tty *tty = wire->state;

	loop_timer_stop(&tty->slave_timer);
	stream_close(&tty->stream);
	if (tty->kept.master != 0) {
		remove_link(tty);
		close(tty->kept.master);
		tty->kept.master = 0;
	}
}

static void pty_save(struct wire *wire)
{
	struct tty *tty = wire->state;
	char name[48];

	if (tty->kept.master == 0) {
		return;
	}
	snprintf(name, sizeof(name), "wire/%s/master", wire->name);
	carry_put(name, &tty->kept, sizeof(tty->kept));
	carry_fd(tty->kept.master);
	carry_fd(tty->kept.claim);
	carry_name(name, sizeof(name), wire);
	stream_save(&tty->stream, name);
}

static int pty_parse(struct wire *wire, const char *rest, struct host_error *error)
{
	struct tty *tty = wire->state;

	if (rest[0] == '\0') {
		return host_error_set(error, "the link's path is missing; say pty:/tmp/light");
	}
	strcpy(tty->path, rest);
	return 0;
}

const struct wire_type wire_pty = {
	.scheme = "pty",
	.syntax = "pty:LINK",
	.help = "a new pseudo-terminal, with a symbolic link to it",
	.state_size = sizeof(struct tty),
	.parse = pty_parse,
	.start = pty_start,
	.stop = pty_stop,
	.send = send_all,
	.pause = pause_reading,
	.poke = look_for_slave,
	.save = pty_save,
};

/* --- serial --------------------------------------------------------------------------------------
 */

static const struct {
	uint32_t baud;
	speed_t speed;
} speeds[] = {
	{1200, B1200},       {2400, B2400},       {4800, B4800},       {9600, B9600},
	{19200, B19200},     {38400, B38400},     {57600, B57600},     {115200, B115200},
	{230400, B230400},   {460800, B460800},   {500000, B500000},   {576000, B576000},
	{921600, B921600},   {1000000, B1000000}, {1152000, B1152000}, {1500000, B1500000},
	{2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000}, {3500000, B3500000},
	{4000000, B4000000},
};

static bool find_speed(uint32_t baud, speed_t *speed)
{
	for (size_t i = 0; i < sizeof(speeds) / sizeof(speeds[0]); i++) {
		if (speeds[i].baud == baud) {
			*speed = speeds[i].speed;
			return true;
		}
	}
	return false;
}

static int apply_baud(int fd, uint32_t baud)
{
	struct termios settings;
	speed_t speed;

	if (!find_speed(baud, &speed)) {
		return -EINVAL;
	}
	if (tcgetattr(fd, &settings) != 0) {
		return -errno;
	}
	cfmakeraw(&settings);
	settings.c_cflag &= ~(tcflag_t)(CSTOPB | PARENB | CRTSCTS);
	settings.c_cflag |= CLOCAL | CREAD;
	settings.c_cc[VMIN] = 1;
	settings.c_cc[VTIME] = 0;
	cfsetspeed(&settings, speed);
	return tcsetattr(fd, TCSANOW, &settings) == 0 ? 0 : -errno;
}

static int serial_set_baud(struct wire *wire, uint32_t baud)
{
	struct tty *tty = wire->state;
	speed_t speed;

	if (!find_speed(baud, &speed)) {
		return -EINVAL;
	}
	tty->baud = baud;
	return tty->stream.open ? apply_baud(tty->stream.source.fd, baud) : 0;
}

static void on_unplugged(struct stream *stream, int error)
{
	wire_error(stream->wire, "read", error != 0 ? error : ENODEV);
	wire_retry(stream->wire);
}

static void serial_start(struct wire *wire)
{
	struct tty *tty = wire->state;
	char name[48];
	int error;
	int fd;

	tty->stream.wire = wire;
	tty->stream.voice = WIRE_VOICES;
	tty->stream.closed = on_unplugged;
	carry_name(name, sizeof(name), wire);
	if (stream_restore(&tty->stream, name)) {
		return;
	}
	fd = open(tty->path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
	error = fd < 0 ? -errno : claim_file(fd) != 0 ? -EBUSY : apply_baud(fd, tty->baud);
	if (error != 0) {
		wire_error(wire, "open", -error);
		wire_retry(wire);
		if (fd >= 0) {
			close(fd);
		}
		return;
	}
	wire_works(wire);
	tcflush(fd, TCIOFLUSH);
	stream_open(&tty->stream, fd);
}

static void serial_stop(struct wire *wire)
{
	struct tty *tty = wire->state;

	stream_close(&tty->stream);
}

static void serial_save(struct wire *wire)
{
	struct tty *tty = wire->state;
	char name[48];

	carry_name(name, sizeof(name), wire);
	stream_save(&tty->stream, name);
}

static int serial_parse(struct wire *wire, const char *rest, struct host_error *error)
{
	struct tty *tty = wire->state;
	const char *comma = strrchr(rest, ',');
	struct host_error reason;
	uint64_t baud;
	speed_t speed;

	if (comma == NULL || comma == rest) {
		return host_error_set(error,
		                      "serial:%.60s: say serial:DEV,BAUD, such as "
		                      "serial:/dev/ttyUSB0,57600",
		                      rest);
	}
	if (parse_number(comma + 1, 1, 4000000, &baud, &reason) != 0 ||
	    !find_speed((uint32_t)baud, &speed)) {
		return host_error_set(error, "\"%.20s\" is no standard baud rate, such as 57600",
		                      comma + 1);
	}
	snprintf(tty->path, sizeof(tty->path), "%.*s", (int)(comma - rest), rest);
	tty->baud = (uint32_t)baud;
	return 0;
}

const struct wire_type wire_serial = {
	.scheme = "serial",
	.syntax = "serial:DEV,BAUD",
	.help = "a serial port, 8N1; it may be unplugged and come back",
	.state_size = sizeof(struct tty),
	.parse = serial_parse,
	.start = serial_start,
	.stop = serial_stop,
	.send = send_all,
	.pause = pause_reading,
	.save = serial_save,
	.set_baud = serial_set_baud,
};
