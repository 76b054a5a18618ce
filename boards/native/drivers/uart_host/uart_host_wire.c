/* SPDX-License-Identifier: Apache-2.0 */
/* --uart0 … --uart3, --console: which wire each UART of the native board has. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "host/module.h"
#include "host/wire.h"
#include "uart_host_wire.h"

/* Of a wire that takes its time, and what any other wire is taken for. */
enum {
	BAUD_PACED = 57600,
	BAUD_UNPACED = 921600,
};

struct port {
	struct wire wire;
	const char *fallback; /* when the option is not given */
	uint32_t baud;
	bool paced;
	int protocol;
};

static struct port *last_parsed; /* what --protocol is about */

static struct port ports[] = {
	{.wire = {.name = "uart0"}, .fallback = "none", .protocol = UART_HOST_PROTOCOL_OPEN},
	{.wire = {.name = "uart1"}, .fallback = "none", .protocol = UART_HOST_PROTOCOL_OPEN},
	{.wire = {.name = "uart2"}, .fallback = "none", .protocol = UART_HOST_PROTOCOL_OPEN},
	{.wire = {.name = "uart3"}, .fallback = "none", .protocol = UART_HOST_PROTOCOL_OPEN},
	{.wire = {.name = "console"}, .fallback = "stdio", .protocol = UART_HOST_PROTOCOL_OPEN},
};

enum {
	PORTS = sizeof(ports) / sizeof(ports[0])
};

static struct port *port_of(const struct wire *wire)
{
	return (struct port *)(uintptr_t)wire;
}

_Static_assert(offsetof(struct port, wire) == 0, "a wire's address is that of its port");

struct wire *uart_host_wire_find(const char *name)
{
	for (size_t i = 0; i < PORTS; i++) {
		if (strcmp(ports[i].wire.name, name) == 0) {
			return &ports[i].wire;
		}
	}
	return NULL;
}

void uart_host_wire_open(struct wire *wire, void (*on_rx)(void *arg), void *arg)
{
	wire->on_rx = on_rx;
	wire->arg = arg;
}

size_t uart_host_wire_available(const struct wire *wire)
{
	return wire_available(wire);
}

size_t uart_host_wire_read(struct wire *wire, uint8_t *data, size_t size)
{
	return wire_read(wire, data, size);
}

uint64_t uart_host_wire_hold_us(const struct wire *wire)
{
	return wire_hold_us(wire);
}

void uart_host_wire_expire(struct wire *wire)
{
	wire_expire(wire);
}

size_t uart_host_wire_write(struct wire *wire, const uint8_t *data, size_t length)
{
	return wire_write(wire, data, length);
}

void uart_host_wire_put(struct wire *wire, uint8_t byte)
{
	wire_put(wire, byte);
}

uint32_t uart_host_wire_baud(const struct wire *wire)
{
	return port_of(wire)->baud;
}

int uart_host_wire_set_baud(struct wire *wire, uint32_t baud)
{
	return wire->type->set_baud != NULL ? wire->type->set_baud(wire, baud) : 0;
}

bool uart_host_wire_paced(const struct wire *wire)
{
	return port_of(wire)->paced;
}

int uart_host_wire_protocol(const struct wire *wire)
{
	return port_of(wire)->protocol;
}

/* Takes ",paced" or ",baud=N" off the end of url. 1: took one; 0: there is none; -1 with a reason.
 */
static int parse_suffix(struct port *port, char *url, struct host_error *error)
{
	char *comma = strrchr(url, ',');
	struct host_error reason;
	uint64_t baud;

	if (comma == NULL) {
		return 0;
	}
	if (strcmp(comma, ",paced") == 0) {
		port->paced = true;
	} else if (strncmp(comma, ",baud=", 6) == 0) {
		if (parse_number(comma + 6, 300, 4000000, &baud, &reason) != 0) {
			return host_error_set(error, "baud: %.200s", reason.text);
		}
		port->baud = (uint32_t)baud;
	} else {
		return 0;
	}
	*comma = '\0';
	return 1;
}

