/* SPDX-License-Identifier: Apache-2.0 */
/*
 * UART of the native board over a wire of the host (compatible "pharos,uart-host").
 *
 * Without ",paced" a wire is infinitely fast: what is written has left, what has come can be read.
 * With it, one write is held until its bits would have left, and bytes become readable one group
 * after the other.
 */
#define DT_DRV_COMPAT pharos_uart_host

#include <string.h>

#include <native/irq.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>

#include "devices/fault.h"
#include "uart_host_wire.h"

#define BITS_PER_BYTE 10u /* start, 8 data, stop */

/* Paced only: bytes of one write, and of one group received. */
#define TX_SHIFT_SIZE 512
#define RX_GROUP      16u

struct uart_host_config {
	const char *wire;
};

struct uart_host_data {
	struct wire *wire;
	enum board_chip chip;
	struct native_irq irq;
	uart_irq_callback_user_data_t callback;
	void *user_data;
	bool rx_enabled;
	bool tx_enabled;
	bool moved; /* the callback has read, written or changed something */
	struct k_timer hold_timer;
	struct uart_config config;
	/* paced only */
	bool paced;
	struct k_timer tx_timer;
	struct k_timer rx_timer;
	size_t rx_visible;
	size_t rx_group;
	size_t tx_length; /* in the shifter; 0: idle */
	uint8_t tx_shift[TX_SHIFT_SIZE];
};

/* The chip does not answer. */
static bool is_silent(const struct uart_host_data *data)
{
	const enum board_fault_kind kind = fault_of(data->chip)->kind;

	return kind == BOARD_FAULT_NEVER || kind == BOARD_FAULT_ERROR;
}

static size_t rx_count(const struct uart_host_data *data)
{
	if (is_silent(data)) {
		return 0;
	}
	return data->paced ? data->rx_visible : uart_host_wire_available(data->wire);
}

static bool is_tx_ready(const struct uart_host_data *data)
{
	return data->tx_enabled && data->tx_length == 0 && !is_silent(data);
}

static bool is_pending(const struct uart_host_data *data)
{
	return (data->rx_enabled && rx_count(data) > 0) || is_tx_ready(data);
}

/* Level-triggered, as a real one: again until nothing is pending, or the callback leaves it at
 * that. */
static void isr(void *arg)
{
	const struct device *dev = arg;
	struct uart_host_data *data = dev->data;

	do {
		data->moved = false;
		if (data->callback == NULL || !is_pending(data)) {
			return;
		}
		data->callback(dev, data->user_data);
	} while (data->moved);
}

static k_timeout_t time_of(const struct uart_host_data *data, size_t bytes)
{
	const uint64_t bits = (uint64_t)bytes * BITS_PER_BYTE;
	const struct board_fault *const fault = fault_of(data->chip);

	if (fault->kind == BOARD_FAULT_LATE) {
		return K_USEC(fault->delay_us);
	}
	return K_USEC((bits * 1000000u + data->config.baudrate - 1) / data->config.baudrate);
}

static void start_rx_group(struct uart_host_data *data)
{
	const size_t hidden = uart_host_wire_available(data->wire) - data->rx_visible;

	data->rx_group = MIN(hidden, RX_GROUP);
	if (data->rx_group > 0) {
		k_timer_start(&data->rx_timer, time_of(data, data->rx_group), K_NO_WAIT);
	}
}

/* Several peers share the wire: what they do not say to the end is given up in time. */
static void on_hold_timer(struct k_timer *timer)
{
	struct uart_host_data *data = CONTAINER_OF(timer, struct uart_host_data, hold_timer);

	uart_host_wire_expire(data->wire);
}

static void on_rx(void *arg)
{
	const struct device *dev = arg;
	struct uart_host_data *data = dev->data;
	const uint64_t hold_us = uart_host_wire_hold_us(data->wire);

	if (hold_us > 0) {
		k_timer_start(&data->hold_timer, K_USEC(hold_us), K_NO_WAIT);
	}
	if (data->paced) {
		if (data->rx_group == 0) {
			start_rx_group(data);
		}
	} else if (data->rx_enabled) {
		native_irq_raise(&data->irq);
	}
}

