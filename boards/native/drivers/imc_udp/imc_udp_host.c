/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --imc: UDP as IMC uses it, over the sockets of imc_udp_sockets.h. Own announcements come back and
 * are ignored.
 */
#include "imc_udp.h"
#include "imc_udp_sockets.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "host/buffer.h"
#include "host/carry.h"
#include "host/clock.h"
#include "host/control.h"
#include "host/lockstep.h"
#include "host/loop.h"
#include "host/module.h"
#include "host/options.h"
#include "host/say.h"

enum {
	DISCOVERY_FIRST = 30100,
	DATAGRAM_MAX = 65536,
	READ_BATCH = 32,      /* then the device has its turn, however many there are */
	UNREAD_MAX = 1 << 20, /* bytes; the rest is dropped and counted, as UDP does */
	STAGED_MAX = 16 << 20,
	RETRY_MS = 1000,
};

/* In front of each datagram that waits. */
struct record {
	struct imc_udp_address from;
	uint32_t length;
};

struct counts {
	uint64_t rx_datagrams;
	uint64_t tx_datagrams;
	uint64_t rx_drops;
	uint64_t errors;
};

static struct {
	bool wanted;
	uint32_t ipv4;
	uint16_t port;
	uint16_t discovery_first;
	void (*on_rx)(void *arg);
	void *arg;
	struct buffer staged; /* lock-step: not yet released */
	struct buffer rx;
	struct loop_source packets;
	struct loop_source announcements;
	struct loop_source group;
	struct loop_timer retry;
	bool failing;
	/* carried over resets */
	struct kept {
		struct counts counts;
		uint64_t released; /* of counts.rx_datagrams */
		struct imc_udp_sockets sockets;
	} kept;
} udp;

static uint8_t datagram[DATAGRAM_MAX];

/* --- the option ------------------------------------------------------------------------------ */

static int parse_discovery(const char *text, struct host_error *error)
{
	struct host_error reason;
	uint64_t number;

	if (strncmp(text, ",discovery=", 11) != 0) {
		return host_error_set(error, "\"%.60s\": say udp:HOST:PORT[,discovery=PORT]", text);
	}
	if (parse_number(text + 11, 1, UINT16_MAX - IMC_UDP_DISCOVERY_PORTS, &number, &reason) !=
	    0) {
		return host_error_set(error, "discovery: %.200s", reason.text);
	}
	udp.discovery_first = (uint16_t)number;
	return 0;
}

static int parse(const char *value, struct host_error *error)
{
	char text[80];
	struct host_error reason;
	struct in_addr host;
	uint64_t number;
	char *comma;
	char *colon;

	udp.wanted = strcmp(value, "none") != 0;
	udp.discovery_first = DISCOVERY_FIRST;
	if (!udp.wanted) {
		return 0;
	}
	if (strncmp(value, "udp:", 4) != 0 || strlen(value) >= sizeof(text)) {
		return host_error_set(error, "\"%.60s\": say udp:HOST:PORT or none", value);
	}
	strcpy(text, value + 4);
	comma = strchr(text, ',');
	if (comma != NULL && parse_discovery(comma, error) != 0) {
		return -1;
	}
	if (comma != NULL) {
		*comma = '\0';
	}
	colon = strrchr(text, ':');
	if (colon != NULL) {
		*colon = '\0';
	}
	if (colon == NULL || inet_pton(AF_INET, text, &host) != 1) {
		return host_error_set(error, "\"%.60s\" has no IPv4 address and port", value);
	}
	if (parse_number(colon + 1, 0, UINT16_MAX, &number, &reason) != 0) {
		return host_error_set(error, "port: %.200s", reason.text);
	}
	udp.ipv4 = ntohl(host.s_addr);
	udp.port = (uint16_t)number;
	return 0;
}

static const struct host_option options[] = {
	{"imc", "NET",
         "where IMC's datagrams go (none):\n"
         "udp:HOST:PORT[,discovery=FIRST]\n"
         "                     packets on that address of this host (0.0.0.0:\n"
         "                     all; port 0: any), announcements on the five\n"
         "                     ports from FIRST (30100)\n"
         "none                 no datagrams",
         parse},
	{0},
};

/* --- receiving ------------------------------------------------------------------------------- */

static void give(const uint8_t *records, size_t size)
{
	if (!buffer_append(&udp.rx, records, size, UNREAD_MAX)) {
		udp.kept.counts.rx_drops++;
	}
}

