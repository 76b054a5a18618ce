/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A UART as a link: interrupts fill a receive ring and empty a send queue; the thread turns
 * received bytes into frames for the command thread.
 */
#ifndef PHAROS_THREADS_UART_LINK_H
#define PHAROS_THREADS_UART_LINK_H

#include "threads/link.h"

/* As link_send() and so on, of the links 0…UART_LINKS_MAX - 1. */
int uart_link_send(uint8_t number, const uint8_t *frame, size_t length);
int uart_link_forward(uint8_t number, const uint8_t *frame, size_t length);
uint32_t uart_link_rate(uint8_t number);
int uart_link_stats_get(uint8_t number, struct link_stats *stats);

/* Opens the UARTs that the board has. Before the threads start. */
void uart_links_init(void);

/* Thread entry; number: 0…UART_LINKS_MAX - 1. Returns at once when the board has no such UART. */
void uart_link_run(void *number, void *, void *);

#endif
