/* SPDX-License-Identifier: Apache-2.0 */
/* What is at the other end of the shell's wire: between shell_uart.c and the host's
 * shell_peer_host.c. */
#ifndef SHELL_PEER_H
#define SHELL_PEER_H

enum shell_peer {
	SHELL_PEER_NONE, /* the wire "none": no shell, and the log goes to port_console_write() */
	SHELL_PEER_PROGRAM,  /* pipes, files, sockets: no echo, no prompt, no colours */
	SHELL_PEER_TERMINAL, /* pty, serial */
	SHELL_PEER_CONSOLE,  /* stdio with a terminal at both ends: this program's own */
};

/* name: the wire's, as the devicetree has it ("console"). */
enum shell_peer shell_peer_of(const char *name);

#endif