static void take_in(const struct sockaddr_in *from, size_t length)
{
	const struct record record = {
		.from = {.ipv4 = ntohl(from->sin_addr.s_addr), .port = ntohs(from->sin_port)},
		.length = (uint32_t)length,
	};
	struct buffer *const to = clock_is_lockstep() ? &udp.staged : &udp.rx;
	const size_t max = clock_is_lockstep() ? STAGED_MAX : UNREAD_MAX;
	uint8_t *const room = buffer_reserve(to, sizeof(record) + length, max);

	if (record.from.ipv4 == udp.kept.sockets.own.ipv4 &&
	    record.from.port == udp.kept.sockets.own.port) {
		return;
	}
	if (room == NULL) {
		udp.kept.counts.rx_drops++;
		return;
	}
	memcpy(room, &record, sizeof(record));
	memcpy(room + sizeof(record), datagram, length);
	to->tail += sizeof(record) + length;
	udp.kept.counts.rx_datagrams++;
	udp.kept.released += clock_is_lockstep() ? 0 : 1;
}

static bool read_some(struct loop_source *source)
{
	bool some = false;

	for (int i = 0; i < READ_BATCH; i++) {
		struct sockaddr_in from;
		socklen_t size = sizeof(from);
		const ssize_t length = recvfrom(source->fd, datagram, sizeof(datagram),
		                                MSG_DONTWAIT, (struct sockaddr *)&from, &size);

		if (length < 0) {
			/* ECONNREFUSED and the like report the fate of what was sent earlier. */
			udp.kept.counts.errors += errno != EAGAIN && errno != EINTR ? 1 : 0;
			break;
		}
		take_in(&from, (size_t)length);
		some = true;
	}
	if (udp.on_rx != NULL && buffer_length(&udp.rx) > 0) {
		udp.on_rx(udp.arg);
	}
	return some;
}

static void on_readable(struct loop_source *source, uint32_t events)
{
	(void)events;
	if (read_some(source)) {
		loop_hot(source);
	}
}

void imc_udp_open(void (*on_rx)(void *arg), void *arg)
{
	udp.on_rx = on_rx;
	udp.arg = arg;
}

bool imc_udp_own(struct imc_udp_address *own)
{
	*own = udp.kept.sockets.own;
	return udp.wanted;
}

int imc_udp_receive(struct imc_udp_address *from, uint8_t *bytes, size_t room)
{
	struct record record;

	while (buffer_length(&udp.rx) > 0) {
		const uint8_t *const at = buffer_bytes(&udp.rx);

		memcpy(&record, at, sizeof(record));
		*from = record.from;
		if (record.length <= room) {
			memcpy(bytes, at + sizeof(record), record.length);
		}
		buffer_consume(&udp.rx, sizeof(record) + record.length);
		if (record.length <= room) {
			return (int)record.length;
		}
		udp.kept.counts.rx_drops++;
	}
	return -EAGAIN;
}

/* --- sending --------------------------------------------------------------------------------- */

int imc_udp_send(const struct imc_udp_address *to, const uint8_t *bytes, size_t length)
{
	const struct sockaddr_in address = imc_udp_sockaddr(to->ipv4, to->port);
	ssize_t sent = -1;

	if (udp.kept.sockets.packets == 0) {
		return -ENETDOWN;
	}
	/* The first may report the fate of an earlier datagram. */
	for (int tries = 0; sent < 0 && tries < 2; tries++) {
		sent = sendto(udp.kept.sockets.packets, bytes, length, MSG_NOSIGNAL | MSG_DONTWAIT,
		              (const struct sockaddr *)&address, sizeof(address));
	}
	if (sent < 0) {
		udp.kept.counts.errors++;
		return -errno;
	}
	udp.kept.counts.tx_datagrams++;
	return 0;
}

static uint32_t announce_address(enum imc_udp_scope scope)
{
	switch (scope) {
	case IMC_UDP_HOST:
		return INADDR_LOOPBACK;
	case IMC_UDP_BROADCAST:
		return imc_udp_is_loopback(udp.ipv4) ? INADDR_LOOPBACK | 0x00FFFFFFu
		                                     : INADDR_BROADCAST;
	case IMC_UDP_MULTICAST:
		return IMC_UDP_GROUP;
	}
	return INADDR_LOOPBACK;
}

int imc_udp_announce(enum imc_udp_scope scope, const uint8_t *bytes, size_t length)
{
	struct imc_udp_address to = {.ipv4 = announce_address(scope)};
	int result = 0;

	for (uint16_t i = 0; i < IMC_UDP_DISCOVERY_PORTS; i++) {
		to.port = (uint16_t)(udp.discovery_first + i);
		const int error = imc_udp_send(&to, bytes, length);

		result = error != 0 ? error : result;
	}
	return result;
}

/* --- sockets --------------------------------------------------------------------------------- */

static void listen_to(struct loop_source *source, int fd)
{
	source->fd = fd;
	source->ready = on_readable;
	source->again = read_some;
	loop_add(source, EPOLLIN);
}

static void describe(char *text, size_t size)
{
	const struct in_addr own = {.s_addr = htonl(udp.kept.sockets.own.ipv4)};
	char address[INET_ADDRSTRLEN];

	inet_ntop(AF_INET, &own, address, sizeof(address));
	snprintf(text, size, "udp:%s:%u", address, udp.kept.sockets.own.port);
}

