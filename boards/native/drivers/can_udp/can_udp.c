/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A CAN bus in user space: one UDP datagram per frame, multicast or broadcast on loopback, for many
 * processes, without a broker and without root. One socket hears the bus (shared port), another one
 * speaks: its port is how a node knows its own frames.
 *
 * Groups and port are those of `mcast:N` in PyPI's dronecan, the DroneCAN GUI Tool and ArduPilot's
 * simulator. These join and send wherever the system's route to the group leads, a network too;
 * this driver sends on loopback, and hears this machine only.
 */
#include <arpa/inet.h>
#include <errno.h>
#include <linux/filter.h>
#include <linux/if_packet.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "../can_host/can_bus.h"
#include "can_udp_frame.h"
#include "host/carry.h"
#include "host/clock.h"
#include "host/options.h"
#include "host/say.h"

#define PORT      57732
#define BROADCAST "127.255.255.255"
#define GROUP     "239.65.82."

enum {
	BUS_MAX = 255,
	READ_BATCH = 32,
	SOCKET_BUFFER = 4 << 20,
	BUSY_MS = 1000, /* virtual time: how long the host may take for one datagram */
};

struct can_udp {
	struct can_bus *bus;
	struct sockaddr_in target;
	struct loop_source source;
	struct loop_source sender; /* waits for room */
	/* carried */
	struct kept {
		int receiver_fd; /* 0: none */
		int sender_fd;
		uint16_t own_port; /* network order */
		bool filtered;     /* filter() works; then `looped`: */
		uint64_t looped;   /* own datagrams, which the kernel counts as drops */
	} kept;
};

static uint8_t datagrams[READ_BATCH][CAN_UDP_MAX + 1];
static struct mmsghdr messages[READ_BATCH];
static struct sockaddr_in senders[READ_BATCH];

/* --- the option ------------------------------------------------------------------------------ */

static bool is_multicast(const struct can_udp *udp)
{
	return IN_MULTICAST(ntohl(udp->target.sin_addr.s_addr));
}

/* Broadcast of loopback, or any multicast group: frames stay on this machine. */
static int parse_address(struct can_udp *udp, char *text, struct host_error *error)
{
	char *colon = strrchr(text, ':');
	struct host_error reason;
	uint64_t port;

	*colon = '\0';
	if (inet_pton(AF_INET, text, &udp->target.sin_addr) != 1 ||
	    (!is_multicast(udp) && ntohl(udp->target.sin_addr.s_addr) >> 24 != IN_LOOPBACKNET)) {
		return host_error_set(
			error, "\"%.40s\" is neither " BROADCAST " nor a multicast address", text);
	}
	if (parse_number(colon + 1, 1, UINT16_MAX, &port, &reason) != 0) {
		return host_error_set(error, "port: %.200s", reason.text);
	}
	udp->target.sin_port = htons((uint16_t)port);
	return 0;
}

static int parse(struct can_bus *bus, const char *rest, struct host_error *error)
{
	struct can_udp *udp = bus->state;
	char text[CAN_BUS_URL_MAX];
	char group[INET_ADDRSTRLEN];
	struct host_error reason;
	uint64_t number = 0;

	udp->bus = bus;
	udp->target.sin_family = AF_INET;
	strcpy(text, rest);
	if (strchr(text, ':') != NULL) {
		return parse_address(udp, text, error);
	}
	if (text[0] == ',') {
		return host_error_set(error, "\"%.40s\": say udp[:N][,paced]", bus->url);
	}
	if (text[0] != '\0' && parse_number(text, 0, BUS_MAX, &number, &reason) != 0) {
		return host_error_set(error, "bus: %.200s", reason.text);
	}
	snprintf(group, sizeof(group), GROUP "%u", (unsigned int)number);
	inet_pton(AF_INET, group, &udp->target.sin_addr);
	udp->target.sin_port = htons(PORT);
	return 0;
}

static void describe(const struct can_bus *bus, char *text, size_t size)
{
	const struct can_udp *udp = bus->state;
	char address[INET_ADDRSTRLEN];

	inet_ntop(AF_INET, &udp->target.sin_addr, address, sizeof(address));
	snprintf(text, size, "udp:%s:%u%s", address, (unsigned int)ntohs(udp->target.sin_port),
	         bus->paced ? ",paced" : "");
}

/* --- failure --------------------------------------------------------------------------------- */

static void close_sockets(struct can_udp *udp)
{
	loop_remove(&udp->source);
	loop_remove(&udp->sender);
	if (udp->kept.receiver_fd > 0) {
		close(udp->kept.receiver_fd);
	}
	if (udp->kept.sender_fd > 0) {
		close(udp->kept.sender_fd);
	}
	udp->kept = (struct kept){0};
}

