/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A UART as a link: interrupts fill a receive ring and empty a send queue; the thread turns
 * received bytes into frames for the command thread.
 */
#ifndef PHAROS_THREADS_UART_LINK_H
#define PHAROS_THREADS_UART_LINK_H

/* Opens the UARTs that the board has. Before the threads start. */
void uart_links_init(void);

/* Thread entry; number: 0…UART_LINKS_MAX - 1. Returns at once when the board has no such UART. */
void uart_link_run(void *number, void *, void *);

#endif
