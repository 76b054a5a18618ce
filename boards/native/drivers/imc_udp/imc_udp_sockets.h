/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sockets of IMC over UDP: one on a fixed port for packets, and one on a free port of the five
 * that announcements go to. A third, on the same port, hears those that go to the group
 * 224.0.75.69, also where the others are bound to the loopback: on the interface of the address, or
 * on all. The host's side only.
 */
#ifndef IMC_UDP_SOCKETS_H_
#define IMC_UDP_SOCKETS_H_

#include <netinet/in.h>
#include <stdbool.h>
#include <stdint.h>

#include "imc_udp.h"

#define IMC_UDP_GROUP 0xE0004B45u /* 224.0.75.69 */

enum {
	IMC_UDP_DISCOVERY_PORTS = 5
};

/* Plain data, carried over resets. Descriptors; 0: none. */
struct imc_udp_sockets {
	int packets;
	int announcements;
	int group; /* without it there are only the other announcements */
	struct imc_udp_address own;
	uint16_t discovery_port;
};

struct sockaddr_in imc_udp_sockaddr(uint32_t ipv4, uint16_t port);
bool imc_udp_is_loopback(uint32_t ipv4);

/*
 * ipv4 0: all addresses; port 0: any. first: of the ports of announcements. False, errno says why:
 * what is open by then is to be closed. True without a group: errno says why that is not heard.
 */
bool imc_udp_sockets_open(struct imc_udp_sockets *self, uint32_t ipv4, uint16_t port,
                          uint16_t first);

void imc_udp_sockets_close(struct imc_udp_sockets *self);

#endif