static void fail(struct can_udp *udp, const char *what, int error)
{
	close_sockets(udp);
	can_bus_error(udp->bus, what, error);
	can_bus_retry(udp->bus);
}

/* --- hearing --------------------------------------------------------------------------------- */

static int read_batch(struct can_udp *udp)
{
	struct iovec parts[READ_BATCH];

	for (size_t i = 0; i < READ_BATCH; i++) {
		parts[i] = (struct iovec){datagrams[i], sizeof(datagrams[i])};
		messages[i].msg_hdr = (struct msghdr){
			.msg_name = &senders[i],
			.msg_namelen = sizeof(senders[i]),
			.msg_iov = &parts[i],
			.msg_iovlen = 1,
		};
	}
	return recvmmsg(udp->kept.receiver_fd, messages, READ_BATCH, MSG_DONTWAIT, NULL);
}

static bool read_some(struct loop_source *source)
{
	struct can_udp *udp = source->owner;
	struct can_host_event event = {.kind = CAN_HOST_FRAME};
	int n;

	if (udp->bus->paused) {
		return false;
	}
	n = read_batch(udp);
	if (n < 0) {
		if (errno != EAGAIN && errno != EINTR) {
			fail(udp, "receive", errno);
		}
		return false;
	}
	for (int i = 0; i < n; i++) {
		if (senders[i].sin_port == udp->kept.own_port) {
			continue;
		}
		if (can_udp_decode(datagrams[i], messages[i].msg_len, &event.frame)) {
			can_bus_received(udp->bus, &event);
		} else {
			can_bus_malformed(udp->bus);
		}
	}
	loop_hot(source);
	can_bus_received_all(udp->bus);
	return true;
}

static void on_readable(struct loop_source *source, uint32_t events)
{
	(void)events;
	read_some(source);
}

static void pause_reading(struct can_bus *bus, bool paused)
{
	struct can_udp *udp = bus->state;

	loop_want(&udp->source, paused ? 0 : EPOLLIN);
}

static void count_drops(struct can_bus *bus)
{
	struct can_udp *udp = bus->state;
	uint32_t memory[SK_MEMINFO_VARS] = {0};
	socklen_t size = sizeof(memory);
	uint64_t drops;

	if (udp->kept.receiver_fd <= 0 ||
	    getsockopt(udp->kept.receiver_fd, SOL_SOCKET, SO_MEMINFO, memory, &size) != 0) {
		return;
	}
	drops = memory[SK_MEMINFO_DROPS];
	bus->kept.counts.rx_drops = drops > udp->kept.looped ? drops - udp->kept.looped : 0;
}

/* --- speaking -------------------------------------------------------------------------------- */

static void on_writable(struct loop_source *source, uint32_t events)
{
	struct can_udp *udp = source->owner;

	(void)events;
	loop_want(source, 0);
	can_bus_ready(udp->bus);
}

static enum can_host_result send_frame(struct can_bus *bus, const struct can_host_frame *frame)
{
	struct can_udp *udp = bus->state;
	uint8_t datagram[CAN_UDP_MAX];
	const size_t length = can_udp_encode(frame, datagram);

	if (udp->kept.sender_fd <= 0) {
		return CAN_HOST_NOBODY;
	}
	while (sendto(udp->kept.sender_fd, datagram, length, MSG_NOSIGNAL | MSG_DONTWAIT,
	              (const struct sockaddr *)&udp->target, sizeof(udp->target)) < 0) {
		struct pollfd room = {.fd = udp->kept.sender_fd, .events = POLLOUT};

		if (errno == EINTR) {
			continue;
		}
		if (errno != EAGAIN && errno != ENOBUFS) {
			fail(udp, "send", errno);
			return CAN_HOST_NOBODY;
		}
		/* How long the host takes must not show in virtual time. */
		if (!clock_is_virtual() || poll(&room, 1, BUSY_MS) <= 0) {
			loop_want(&udp->sender, EPOLLOUT);
			return CAN_HOST_BUSY;
		}
	}
	udp->kept.looped += udp->kept.filtered ? 1 : 0;
	return CAN_HOST_SENT;
}

/* --- opening --------------------------------------------------------------------------------- */

/*
 * Own frames come back, as to everybody: the kernel drops them before they wake anybody. Where it
 * has no socket filters, read_some() does. Frames of other machines, which come where a program
 * here joined the group on the network, are dropped too; what this host sent itself is none of
 * those, whichever way it took.
 */
