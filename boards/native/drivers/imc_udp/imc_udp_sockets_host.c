/* SPDX-License-Identifier: Apache-2.0 */
#include "imc_udp_sockets.h"

#include <arpa/inet.h>
#include <errno.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <string.h>
#include <unistd.h>

enum {
	SOCKET_BUFFER = 1 << 20
};

struct sockaddr_in imc_udp_sockaddr(uint32_t ipv4, uint16_t port)
{
	return (struct sockaddr_in){
		.sin_family = AF_INET,
		.sin_addr.s_addr = htonl(ipv4),
		.sin_port = htons(port),
	};
}

bool imc_udp_is_loopback(uint32_t ipv4)
{
	return ipv4 >> 24 == IN_LOOPBACKNET;
}

static int set(int fd, int level, int option, int value)
{
	return setsockopt(fd, level, option, &value, sizeof(value));
}

/* The bound socket, or -1. */
static int open_socket(uint32_t ipv4, uint16_t port)
{
	const struct sockaddr_in own = imc_udp_sockaddr(ipv4, port);
	const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);

	if (fd < 0) {
		return -1;
	}
	(void)set(fd, SOL_SOCKET, SO_RCVBUF, SOCKET_BUFFER);
	if (bind(fd, (const struct sockaddr *)&own, sizeof(own)) != 0) {
		const int error = errno;

		close(fd);
		errno = error;
		return -1;
	}
	return fd;
}

/* What others are told when packets come in on all addresses: the first that is not loopback. */
static uint32_t first_address(void)
{
	struct ifaddrs *all;
	uint32_t found = INADDR_LOOPBACK;

	if (getifaddrs(&all) != 0) {
		return found;
	}
	for (const struct ifaddrs *at = all; at != NULL; at = at->ifa_next) {
		if (at->ifa_addr != NULL && at->ifa_addr->sa_family == AF_INET &&
		    (at->ifa_flags & IFF_UP) != 0 && (at->ifa_flags & IFF_LOOPBACK) == 0) {
			struct sockaddr_in address;

			memcpy(&address, at->ifa_addr, sizeof(address));
			found = ntohl(address.sin_addr.s_addr);
			break;
		}
	}
	freeifaddrs(all);
	return found;
}

static bool open_packets(struct imc_udp_sockets *self, uint32_t ipv4, uint16_t port)
{
	const struct in_addr interface = {.s_addr = htonl(ipv4)};
	const int fd = open_socket(ipv4, port);
	struct sockaddr_in own;
	socklen_t size = sizeof(own);

	if (fd < 0) {
		return false;
	}
	self->packets = fd;
	(void)set(fd, SOL_SOCKET, SO_BROADCAST, 1);
	(void)set(fd, IPPROTO_IP, IP_MULTICAST_TTL, 1);
	if (ipv4 != INADDR_ANY) {
		(void)setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof(interface));
	}
	if (getsockname(fd, (struct sockaddr *)&own, &size) != 0) {
		return false;
	}
	self->own.ipv4 = ipv4 != INADDR_ANY ? ipv4 : first_address();
	self->own.port = ntohs(own.sin_port);
	return true;
}

/* The first free one of the five; on loopback nobody else's broadcasts are heard. */
static bool open_announcements(struct imc_udp_sockets *self, uint32_t ipv4, uint16_t first)
{
	const uint32_t at = imc_udp_is_loopback(ipv4) ? ipv4 : INADDR_ANY;
	int fd = -1;

	for (uint16_t i = 0; fd < 0 && i < IMC_UDP_DISCOVERY_PORTS; i++) {
		self->discovery_port = (uint16_t)(first + i);
		fd = open_socket(at, self->discovery_port);
	}
	if (fd < 0) {
		return false;
	}
	(void)set(fd, IPPROTO_IP, IP_MULTICAST_ALL, 0); /* the group's socket hears those */
	self->announcements = fd;
	return true;
}

static bool join(int fd, uint32_t ipv4)
{
	const struct ip_mreq group = {
		.imr_multiaddr.s_addr = htonl(IMC_UDP_GROUP),
		.imr_interface.s_addr = htonl(ipv4),
	};

	return setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof(group)) == 0;
}

/* On the interfaces of all addresses of this host; an interface may have several. */
static bool join_all(int fd)
{
	struct ifaddrs *all;
	bool any = false;

	if (getifaddrs(&all) != 0) {
		return false;
	}
	for (const struct ifaddrs *at = all; at != NULL; at = at->ifa_next) {
		if (at->ifa_addr != NULL && at->ifa_addr->sa_family == AF_INET &&
		    (at->ifa_flags & IFF_UP) != 0) {
			struct sockaddr_in address;

			memcpy(&address, at->ifa_addr, sizeof(address));
			any |= join(fd, ntohl(address.sin_addr.s_addr)) || errno == EADDRINUSE;
		}
	}
	freeifaddrs(all);
	return any;
}

/* Bound to the group, it hears nothing else, and shares the port with whoever else does so. */
static void open_group(struct imc_udp_sockets *self, uint32_t ipv4)
{
	const struct sockaddr_in own = imc_udp_sockaddr(IMC_UDP_GROUP, self->discovery_port);
	const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);

	if (fd < 0) {
		return;
	}
	(void)set(fd, SOL_SOCKET, SO_REUSEADDR, 1);
	if (bind(fd, (const struct sockaddr *)&own, sizeof(own)) != 0 ||
	    !(ipv4 == INADDR_ANY ? join_all(fd) : join(fd, ipv4))) {
		const int error = errno;

		close(fd);
		errno = error;
		return;
	}
	self->group = fd;
}

bool imc_udp_sockets_open(struct imc_udp_sockets *self, uint32_t ipv4, uint16_t port,
                          uint16_t first)
{
	if (!open_packets(self, ipv4, port) || !open_announcements(self, ipv4, first)) {
		return false;
	}
	open_group(self, ipv4);
	return true;
}

void imc_udp_sockets_close(struct imc_udp_sockets *self)
{
	int *const all[] = {&self->packets, &self->announcements, &self->group};

	for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) {
		if (*all[i] != 0) {
			close(*all[i]);
			*all[i] = 0;
		}
	}
}
