/* SPDX-License-Identifier: Apache-2.0 */
/* The shell's transport over a UART, interrupt-driven, and the shell on it. */
#include <errno.h>
#include <string.h>

#include <zephyr/device.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/init.h>
#include <zephyr/irq.h>
#include <zephyr/shell/shell_uart.h>

#include "kernel/port.h"
#include "shell_peer.h"

#define SHELL_NODE DT_CHOSEN(zephyr_shell_uart)

struct ring {
	uint8_t *bytes;
	size_t size;
	size_t first;
	size_t used;
};

struct uart_transport {
	const struct device *dev;
	shell_transport_handler_t event;
	void *context;
	struct ring rx;
	struct ring tx;
	bool blocking;
};

static uint8_t rx_bytes[CONFIG_SHELL_BACKEND_SERIAL_RX_RING_BUFFER_SIZE];
static uint8_t tx_bytes[CONFIG_SHELL_BACKEND_SERIAL_TX_RING_BUFFER_SIZE];

static struct uart_transport uart = {
	.rx = {.bytes = rx_bytes, .size = sizeof(rx_bytes)},
	.tx = {.bytes = tx_bytes, .size = sizeof(tx_bytes)},
};

/* The free bytes after those in use, as far as they lie in one piece. */
static size_t ring_room(const struct ring *ring, uint8_t **at)
{
	const size_t end = (ring->first + ring->used) % ring->size;

	*at = &ring->bytes[end];
	return MIN(ring->size - ring->used, ring->size - end);
}

static size_t ring_content(const struct ring *ring, uint8_t **at)
{
	*at = &ring->bytes[ring->first];
	return MIN(ring->used, ring->size - ring->first);
}

static void ring_drop(struct ring *ring, size_t length)
{
	ring->used -= length;
	ring->first = ring->used == 0 ? 0 : (ring->first + length) % ring->size;
}

static void rx_isr(struct uart_transport *self)
{
	uint8_t *at;
	size_t room;

	while ((room = ring_room(&self->rx, &at)) > 0) {
		const int count = uart_fifo_read(self->dev, at, (int)room);

		if (count <= 0) {
			break;
		}
		self->rx.used += (size_t)count;
	}
	if (self->rx.used == self->rx.size) {
		/* What comes now waits in the UART. */
		uart_irq_rx_disable(self->dev);
	}
	self->event(SHELL_TRANSPORT_EVT_RX_RDY, self->context);
}

static void tx_isr(struct uart_transport *self)
{
	uint8_t *at;
	const size_t length = ring_content(&self->tx, &at);
	const int sent = length == 0 ? 0 : uart_fifo_fill(self->dev, at, (int)length);

	if (sent > 0) {
		ring_drop(&self->tx, (size_t)sent);
		self->event(SHELL_TRANSPORT_EVT_TX_RDY, self->context);
	}
	if (self->tx.used == 0) {
		uart_irq_tx_disable(self->dev);
	}
}

static void uart_isr(const struct device *dev, void *user_data)
{
	struct uart_transport *self = user_data;

	(void)uart_irq_update(dev);
	if (uart_irq_rx_ready(dev) > 0) {
		rx_isr(self);
	}
	if (uart_irq_tx_ready(dev) > 0) {
		tx_isr(self);
	}
}

static int transport_init(const struct shell_transport *transport, const void *config,
                          shell_transport_handler_t evt_handler, void *context)
{
	struct uart_transport *self = transport->ctx;
	int rc;

	self->dev = config;
	self->event = evt_handler;
	self->context = context;
	rc = uart_irq_callback_user_data_set(self->dev, uart_isr, self);
	if (rc == 0) {
		uart_irq_rx_enable(self->dev);
	}
	return rc;
}

static int transport_uninit(const struct shell_transport *transport)
{
	struct uart_transport *self = transport->ctx;

	uart_irq_rx_disable(self->dev);
	uart_irq_tx_disable(self->dev);
	return 0;
}

static int transport_enable(const struct shell_transport *transport, bool blocking_tx)
{
	struct uart_transport *self = transport->ctx;

	self->blocking = blocking_tx;
	return 0;
}

static int transport_write(const struct shell_transport *transport, const void *data, size_t length,
                           size_t *cnt)
{
	struct uart_transport *self = transport->ctx;
	const unsigned int key = irq_lock();
	uint8_t *at;
	size_t room;

	*cnt = 0;
	if (self->blocking) {
		for (; *cnt < length; (*cnt)++) {
			uart_poll_out(self->dev, ((const uint8_t *)data)[*cnt]);
		}
	}
	while (*cnt < length && (room = ring_room(&self->tx, &at)) > 0) {
		const size_t part = MIN(room, length - *cnt);

		memcpy(at, (const uint8_t *)data + *cnt, part);
		self->tx.used += part;
		*cnt += part;
	}
	if (self->tx.used > 0) {
		uart_irq_tx_enable(self->dev);
	}
	irq_unlock(key);
	return 0;
}

static int transport_read(const struct shell_transport *transport, void *data, size_t length,
                          size_t *cnt)
{
	struct uart_transport *self = transport->ctx;
	const unsigned int key = irq_lock();
	uint8_t *at;

	*cnt = MIN(ring_content(&self->rx, &at), length);
	if (*cnt > 0) {
		memcpy(data, at, *cnt);
		ring_drop(&self->rx, *cnt);
		uart_irq_rx_enable(self->dev);
	}
	irq_unlock(key);
	return 0;
}

static const struct shell_transport_api uart_transport_api = {
	.init = transport_init,
	.uninit = transport_uninit,
	.enable = transport_enable,
	.write = transport_write,
	.read = transport_read,
};
static const struct shell_transport uart_shell_transport = {
	.api = &uart_transport_api,
	.ctx = &uart,
};

SHELL_DEFINE(shell_uart, CONFIG_SHELL_PROMPT_UART, &uart_shell_transport, 0, 0,
             SHELL_FLAG_CRLF_DEFAULT);

const struct shell *shell_backend_uart_get_ptr(void)
{
	return &shell_uart;
}

static void leave(void)
{
	port_exit(0);
}

static int start(void)
{
	const struct device *dev = DEVICE_DT_GET(SHELL_NODE);
	const enum shell_peer peer = shell_peer_of(DT_PROP(SHELL_NODE, wire));
	const bool terminal = peer == SHELL_PEER_TERMINAL || peer == SHELL_PEER_CONSOLE;
	const struct shell_backend_config_flags flags = {
		.echo = terminal,
		.use_colors = terminal,
		.use_vt100 = terminal,
	};

	/* Without a peer the log is not for this shell, and nobody types. */
	if (!device_is_ready(dev) || peer == SHELL_PEER_NONE) {
		return 0;
	}
	shell_uart.ctx->leave = peer == SHELL_PEER_CONSOLE ? leave : NULL;
	return shell_init(&shell_uart, dev, flags, true, 0);
}

SYS_INIT(start, POST_KERNEL, 90);
