/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A UART that listens on UDP for the network is announced there: _mavlink._udp, over mDNS, by
 * avahi-publish. Where there is none, nothing is announced, and nothing said of it. Real time only,
 * and not what only this host can reach.
 */
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/clock.h"
#include "host/device_id.h"
#include "host/module.h"
#include "host/wire.h"
#include "uart_host_wire.h"

#define SERVICE "_mavlink._udp"

static const char *const names[] = {"uart0", "uart1", "uart2", "uart3"};

enum {
	UARTS = sizeof(names) / sizeof(names[0])
};

static pid_t publishers[UARTS];

/* Its port, if it is to be announced; else NULL. text: as wire_describe() gives it. */
static const char *port_of(const char *text)
{
	const char *const colon = strrchr(text, ':');

	if (strncmp(text, "udpin:", 6) != 0 || strncmp(text, "udpin:127.", 10) == 0 ||
	    strncmp(text, "udpin:[::1]", 11) == 0) {
		return NULL;
	}
	return colon + 1;
}

/* In the child, between fork() and exec: no more than that. */
static void publish(const char *name, const char *port, const char *record)
{
	const char *const words[] = {"avahi-publish", "-s", name, SERVICE, port, record, NULL};
	const int null = open("/dev/null", O_RDWR);

	prctl(PR_SET_PDEATHSIG, SIGKILL);
	for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
		dup2(null, fd);
	}
	execvp(words[0], (char *const *)(uintptr_t)words);
	_exit(0);
}

/* As the light itself tells its serial number. */
static void print_serial(char *text, size_t size)
{
	const uint64_t id = device_id();
	const uint8_t *const bytes = (const uint8_t *)&id;
	size_t at = 0;

	for (size_t i = 0; i < sizeof(id); i++) {
		at += (size_t)snprintf(text + at, size - at, "%02x", bytes[i]);
	}
}

static void up(void)
{
	char serial[2 * sizeof(uint64_t) + 1];
	char name[64];
	char record[32];

	if (clock_is_virtual()) {
		return;
	}
	print_serial(serial, sizeof(serial));
	snprintf(record, sizeof(record), "serial=%s", serial);
	for (size_t i = 0; i < UARTS; i++) {
		struct wire *const wire = uart_host_wire_find(names[i]);
		char text[WIRE_URL_MAX];
		const char *port;

		wire_describe(wire, text, sizeof(text));
		port = port_of(text);
		if (port == NULL || uart_host_wire_protocol(wire) == UART_HOST_PROTOCOL_IMC) {
			continue;
		}
		snprintf(name, sizeof(name), "Pharos %s port %s", serial, port);
		publishers[i] = fork();
		if (publishers[i] == 0) {
			publish(name, port, record);
		}
	}
}

static void withdraw(void)
{
	for (size_t i = 0; i < UARTS; i++) {
		if (publishers[i] > 0) {
			kill(publishers[i], SIGKILL);
			waitpid(publishers[i], NULL, 0);
		}
		publishers[i] = 0;
	}
}

HOST_MODULE(uart_announce_module) = {
	.name = "UARTs on the network",
	.order = HOST_ORDER_BOARD,
	.up = up,
	.save = withdraw,
	.stop = withdraw,
};
