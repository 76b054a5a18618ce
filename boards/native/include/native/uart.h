/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What Zephyr's UART API cannot tell: what kind of peer the wire has. drivers/uart_host implements it.
 * The shell asks once, at POST_KERNEL 90: only a terminal gets echo, prompt and colours; without a peer
 * there is no shell on the UART, and the log goes to port_console_write().
 */
#ifndef NATIVE_UART_H_
#define NATIVE_UART_H_

struct device;

enum native_uart_peer {
	NATIVE_UART_PEER_NONE,     /* wire "none" */
	NATIVE_UART_PEER_PROGRAM,  /* stdio that is not a terminal, sockets */
	NATIVE_UART_PEER_TERMINAL, /* stdio on a terminal (input and output), pty, serial */
};

/* Any context, after the device's init function. */
enum native_uart_peer native_uart_peer(const struct device *dev);

#endif
