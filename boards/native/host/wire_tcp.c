/* SPDX-License-Identifier: Apache-2.0 */
/*
 * tcp:HOST:PORT      connects; connects again whenever that fails or ends
 * tcpin:HOST:PORT    listens; WIRE_PEERS_MAX clients share the wire (host/wire_peers.h)
 */
#include <errno.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/address.h"
#include "host/carry.h"
#include "host/stream.h"

enum {
	CLIENTS_MAX = WIRE_PEERS_MAX,
	VANISHED_S = 10, /* silent for so long, and no answer: gone */
};

struct tcp {
	struct address address;
	struct loop_source waiting;         /* connecting, or listening; fd 0: none */
	struct stream streams[CLIENTS_MAX]; /* tcp: the first only */
};

static void carry_name(char *name, size_t size, const struct wire *wire, int i)
{
	snprintf(name, size, "wire/%s/tcp%d", wire->name, i);
}

static void close_waiting(struct tcp *tcp)
{
	loop_remove(&tcp->waiting);
	if (tcp->waiting.fd != 0) {
		close(tcp->waiting.fd);
		tcp->waiting.fd = 0;
	}
}

static void set_options(int fd)
{
	/* A datagram is to leave at once, not when the next one joins it. */
	setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &(int){1}, sizeof(int));
	/* A peer that vanishes without a word is one that hung up. */
	setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &(int){1}, sizeof(int));
	setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &(int){VANISHED_S}, sizeof(int));
	setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &(int){1}, sizeof(int));
	setsockopt(fd, IPPROTO_TCP, TCP_USER_TIMEOUT, &(int){VANISHED_S * 1000}, sizeof(int));
}

/* 1: resolved; else a retry is on its way. */
static bool resolve(struct wire *wire)
{
	struct tcp *tcp = wire->state;
	int error;

	if (address_resolve(&tcp->address, &error)) {
		return true;
	}
	if (error != 0) {
		wire_error(wire, "host name", error);
	}
	wire_retry(wire);
	return false;
}

static bool restore_streams(struct wire *wire)
{
	struct tcp *tcp = wire->state;
	bool any = false;

	for (int i = 0; i < CLIENTS_MAX; i++) {
		char name[48];

		carry_name(name, sizeof(name), wire, i);
		any |= !tcp->streams[i].open && stream_restore(&tcp->streams[i], name);
	}
	return any;
}

static void init_streams(struct wire *wire, bool shared,
                         void (*closed)(struct stream *stream, int error))
{
	struct tcp *tcp = wire->state;

	for (int i = 0; i < CLIENTS_MAX; i++) {
		tcp->streams[i].wire = wire;
		tcp->streams[i].voice = shared ? i : WIRE_VOICES;
		tcp->streams[i].closed = closed;
	}
}

static void send_all(struct wire *wire, const uint8_t *data, const uint32_t *length, size_t count)
{
	struct tcp *tcp = wire->state;
	size_t bytes = 0;
	bool taken = false;

	for (size_t i = 0; i < count; i++) {
		bytes += length[i];
	}
	for (int i = 0; i < CLIENTS_MAX; i++) {
		taken |= stream_send(&tcp->streams[i], data, bytes);
	}
	if (taken) {
		wire_sent(wire, bytes, count);
	} else {
		wire_dropped(wire, bytes);
	}
}

static void pause_reading(struct wire *wire, bool paused)
{
	struct tcp *tcp = wire->state;

	for (int i = 0; i < CLIENTS_MAX; i++) {
		stream_pause(&tcp->streams[i], paused);
	}
}

static void stop(struct wire *wire)
{
	struct tcp *tcp = wire->state;

	close_waiting(tcp);
	for (int i = 0; i < CLIENTS_MAX; i++) {
		stream_close(&tcp->streams[i]);
	}
	address_stop(&tcp->address);
}

static void save(struct wire *wire)
{
	struct tcp *tcp = wire->state;
	char name[48];

	for (int i = 0; i < CLIENTS_MAX; i++) {
		carry_name(name, sizeof(name), wire, i);
		stream_save(&tcp->streams[i], name);
	}
	snprintf(name, sizeof(name), "wire/%s/listen", wire->name);
	if (wire->type == &wire_tcpin && tcp->waiting.fd != 0) {
		carry_put(name, &tcp->waiting.fd, sizeof(tcp->waiting.fd));
		carry_fd(tcp->waiting.fd);
	}
	address_stop(&tcp->address);
}

static int parse(struct wire *wire, const char *rest, struct host_error *error)
{
	struct tcp *tcp = wire->state;

	return address_parse(&tcp->address, rest, error);
}

/* --- tcp ----------------------------------------------------------------------------------------
 */

static void on_lost(struct stream *stream, int error)
{
	wire_error(stream->wire, "connection", error != 0 ? error : ECONNRESET);
	wire_retry(stream->wire);
}