static void on_rx_timer(struct k_timer *timer)
{
	struct uart_host_data *data = CONTAINER_OF(timer, struct uart_host_data, rx_timer);

	data->rx_visible += data->rx_group;
	start_rx_group(data);
	if (data->rx_enabled) {
		native_irq_raise(&data->irq);
	}
}

static void on_tx_timer(struct k_timer *timer)
{
	struct uart_host_data *data = CONTAINER_OF(timer, struct uart_host_data, tx_timer);

	uart_host_wire_write(data->wire, data->tx_shift, data->tx_length);
	data->tx_length = 0;
	if (data->tx_enabled) {
		native_irq_raise(&data->irq);
	}
}

static size_t take(struct uart_host_data *data, uint8_t *bytes, size_t size)
{
	const size_t n = uart_host_wire_read(data->wire, bytes, MIN(size, rx_count(data)));

	if (data->paced) {
		data->rx_visible -= n;
	}
	data->moved |= n > 0;
	return n;
}

static int poll_in(const struct device *dev, unsigned char *byte)
{
	return take(dev->data, byte, 1) == 1 ? 0 : -1;
}

static void poll_out(const struct device *dev, unsigned char byte)
{
	struct uart_host_data *data = dev->data;

	if (data->paced) {
		k_busy_wait((uint32_t)(BITS_PER_BYTE * 1000000u / data->config.baudrate));
	}
	uart_host_wire_put(data->wire, byte);
}

static int err_check(const struct device *dev)
{
	ARG_UNUSED(dev);
	return 0; /* an overrun cannot happen: the rest waits at the host */
}

static int configure(const struct device *dev, const struct uart_config *cfg)
{
	struct uart_host_data *data = dev->data;

	if (cfg->baudrate == 0 || cfg->parity != UART_CFG_PARITY_NONE ||
	    cfg->stop_bits != UART_CFG_STOP_BITS_1 || cfg->data_bits != UART_CFG_DATA_BITS_8 ||
	    cfg->flow_ctrl != UART_CFG_FLOW_CTRL_NONE ||
	    uart_host_wire_set_baud(data->wire, cfg->baudrate) != 0) {
		return -ENOTSUP;
	}
	data->config = *cfg;
	return 0;
}

static int config_get(const struct device *dev, struct uart_config *cfg)
{
	const struct uart_host_data *data = dev->data;

	*cfg = data->config;
	return 0;
}

static int fifo_fill(const struct device *dev, const uint8_t *bytes, int size)
{
	struct uart_host_data *data = dev->data;
	size_t n;

	if (size <= 0 || data->tx_length > 0) {
		return 0;
	}
	data->moved = true;
	if (!data->paced && fault_of(data->chip)->kind != BOARD_FAULT_LATE) {
		return (int)uart_host_wire_write(data->wire, bytes, (size_t)size);
	}
	n = MIN((size_t)size, sizeof(data->tx_shift));
	memcpy(data->tx_shift, bytes, n);
	data->tx_length = n;
	k_timer_start(&data->tx_timer, time_of(data, n), K_NO_WAIT);
	return (int)n;
}

static int fifo_read(const struct device *dev, uint8_t *bytes, const int size)
{
	return size > 0 ? (int)take(dev->data, bytes, (size_t)size) : 0;
}

static void raise_if_pending(struct uart_host_data *data)
{
	if (data->callback != NULL && is_pending(data)) {
		native_irq_raise(&data->irq);
	}
}

static void irq_tx_enable(const struct device *dev)
{
	struct uart_host_data *data = dev->data;

	data->tx_enabled = true;
	raise_if_pending(data);
}

static void irq_tx_disable(const struct device *dev)
{
	struct uart_host_data *data = dev->data;

	data->tx_enabled = false;
	data->moved = true;
}

static int irq_tx_ready(const struct device *dev)
{
	const struct uart_host_data *data = dev->data;

	return is_tx_ready(data) ? 1 : 0;
}

