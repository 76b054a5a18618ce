/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Between the Zephyr side of the native UART (uart_host.c) and the host's wires (uart_host_wire.c).
 * No header of either side is included here.
 */
#ifndef UART_HOST_WIRE_H_
#define UART_HOST_WIRE_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct wire;

/* The wire of that option ("uart0", "console"); NULL: there is none. */
struct wire *uart_host_wire_find(const char *name);

/* on_rx(arg) is called in interrupt context whenever bytes have come. */
void uart_host_wire_open(struct wire *wire, void (*on_rx)(void *arg), void *arg);

/* Bytes to read, and reading them: how many were there, at most size. */
size_t uart_host_wire_available(const struct wire *wire);
size_t uart_host_wire_read(struct wire *wire, uint8_t *data, size_t size);

/* How long what is kept of several peers' unfinished messages may wait (0: there is none), and
 * giving it up when that is over. */
uint64_t uart_host_wire_hold_us(const struct wire *wire);
void uart_host_wire_expire(struct wire *wire);

/* One datagram; how many bytes were taken. */
size_t uart_host_wire_write(struct wire *wire, const uint8_t *data, size_t length);

/* One byte, gathered with its neighbours into a datagram. */
void uart_host_wire_put(struct wire *wire, uint8_t byte);

/* Bits per second as the command line says. */
uint32_t uart_host_wire_baud(const struct wire *wire);

/* 0; -EINVAL: the serial port behind cannot; any other wire has no baud rate of its own and takes
 * all. */
int uart_host_wire_set_baud(struct wire *wire, uint32_t baud);

/* The option --protocol, as UART0_PROTO and the like; UART_HOST_PROTOCOL_OPEN: not given. */
enum {
	UART_HOST_PROTOCOL_OPEN = -1,
	UART_HOST_PROTOCOL_MAVLINK = 0,
	UART_HOST_PROTOCOL_IMC = 1,
};
int uart_host_wire_protocol(const struct wire *wire);

/* The option ",paced": bytes take the time that the baud rate gives them. */
bool uart_host_wire_paced(const struct wire *wire);

#endif