static void on_connected(struct loop_source *source, uint32_t events)
{
	struct wire *wire = source->owner;
	struct tcp *tcp = wire->state;
	const int fd = source->fd;
	int error = 0;
	socklen_t size = sizeof(error);

	(void)events;
	getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
	if (error != 0) {
		close_waiting(tcp);
		wire_error(wire, "connect", error);
		wire_retry(wire);
		return;
	}
	loop_remove(source);
	source->fd = 0;
	wire_works(wire);
	stream_open(&tcp->streams[0], fd);
}

static void start_client(struct wire *wire)
{
	struct tcp *tcp = wire->state;
	int fd;

	init_streams(wire, false, on_lost);
	if (restore_streams(wire) || !resolve(wire)) {
		return;
	}
	fd = socket(tcp->address.to.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
	if (fd >= 0) {
		set_options(fd);
	}
	if (fd < 0 ||
	    (connect(fd, (const struct sockaddr *)&tcp->address.to, tcp->address.length) != 0 &&
	     errno != EINPROGRESS)) {
		wire_error(wire, "connect", errno);
		wire_retry(wire);
		if (fd >= 0) {
			close(fd);
		}
		return;
	}
	tcp->waiting.fd = fd;
	tcp->waiting.ready = on_connected;
	tcp->waiting.owner = wire;
	loop_add(&tcp->waiting, EPOLLOUT);
}

const struct wire_type wire_tcp = {
	.scheme = "tcp",
	.syntax = "tcp:HOST:PORT",
	.help = "connect, again and again if need be",
	.state_size = sizeof(struct tcp),
	.parse = parse,
	.start = start_client,
	.stop = stop,
	.send = send_all,
	.pause = pause_reading,
	.save = save,
};

/* --- tcpin --------------------------------------------------------------------------------------
 */

/* A client that hangs up is nothing special. */
static void on_hang_up(struct stream *stream, int error)
{
	if (error != 0) {
		stream->wire->kept.counts.errors++;
	}
	wire_peer_leave(stream->wire, stream->voice);
}

static void on_client(struct loop_source *source, uint32_t events)
{
	struct wire *wire = source->owner;
	struct tcp *tcp = wire->state;
	struct sockaddr_storage from = {0};
	socklen_t size = sizeof(from);
	const int fd =
		accept4(source->fd, (struct sockaddr *)&from, &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
	int place;
	int gone;

	(void)events;
	if (fd < 0) {
		if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED) {
			/* Out of descriptors, say: listen anew later, rather than spin. */
			wire_error(wire, "accept", errno);
			close_waiting(tcp);
			wire_retry(wire);
		}
		return;
	}
	place = wire_peer_place(wire, &from, false, true, &gone);
	if (place < 0) {
		wire->kept.counts.errors++;
		close(fd);
		return;
	}
	if (gone >= 0) {
		wire->kept.counts.errors++;
		stream_close(&tcp->streams[gone]);
	}
	set_options(fd);
	stream_open(&tcp->streams[place], fd);
}

static int open_listener(struct wire *wire)
{
	struct tcp *tcp = wire->state;
	char name[48];
	size_t size;
	const void *old;
	int fd;

	snprintf(name, sizeof(name), "wire/%s/listen", wire->name);
	old = carry_get(name, &size);
	if (old != NULL && size == sizeof(fd)) {
		memcpy(&fd, old, sizeof(fd));
		return fd;
	}
	fd = socket(tcp->address.to.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
	if (fd < 0) {
		return -1;
	}
	setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &(int){1}, sizeof(int));
	if (bind(fd, (const struct sockaddr *)&tcp->address.to, tcp->address.length) != 0 ||
	    listen(fd, CLIENTS_MAX) != 0) {
		const int error = errno;

		close(fd);
		errno = error;
		return -1;
	}
	return fd;
}

static void start_server(struct wire *wire)
{
	struct tcp *tcp = wire->state;
	int fd;

	init_streams(wire, true, on_hang_up);
	restore_streams(wire);
	for (int i = 0; i < CLIENTS_MAX; i++) {
		wire->kept.peers[i].present &= tcp->streams[i].open;
	}
	if (!resolve(wire)) {
		return;
	}
	fd = open_listener(wire);
	if (fd < 0) {
		wire_error(wire, "listen", errno);
		wire_retry(wire);
		return;
	}
	wire_works(wire);
	tcp->waiting.fd = fd;
	tcp->waiting.ready = on_client;
	tcp->waiting.owner = wire;
	loop_add(&tcp->waiting, EPOLLIN);
}

static void describe_server(const struct wire *wire, char *text, size_t size)
{
	const struct tcp *tcp = wire->state;
	char own[96];

	if (tcp->waiting.fd == 0) {
		snprintf(text, size, "%s", wire->url);
		return;
	}
	address_print_bound(tcp->waiting.fd, own, sizeof(own));
	snprintf(text, size, "tcpin:%s", own);
}

const struct wire_type wire_tcpin = {
	.scheme = "tcpin",
	.syntax = "tcpin:HOST:PORT",
	.help = "listen; up to 8 clients share the wire",
	.state_size = sizeof(struct tcp),
	.parse = parse,
	.start = start_server,
	.stop = stop,
	.send = send_all,
	.pause = pause_reading,
	.save = save,
	.describe = describe_server,
};
