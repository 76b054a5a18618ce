/* SPDX-License-Identifier: Apache-2.0 */
/*
 * udpin:HOST:PORT      listens; sends to every peer heard in the last WIRE_PEER_TIMEOUT_US,
 *                      WIRE_PEERS_MAX at most (host/wire_peers.h)
 * udpout:HOST:PORT     sends there, receives from there
 * udppair:BIND,SEND    receives on one address from anybody, always sends to the other
 */
#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/address.h"
#include "host/carry.h"
#include "host/clock.h"
#include "host/wire.h"

enum {
	READ_BATCH = 32,
	SINGLES_MAX = 8, /* reads of one datagram before a batch is tried */
	DATAGRAM_MAX = 65536,
	SEND_BATCH = WIRE_BATCH,
	SOCKET_BUFFER = 1 << 20,
};

struct udp {
	struct address bind; /* udpin, udppair */
	struct address send; /* udpout, udppair */
	struct loop_source source;
	unsigned int singles; /* datagrams read one by one since the last batch */
	/* Carried over resets. */
	struct udp_carried {
		int fd; /* 0: none */
	} kept;
};

/* One read at a time: shared by all wires. */
static uint8_t datagrams[READ_BATCH][DATAGRAM_MAX];
static struct mmsghdr message[READ_BATCH];
static struct iovec part[READ_BATCH];
static struct sockaddr_storage senders[READ_BATCH];

/* The sender's place, which it may get by what it says; WIRE_NOBODY: it has none. */
static int place_of(struct wire *wire, const struct sockaddr_storage *from, const uint8_t *data,
                    size_t length)
{
	int place = wire_peer_find(wire, from);
	int gone;

	if (place < 0) {
		place = wire_peer_place(wire, from, wire_peer_is_message(wire, data, length), false,
		                        &gone);
	} else {
		wire->kept.peers[place].heard_us = clock_board_us();
	}
	return place < 0 ? WIRE_NOBODY : place;
}

static void close_socket(struct wire *wire)
{
	struct udp *udp = wire->state;

	loop_remove(&udp->source);
	if (udp->kept.fd != 0) {
		close(udp->kept.fd);
		udp->kept.fd = 0;
	}
}

/* After an error of the socket: refused and unreachable are the peer's, and pass by themselves. */
static void socket_error(struct wire *wire, const char *what, int error)
{
	wire_error(wire, what, error);
	if (error == EBADF || error == ENOTSOCK || error == EINVAL) {
		close_socket(wire);
		wire_retry(wire);
	}
}

static void prepare_messages(void)
{
	for (unsigned int i = 0; i < READ_BATCH; i++) {
		part[i] = (struct iovec){datagrams[i], DATAGRAM_MAX};
		message[i].msg_hdr = (struct msghdr){
			.msg_name = &senders[i],
			.msg_namelen = sizeof(senders[i]),
			.msg_iov = &part[i],
			.msg_iovlen = 1,
		};
	}
}

/*
 * How many datagrams came, or -1. One at a time recvfrom() is the cheapest; every so often a look
 * whether they queue up, and as long as they do, a batch at once.
 */
static int read_batch(struct udp *udp)
{
	if (udp->singles < SINGLES_MAX) {
		socklen_t size = sizeof(senders[0]);
		const ssize_t n = recvfrom(udp->kept.fd, datagrams[0], DATAGRAM_MAX, MSG_DONTWAIT,
		                           (struct sockaddr *)&senders[0], &size);

		message[0].msg_len = (unsigned int)n;
		udp->singles++;
		return n < 0 ? -1 : 1;
	}
	const int n = recvmmsg(udp->kept.fd, message, READ_BATCH, MSG_DONTWAIT, NULL);

	for (int i = 0; i < n; i++) {
		message[i].msg_hdr.msg_namelen = sizeof(senders[i]);
	}
	if (n <= 1) {
		udp->singles = 0;
	}
	return n;
}

static bool read_some(struct loop_source *source)
{
	struct wire *wire = source->owner;
	struct udp *udp = wire->state;
	int n;

	if (wire->paused) {
		return false;
	}
	n = read_batch(udp);
	if (n < 0) {
		if (errno != EAGAIN && errno != EINTR) {
			socket_error(wire, "receive", errno);
		}
		return false;
	}
	for (int i = 0; i < n; i++) {
		const size_t length = message[i].msg_len;

		if (udp->send.host[0] == '\0') {
			wire_received_of(wire, place_of(wire, &senders[i], datagrams[i], length),
			                 datagrams[i], length);
		} else {
			wire_received(wire, datagrams[i], length);
		}
	}
	loop_hot(source);
	wire_works(wire);
	wire_received_all(wire);
	return true;
}

