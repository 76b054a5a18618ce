/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_uart_polled

#include <errno.h>
#include <string.h>

#include <zephyr/device.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>

#include <pharos/compat.h>

/* Bytes read ahead of the application in one period. */
#define FIFO_SIZE 256

struct uart_polled_config {
	const struct device *uart;
	uint32_t period_us;
};

struct uart_polled_data {
	struct k_timer timer;
	uart_irq_callback_user_data_t callback;
	void *user_data;
	bool rx_enabled;
	bool tx_enabled;
	uint32_t count;
	uint8_t fifo[FIFO_SIZE];
};

static int uart_polled_poll_in(const struct device *dev, unsigned char *byte)
{
	const struct uart_polled_config *config = dev->config;

	return uart_poll_in(config->uart, byte);
}

static void uart_polled_poll_out(const struct device *dev, unsigned char byte)
{
	const struct uart_polled_config *config = dev->config;

	uart_poll_out(config->uart, byte);
}

static int uart_polled_fifo_fill(const struct device *dev, const uint8_t *bytes, int length)
{
	for (int i = 0; i < length; i++) {
		uart_polled_poll_out(dev, bytes[i]);
	}
	return length;
}

static int uart_polled_fifo_read(const struct device *dev, uint8_t *bytes, const int size)
{
	struct uart_polled_data *data = dev->data;
	const uint32_t count = MIN((uint32_t)size, data->count);

	memcpy(bytes, data->fifo, count);
	data->count -= count;
	memmove(data->fifo, &data->fifo[count], data->count);
	return (int)count;
}

static void uart_polled_tx_enable(const struct device *dev)
{
	struct uart_polled_data *data = dev->data;

	data->tx_enabled = true;
}

static void uart_polled_tx_disable(const struct device *dev)
{
	struct uart_polled_data *data = dev->data;

	data->tx_enabled = false;
}

static int uart_polled_tx_ready(const struct device *dev)
{
	const struct uart_polled_data *data = dev->data;

	return data->tx_enabled ? 1 : 0;
}

static void uart_polled_rx_enable(const struct device *dev)
{
	struct uart_polled_data *data = dev->data;

	data->rx_enabled = true;
}

static void uart_polled_rx_disable(const struct device *dev)
{
	struct uart_polled_data *data = dev->data;

	data->rx_enabled = false;
}

static int uart_polled_rx_ready(const struct device *dev)
{
	const struct uart_polled_data *data = dev->data;

	return data->rx_enabled && data->count > 0 ? 1 : 0;
}

static int uart_polled_is_pending(const struct device *dev)
{
	return uart_polled_rx_ready(dev) + uart_polled_tx_ready(dev) > 0 ? 1 : 0;
}

static void uart_polled_callback_set(const struct device *dev,
                                     uart_irq_callback_user_data_t callback, void *user_data)
{
	struct uart_polled_data *data = dev->data;

	data->callback = callback;
	data->user_data = user_data;
}

/* The interrupt: at most as many rounds as a full queue of frames has. */
static void poll(struct k_timer *timer)
{
	const struct device *const dev = k_timer_user_data_get(timer);
	struct uart_polled_data *data = dev->data;

	while (data->count < FIFO_SIZE && uart_polled_poll_in(dev, &data->fifo[data->count]) == 0) {
		data->count++;
	}
	for (int rounds = 0; rounds < 16 && uart_polled_is_pending(dev) != 0; rounds++) {
		if (data->callback == NULL) {
			return;
		}
		data->callback(dev, data->user_data);
	}
}

static int uart_polled_init(const struct device *dev)
{
	const struct uart_polled_config *config = dev->config;
	struct uart_polled_data *data = dev->data;

	if (!device_is_ready(config->uart)) {
		return -ENODEV;
	}
	k_timer_init(&data->timer, poll, NULL);
	k_timer_user_data_set(&data->timer, (void *)dev);
	k_timer_start(&data->timer, K_USEC(config->period_us), K_USEC(config->period_us));
	return 0;
}

static DEVICE_API(uart, uart_polled_api) = {
	.poll_in = uart_polled_poll_in,
	.poll_out = uart_polled_poll_out,
	.fifo_fill = uart_polled_fifo_fill,
	.fifo_read = uart_polled_fifo_read,
	.irq_tx_enable = uart_polled_tx_enable,
	.irq_tx_disable = uart_polled_tx_disable,
	.irq_tx_ready = uart_polled_tx_ready,
	.irq_rx_enable = uart_polled_rx_enable,
	.irq_rx_disable = uart_polled_rx_disable,
	.irq_rx_ready = uart_polled_rx_ready,
	.irq_is_pending = uart_polled_is_pending,
	.irq_callback_set = uart_polled_callback_set,
};

#define UART_POLLED_DEFINE(inst)                                                                   \
	static struct uart_polled_data uart_polled_data_##inst;                                    \
	static const struct uart_polled_config uart_polled_config_##inst = {                       \
		.uart = DEVICE_DT_GET(DT_INST_PHANDLE(inst, uart)),                                \
		.period_us = DT_INST_PROP(inst, period_us),                                        \
	};                                                                                         \
	DEVICE_DT_INST_DEFINE(inst, uart_polled_init, NULL, &uart_polled_data_##inst,              \
	                      &uart_polled_config_##inst, POST_KERNEL,                             \
	                      CONFIG_PHAROS_DRIVERS_INIT_PRIORITY, &uart_polled_api);

DT_INST_FOREACH_STATUS_OKAY(UART_POLLED_DEFINE)
