/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A UART as a link: interrupts fill a receive ring and empty a send queue; the thread turns
 * received bytes into frames for the command thread.
 */
#ifndef PHAROS_THREADS_UART_LINK_H
#define PHAROS_THREADS_UART_LINK_H

#include "core/params.h"
#include "threads/link.h"

/* Values of UART0_PROTO and the like. */
enum uart_protocol {
	UART_PROTOCOL_NONE = -1, /* the board has no such UART */
	UART_PROTOCOL_MAVLINK = 0,
	UART_PROTOCOL_IMC = 1,
};

/* As links_send() (up to UART_FRAME_MAX bytes) and so on, of the links 0…UART_LINKS_MAX - 1. */
int uart_link_send(uint8_t number, const uint8_t *frame, size_t length);
int uart_link_forward(uint8_t number, const uint8_t *frame, size_t length);
uint32_t uart_link_rate(uint8_t number);
int uart_link_stats_get(uint8_t number, struct link_stats *stats);

/*
 * Opens the UARTs that the board has, each for what its strap says that it speaks, or else its
 * parameter. Before the threads start.
 */
void uart_links_init(const struct params *params);

/* number: 0…UART_LINKS_MAX - 1. Any thread, after uart_links_init(). */
enum uart_protocol uart_link_protocol(uint8_t number);

/* Thread entry; number: 0…UART_LINKS_MAX - 1, one that has started. */
void uart_link_run(void *number, void *p2, void *p3);

#endif