static void on_ready(struct loop_source *source, uint32_t events)
{
	struct wire *wire = source->owner;

	if (!wire->paused) {
		read_some(source);
	} else if ((events & EPOLLERR) != 0) {
		/* Reading takes the error away; epoll would report it without end. */
		int error = 0;
		socklen_t size = sizeof(error);

		getsockopt(source->fd, SOL_SOCKET, SO_ERROR, &error, &size);
		wire_error(wire, "receive", error);
	}
}

static void listen_to(struct wire *wire)
{
	struct udp *udp = wire->state;

	udp->source.fd = udp->kept.fd;
	udp->source.ready = on_ready;
	udp->source.again = read_some;
	prepare_messages();
	udp->source.owner = wire;
	loop_add(&udp->source, wire->paused ? 0 : EPOLLIN);
}

static bool restore(struct wire *wire)
{
	struct udp *udp = wire->state;
	char name[48];
	size_t size;
	const void *old;

	snprintf(name, sizeof(name), "wire/%s/udp", wire->name);
	old = carry_get(name, &size);
	if (old == NULL || size != sizeof(udp->kept)) {
		return false;
	}
	memcpy(&udp->kept, old, size);
	return udp->kept.fd != 0;
}

static int open_socket(struct udp *udp)
{
	const struct address *own = udp->bind.length != 0 ? &udp->bind : NULL;
	const struct address *other = udp->send.length != 0 ? &udp->send : NULL;
	const int family = own != NULL ? own->to.ss_family : other->to.ss_family;
	const int buffer = SOCKET_BUFFER;
	const int fd = socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);

	if (fd < 0) {
		return -1;
	}
	/* Broadcast: a ground station may be addressed as such. Failing is no harm. */
	setsockopt(fd, SOL_SOCKET, SO_BROADCAST, &(int){1}, sizeof(int));
	setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer, sizeof(buffer));
	setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof(buffer));
	if ((own != NULL && bind(fd, (const struct sockaddr *)&own->to, own->length) != 0) ||
	    (own == NULL && connect(fd, (const struct sockaddr *)&other->to, other->length) != 0)) {
		const int error = errno;

		close(fd);
		errno = error;
		return -1;
	}
	return fd;
}

static void start(struct wire *wire)
{
	struct udp *udp = wire->state;
	int error = 0;

	if (restore(wire)) {
		listen_to(wire);
		return;
	}
	if ((udp->bind.host[0] != '\0' && !address_resolve(&udp->bind, &error)) ||
	    (udp->send.host[0] != '\0' && !address_resolve(&udp->send, &error))) {
		if (error != 0) {
			wire_error(wire, "host name", error);
		}
		wire_retry(wire);
		return;
	}
	udp->kept.fd = open_socket(udp);
	if (udp->kept.fd < 0) {
		udp->kept.fd = 0;
		wire_error(wire, "open", errno);
		wire_retry(wire);
		return;
	}
	wire_works(wire);
	listen_to(wire);
}

static void stop(struct wire *wire)
{
	struct udp *udp = wire->state;

	close_socket(wire);
	address_stop(&udp->bind);
	address_stop(&udp->send);
}

static void pause_reading(struct wire *wire, bool paused)
{
	struct udp *udp = wire->state;

	loop_want(&udp->source, paused ? 0 : EPOLLIN);
}

/* Sends messages from `first`; how many went. A pending error of an earlier one costs no datagram.
 */
static size_t send_messages(struct wire *wire, struct mmsghdr *messages, size_t count)
{
	struct udp *udp = wire->state;
	size_t done = 0;
	bool again = true;

	while (done < count && udp->kept.fd != 0) {
		int n;

		if (count - done == 1) {
			const struct msghdr *one = &messages[done].msg_hdr;
			const ssize_t sent =
				sendto(udp->kept.fd, one->msg_iov->iov_base, one->msg_iov->iov_len,
			               MSG_NOSIGNAL, one->msg_name, one->msg_namelen);
			n = sent < 0 ? -1 : 1;
		} else {
			n = sendmmsg(udp->kept.fd, messages + done, (unsigned int)(count - done),
			             MSG_NOSIGNAL);
		}
		if (n > 0) {
			done += (size_t)n;
			again = true;
		} else if (again) {
			/* ECONNREFUSED reports the fate of an earlier datagram and is cleared by
			 * that. */
			again = false;
			if (errno != EINTR) {
				socket_error(wire, "send", errno);
			}
		} else {
			break;
		}
	}
	return done;
}