static void irq_rx_enable(const struct device *dev)
{
	struct uart_host_data *data = dev->data;

	data->rx_enabled = true;
	raise_if_pending(data);
}

static void irq_rx_disable(const struct device *dev)
{
	struct uart_host_data *data = dev->data;

	data->rx_enabled = false;
	data->moved = true;
}

static int irq_tx_complete(const struct device *dev)
{
	const struct uart_host_data *data = dev->data;

	return data->tx_length == 0 ? 1 : 0;
}

static int irq_rx_ready(const struct device *dev)
{
	const struct uart_host_data *data = dev->data;

	return data->rx_enabled && rx_count(data) > 0 ? 1 : 0;
}

/* There are no receive errors to tell of. */
static void irq_err_switch(const struct device *dev)
{
	ARG_UNUSED(dev);
}

static int irq_is_pending(const struct device *dev)
{
	return is_pending(dev->data) ? 1 : 0;
}

static int irq_update(const struct device *dev)
{
	ARG_UNUSED(dev);
	return 1;
}

static void irq_callback_set(const struct device *dev, uart_irq_callback_user_data_t callback,
                             void *user_data)
{
	struct uart_host_data *data = dev->data;

	data->callback = callback;
	data->user_data = user_data;
}

static const struct uart_driver_api api = {
	.poll_in = poll_in,
	.poll_out = poll_out,
	.err_check = err_check,
	.configure = configure,
	.config_get = config_get,
	.fifo_fill = fifo_fill,
	.fifo_read = fifo_read,
	.irq_tx_enable = irq_tx_enable,
	.irq_tx_disable = irq_tx_disable,
	.irq_tx_ready = irq_tx_ready,
	.irq_rx_enable = irq_rx_enable,
	.irq_rx_disable = irq_rx_disable,
	.irq_tx_complete = irq_tx_complete,
	.irq_rx_ready = irq_rx_ready,
	.irq_err_enable = irq_err_switch,
	.irq_err_disable = irq_err_switch,
	.irq_is_pending = irq_is_pending,
	.irq_update = irq_update,
	.irq_callback_set = irq_callback_set,
};

static int init(const struct device *dev)
{
	const struct uart_host_config *config = dev->config;
	struct uart_host_data *data = dev->data;

	data->wire = uart_host_wire_find(config->wire);
	if (data->wire == NULL) {
		return -ENODEV;
	}
	data->chip = fault_chip(config->wire);
	if (fault_start(data->chip) != 0) {
		return -EIO;
	}
	data->irq = (struct native_irq){.isr = isr, .arg = (void *)(uintptr_t)dev};
	data->paced = uart_host_wire_paced(data->wire);
	data->config = (struct uart_config){
		.baudrate = uart_host_wire_baud(data->wire),
		.parity = UART_CFG_PARITY_NONE,
		.stop_bits = UART_CFG_STOP_BITS_1,
		.data_bits = UART_CFG_DATA_BITS_8,
		.flow_ctrl = UART_CFG_FLOW_CTRL_NONE,
	};
	k_timer_init(&data->tx_timer, on_tx_timer, NULL);
	k_timer_init(&data->rx_timer, on_rx_timer, NULL);
	k_timer_init(&data->hold_timer, on_hold_timer, NULL);
	uart_host_wire_open(data->wire, on_rx, (void *)(uintptr_t)dev);
	return 0;
}

#define UART_HOST_DEFINE(inst)                                                                     \
	static struct uart_host_data uart_host_data_##inst;                                        \
	static const struct uart_host_config uart_host_config_##inst = {                           \
		.wire = DT_INST_PROP(inst, wire),                                                  \
	};                                                                                         \
	DEVICE_DT_INST_DEFINE(inst, init, NULL, &uart_host_data_##inst, &uart_host_config_##inst,  \
	                      PRE_KERNEL_1, CONFIG_KERNEL_INIT_PRIORITY_DEVICE, &api);

DT_INST_FOREACH_STATUS_OKAY(UART_HOST_DEFINE)
