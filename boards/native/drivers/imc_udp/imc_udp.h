/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Between the Zephyr side of IMC's datagrams (imc_udp.c) and the host's sockets (imc_udp_host.c).
 * No header of either side is included here. IPv4 addresses in the processor's byte order.
 */
#ifndef IMC_UDP_H_
#define IMC_UDP_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct imc_udp_address {
	uint32_t ipv4;
	uint16_t port;
};

enum imc_udp_scope {
	IMC_UDP_HOST,
	IMC_UDP_BROADCAST,
	IMC_UDP_MULTICAST,
};

/* on_rx(arg) is called in interrupt context whenever datagrams have come. */
void imc_udp_open(void (*on_rx)(void *arg), void *arg);

/* False: the command line names no network. */
bool imc_udp_own(struct imc_udp_address *own);

/* The oldest datagram: its length, or -EAGAIN. One longer than room is dropped and counted. */
int imc_udp_receive(struct imc_udp_address *from, uint8_t *bytes, size_t room);

/* 0, or -errno. */
int imc_udp_send(const struct imc_udp_address *to, const uint8_t *bytes, size_t length);
int imc_udp_announce(enum imc_udp_scope scope, const uint8_t *bytes, size_t length);

#endif