static void try_open(struct loop_timer *timer)
{
	char text[64];

	if (udp.kept.sockets.packets == 0 &&
	    imc_udp_sockets_open(&udp.kept.sockets, udp.ipv4, udp.port, udp.discovery_first) &&
	    udp.kept.sockets.group == 0) {
		udp.kept.counts.errors++;
		host_say("imc: group 224.0.75.69: %s; announcements there are not heard",
		         strerror(errno));
	}
	if (udp.kept.sockets.announcements != 0) {
		listen_to(&udp.packets, udp.kept.sockets.packets);
		listen_to(&udp.announcements, udp.kept.sockets.announcements);
		if (udp.kept.sockets.group != 0) {
			listen_to(&udp.group, udp.kept.sockets.group);
		}
		describe(text, sizeof(text));
		if (!carry_is_reset()) {
			host_say("imc is %s, announcements on port %u", text,
			         udp.kept.sockets.discovery_port);
		}
		return;
	}
	udp.kept.counts.errors++;
	if (!udp.failing) {
		udp.failing = true;
		host_say("imc: open: %s; trying again", strerror(errno));
	}
	imc_udp_sockets_close(&udp.kept.sockets);
	loop_timer_start(timer, RETRY_MS);
}

/* --- control and lock-step ------------------------------------------------------------------- */

static enum control_result run_imc(struct control_call *call)
{
	char text[64];

	describe(text, sizeof(text));
	control_put_string(call->reply, "address", udp.wanted ? text : "none");
	control_put_integer(call->reply, "discovery_port", udp.kept.sockets.discovery_port);
	control_put_integer(call->reply, "rx_datagrams", (int64_t)udp.kept.counts.rx_datagrams);
	control_put_integer(call->reply, "tx_datagrams", (int64_t)udp.kept.counts.tx_datagrams);
	control_put_integer(call->reply, "rx_drops", (int64_t)udp.kept.counts.rx_drops);
	control_put_integer(call->reply, "errors", (int64_t)udp.kept.counts.errors);
	return CONTROL_OK;
}

static const struct control_op ops[] = {
	{"imc", "address and counters of IMC's datagrams", run_imc},
	{0},
};

static uint64_t received(void)
{
	return udp.kept.counts.rx_datagrams;
}

static void poke(void)
{
	if (udp.retry.running) {
		loop_timer_stop(&udp.retry);
		try_open(&udp.retry);
	}
}

static void release(uint64_t total)
{
	while (udp.kept.released < total && buffer_length(&udp.staged) > 0) {
		struct record record;

		memcpy(&record, buffer_bytes(&udp.staged), sizeof(record));
		give(buffer_bytes(&udp.staged), sizeof(record) + record.length);
		buffer_consume(&udp.staged, sizeof(record) + record.length);
		udp.kept.released++;
	}
	if (udp.on_rx != NULL && buffer_length(&udp.rx) > 0) {
		udp.on_rx(udp.arg);
	}
}

static void report(json_t *buses)
{
	json_t *entry;

	if (!udp.wanted) {
		return;
	}
	entry = json_object();
	control_put_integer(entry, "rx_frames", (int64_t)udp.kept.counts.rx_datagrams);
	control_put_integer(entry, "tx_frames", (int64_t)udp.kept.counts.tx_datagrams);
	json_object_set_new(buses, "imc", entry);
}

static struct lockstep_source lockstep_imc = {
	.name = "imc",
	.received = received,
	.poke = poke,
	.release = release,
	.report = report,
};

/* --- start and end --------------------------------------------------------------------------- */

static int start(void)
{
	size_t size;
	const void *const staged = carry_get("imc/staged", &size);

	if (!udp.wanted) {
		return 0;
	}
	buffer_append(&udp.staged, staged, size, STAGED_MAX);
	(void)carry_register("imc/kept", &udp.kept, sizeof(udp.kept));
	lockstep_add(&lockstep_imc);
	udp.retry.fire = try_open;
	try_open(&udp.retry);
	return 0;
}

static void save(void)
{
	carry_put("imc/staged", buffer_bytes(&udp.staged), buffer_length(&udp.staged));
	if (udp.kept.sockets.packets != 0) {
		carry_fd(udp.kept.sockets.packets);
		carry_fd(udp.kept.sockets.announcements);
		if (udp.kept.sockets.group != 0) {
			carry_fd(udp.kept.sockets.group);
		}
	}
}

static void stop(void)
{
	if (udp.kept.sockets.packets != 0) {
		loop_remove(&udp.packets);
		loop_remove(&udp.announcements);
		loop_remove(&udp.group);
	}
	loop_timer_stop(&udp.retry);
	imc_udp_sockets_close(&udp.kept.sockets);
	buffer_free(&udp.staged);
	buffer_free(&udp.rx);
}

HOST_MODULE(imc_module) = {
	.name = "IMC",
	.order = HOST_ORDER_WIRES + 3,
	.options = options,
	.ops = ops,
	.start = start,
	.save = save,
	.stop = stop,
};