static bool filter(int fd, uint16_t own_port)
{
	struct sock_filter code[] = {
		BPF_STMT(BPF_LD | BPF_B | BPF_ABS, (uint32_t)(SKF_AD_OFF + SKF_AD_PKTTYPE)),
		BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PACKET_MULTICAST, 2, 0),
		BPF_STMT(BPF_LD | BPF_H | BPF_ABS, 0), /* UDP header: source port */
		BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ntohs(own_port), 0, 1),
		BPF_STMT(BPF_RET | BPF_K, 0),
		BPF_STMT(BPF_RET | BPF_K, UINT32_MAX),
	};
	const struct sock_fprog program = {.len = sizeof(code) / sizeof(code[0]), .filter = code};

	return setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof(program)) == 0;
}

static int set(int fd, int level, int option, int value)
{
	return setsockopt(fd, level, option, &value, sizeof(value));
}

static bool open_sender(struct can_udp *udp)
{
	struct sockaddr_in own = {.sin_family = AF_INET};
	const struct in_addr loopback = {.s_addr = htonl(INADDR_LOOPBACK)};
	socklen_t size = sizeof(own);
	const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);

	if (fd < 0) {
		return false;
	}
	udp->kept.sender_fd = fd;
	own.sin_addr = loopback;
	(void)set(fd, SOL_SOCKET, SO_SNDBUF, SOCKET_BUFFER);
	if (set(fd, SOL_SOCKET, SO_BROADCAST, 1) != 0 ||
	    setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof(loopback)) != 0 ||
	    set(fd, IPPROTO_IP, IP_MULTICAST_TTL, 0) != 0 ||
	    bind(fd, (const struct sockaddr *)&own, sizeof(own)) != 0 ||
	    getsockname(fd, (struct sockaddr *)&own, &size) != 0) {
		return false;
	}
	udp->kept.own_port = own.sin_port;
	return true;
}

static bool open_receiver(struct can_udp *udp)
{
	const struct ip_mreq group = {
		.imr_multiaddr = udp->target.sin_addr,
		.imr_interface.s_addr = htonl(INADDR_LOOPBACK),
	};
	const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);

	if (fd < 0) {
		return false;
	}
	udp->kept.receiver_fd = fd;
	(void)set(fd, SOL_SOCKET, SO_RCVBUF, SOCKET_BUFFER);
	udp->kept.filtered = filter(fd, udp->kept.own_port);
	return set(fd, SOL_SOCKET, SO_REUSEADDR, 1) == 0 &&
	       bind(fd, (const struct sockaddr *)&udp->target, sizeof(udp->target)) == 0 &&
	       (!is_multicast(udp) ||
	        setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof(group)) == 0);
}

/* Says so if other programs cannot join the group, for want of a route to it. */
static void look_for_route(const struct can_udp *udp)
{
	const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);

	if (is_multicast(udp) && fd >= 0 &&
	    connect(fd, (const struct sockaddr *)&udp->target, sizeof(udp->target)) != 0) {
		host_say("%s: no route to the group, so mcast:N of other programs cannot join: "
		         "ip route add " GROUP "0/24 dev lo",
		         udp->bus->name);
	}
	if (fd >= 0) {
		close(fd);
	}
}

static void listen_to(struct can_udp *udp)
{
	udp->source.fd = udp->kept.receiver_fd;
	udp->source.ready = on_readable;
	udp->source.again = read_some;
	udp->source.owner = udp;
	loop_add(&udp->source, EPOLLIN);
	udp->sender.fd = udp->kept.sender_fd;
	udp->sender.ready = on_writable;
	udp->sender.owner = udp;
	loop_add(&udp->sender, 0);
}

static void start(struct can_bus *bus)
{
	struct can_udp *udp = bus->state;
	size_t size;
	const void *old = carry_get("can0/udp", &size);

	if (old != NULL && size == sizeof(udp->kept)) {
		memcpy(&udp->kept, old, size);
	} else if (!udp->bus->failing) {
		look_for_route(udp);
	}
	if (udp->kept.receiver_fd > 0 || (open_sender(udp) && open_receiver(udp))) {
		listen_to(udp);
		can_bus_works(bus);
	} else {
		fail(udp, "open", errno);
	}
}

static void stop(struct can_bus *bus)
{
	close_sockets(bus->state);
}

static void save(struct can_bus *bus)
{
	struct can_udp *udp = bus->state;

	carry_put("can0/udp", &udp->kept, sizeof(udp->kept));
	if (udp->kept.receiver_fd > 0) {
		carry_fd(udp->kept.receiver_fd);
		carry_fd(udp->kept.sender_fd);
	}
}

const struct can_bus_type can_bus_udp = {
	.scheme = "udp",
	.state_size = sizeof(struct can_udp),
	.parse = parse,
	.start = start,
	.stop = stop,
	.save = save,
	.send = send_frame,
	.pause = pause_reading,
	.count = count_drops,
	.describe = describe,
};
