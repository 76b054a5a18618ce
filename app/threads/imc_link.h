/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Links that carry IMC packets and know no meaning: UARTs that are set to IMC, and datagrams where
 * the board has them. A received packet goes to the command thread in a buffer of the pool.
 */
#ifndef PHAROS_THREADS_IMC_LINK_H
#define PHAROS_THREADS_IMC_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/imc/outbox.h"
#include "threads/limits.h"

/* The number of the datagram link, behind the UARTs. */
#define IMC_LINK_DATAGRAMS UART_LINKS_MAX

struct imc_link_stats {
	uint32_t rx_datagrams;
	uint32_t rx_malformed; /* datagrams that are no packet */
	uint32_t tx_datagrams;
	uint32_t tx_failed;
};

/* The board has datagrams, and they have started. Any thread. */
bool imc_link_has_datagrams(void);

/* What finds no room or no network is counted by the link. Command thread. */
void imc_link_send(const struct imc_route *route, const uint8_t *bytes, size_t length);

/* To everyone within scope: IMC_ANNOUNCE. Command thread. */
void imc_link_announce(int32_t scope, const uint8_t *bytes, size_t length);

/* Of the datagram link. Any thread. */
struct imc_link_stats imc_link_stats_get(void);

/* Thread entry, if the board has datagrams. */
void imc_link_run(void *p1, void *p2, void *p3);

#endif