/* All datagrams to one address (NULL: the connected one); how many went. */
static size_t send_to(struct wire *wire, const struct sockaddr_storage *to, const uint8_t *data,
                      const uint32_t *length, size_t count)
{
	struct mmsghdr messages[SEND_BATCH];
	struct iovec parts[SEND_BATCH];

	for (size_t i = 0; i < count; i++) {
		parts[i] = (struct iovec){(void *)(uintptr_t)data, length[i]};
		data += length[i];
		messages[i].msg_hdr = (struct msghdr){
			.msg_name = (void *)(uintptr_t)to,
			.msg_namelen = to == NULL                  ? 0
		                       : to->ss_family == AF_INET6 ? sizeof(struct sockaddr_in6)
		                                                   : sizeof(struct sockaddr_in),
			.msg_iov = &parts[i],
			.msg_iovlen = 1,
		};
	}
	return send_messages(wire, messages, count);
}

static void send_all(struct wire *wire, const uint8_t *data, const uint32_t *length, size_t count)
{
	struct udp *udp = wire->state;
	size_t sent = 0;
	size_t bytes = 0;
	size_t all = 0;

	if (udp->send.host[0] == '\0') {
		const uint64_t now_us = clock_board_us();

		for (int i = 0; i < WIRE_PEERS_MAX; i++) {
			const struct wire_peer *peer = &wire->kept.peers[i];

			if (peer->present && now_us - peer->heard_us < WIRE_PEER_TIMEOUT_US) {
				const size_t n = send_to(wire, &peer->address, data, length, count);

				sent = n > sent ? n : sent;
			}
		}
	} else {
		sent = send_to(wire, udp->bind.length != 0 ? &udp->send.to : NULL, data, length,
		               count);
	}
	for (size_t i = 0; i < count; i++) {
		bytes += i < sent ? length[i] : 0;
		all += length[i];
	}
	wire_sent(wire, bytes, sent);
	wire_dropped(wire, all - bytes);
}

static void save(struct wire *wire)
{
	struct udp *udp = wire->state;
	char name[48];

	snprintf(name, sizeof(name), "wire/%s/udp", wire->name);
	carry_put(name, &udp->kept, sizeof(udp->kept));
	if (udp->kept.fd != 0) {
		carry_fd(udp->kept.fd);
	}
	address_stop(&udp->bind);
	address_stop(&udp->send);
}

static int parse_in(struct wire *wire, const char *rest, struct host_error *error)
{
	struct udp *udp = wire->state;

	return address_parse(&udp->bind, rest, error);
}

static int parse_out(struct wire *wire, const char *rest, struct host_error *error)
{
	struct udp *udp = wire->state;

	return address_parse(&udp->send, rest, error);
}

static int parse_pair(struct wire *wire, const char *rest, struct host_error *error)
{
	struct udp *udp = wire->state;
	const char *comma = strchr(rest, ',');
	char first[WIRE_URL_MAX];

	if (comma == NULL) {
		return host_error_set(
			error, "udppair:%.60s: say udppair:BIND_HOST:PORT,SEND_HOST:PORT", rest);
	}
	snprintf(first, sizeof(first), "%.*s", (int)(comma - rest), rest);
	if (address_parse(&udp->bind, first, error) != 0) {
		return -1;
	}
	return address_parse(&udp->send, comma + 1, error);
}

static void describe(const struct wire *wire, char *text, size_t size)
{
	const struct udp *udp = wire->state;
	char own[96];

	address_print_bound(udp->kept.fd != 0 ? udp->kept.fd : -1, own, sizeof(own));
	if (udp->bind.host[0] == '\0' || udp->kept.fd == 0) {
		snprintf(text, size, "%s", wire->url);
	} else if (udp->send.host[0] == '\0') {
		snprintf(text, size, "udpin:%s", own);
	} else {
		snprintf(text, size, "udppair:%s,%s:%s", own, udp->send.host, udp->send.port);
	}
}

#define UDP_TYPE(name, form, text, parser)                                                         \
	const struct wire_type wire_##name = {                                                     \
		.scheme = #name,                                                                   \
		.syntax = form,                                                                    \
		.help = text,                                                                      \
		.state_size = sizeof(struct udp),                                                  \
		.parse = parser,                                                                   \
		.start = start,                                                                    \
		.stop = stop,                                                                      \
		.send = send_all,                                                                  \
		.pause = pause_reading,                                                            \
		.save = save,                                                                      \
		.describe = describe,                                                              \
	}

UDP_TYPE(udpin, "udpin:HOST:PORT", "listen; answer every peer heard in the last 60 s, 8 at most",
         parse_in);
UDP_TYPE(udpout, "udpout:HOST:PORT", "send there, receive from there", parse_out);
UDP_TYPE(udppair, "udppair:BIND_HOST:PORT,SEND_HOST:PORT",
         "receive on one address, always send to the other", parse_pair);