static int parse_port(struct port *port, const char *value, struct host_error *error)
{
	char url[WIRE_URL_MAX];
	const char *comma;
	int result;

	if (strlen(value) >= sizeof(url)) {
		return host_error_set(error, "longer than %zu characters", sizeof(url) - 1);
	}
	strcpy(url, value);
	port->paced = false;
	port->baud = 0;
	do {
		result = parse_suffix(port, url, error);
	} while (result > 0);
	if (result < 0 || wire_parse(&port->wire, url, error) != 0) {
		return -1;
	}
	comma = strrchr(url, ',');
	if (port->wire.type == &wire_serial && comma != NULL) {
		port->baud = (uint32_t)strtoul(comma + 1, NULL, 10);
	} else if (port->baud == 0) {
		port->baud = port->paced ? BAUD_PACED : BAUD_UNPACED;
	}
	last_parsed = port;
	return 0;
}

static int parse_protocol(const char *value, struct host_error *error)
{
	if (last_parsed == NULL || strcmp(last_parsed->wire.name, "console") == 0) {
		return host_error_set(error, "say after --uartN what that UART speaks");
	}
	if (strcmp(value, "mavlink") != 0 && strcmp(value, "imc") != 0) {
		return host_error_set(error, "\"%.40s\" is neither mavlink nor imc", value);
	}
	last_parsed->protocol =
		strcmp(value, "imc") == 0 ? UART_HOST_PROTOCOL_IMC : UART_HOST_PROTOCOL_MAVLINK;
	return 0;
}

#define PARSE_PORT(i)                                                                              \
	static int parse_port_##i(const char *value, struct host_error *error)                     \
	{                                                                                          \
		return parse_port(&ports[i], value, error);                                        \
	}
PARSE_PORT(0)
PARSE_PORT(1)
PARSE_PORT(2)
PARSE_PORT(3)
PARSE_PORT(4)

static const struct host_option options[] = {
	{"uart0", "WIRE",
         "where the UART goes (none); WIRE is one of these:\n"
         "udpin:HOST:PORT      listen; answer every peer heard in the last\n"
         "                     60 s, at most 8\n"
         "udpout:HOST:PORT     send there, receive from there\n"
         "udppair:BIND_HOST:PORT,SEND_HOST:PORT\n"
         "                     receive on one, always send to the other\n"
         "tcp:HOST:PORT        connect, again and again if need be\n"
         "tcpin:HOST:PORT      listen; up to 8 clients share the wire\n"
         "pty:LINK             a new pseudo-terminal, with a link to it\n"
         "serial:DEV,BAUD      a serial port, 8N1; it may come and go\n"
         "stdio[:eof=exit]     standard input and output\n"
         "none                 not connected\n"
         "port 0: any free one, printed at start. After it: ,paced for bytes\n"
         "that take their time (in virtual time too), ,baud=N (57600, or\n"
         "921600 where bytes take no time)",
         parse_port_0},
	{"uart1", "WIRE", "the same for the second UART", parse_port_1},
	{"uart2", "WIRE", "the third", parse_port_2},
	{"uart3", "WIRE", "the fourth", parse_port_3},
	{"protocol", "NAME",
         "what the UART of the option before this one speaks: mavlink or imc;\n"
         "else its parameter says that (UART0_PROTO, …)",
         parse_protocol},
	{"console", "WIRE", "where the console and the shell go (stdio)", parse_port_4},
	{0},
};

/* Until the device has shown what it speaks. */
static enum wire_framing framing_of(const struct port *port)
{
	if (strcmp(port->wire.name, "console") == 0) {
		return WIRE_FRAMING_NONE;
	}
	return port->protocol == UART_HOST_PROTOCOL_IMC ? WIRE_FRAMING_IMC : WIRE_FRAMING_MAVLINK;
}

static int start(void)
{
	struct host_error error;

	for (size_t i = 0; i < PORTS; i++) {
		if (ports[i].wire.type == NULL &&
		    parse_port(&ports[i], ports[i].fallback, &error) != 0) {
			return -1;
		}
		ports[i].wire.framing = framing_of(&ports[i]);
		wire_add(&ports[i].wire);
	}
	return 0;
}

HOST_MODULE(uart_module) = {
	.name = "UARTs",
	.order = HOST_ORDER_WIRES - 1,
	.options = options,
	.start = start,
};
