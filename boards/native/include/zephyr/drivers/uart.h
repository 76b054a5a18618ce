/* SPDX-License-Identifier: Apache-2.0 */
/*
 * UART, by Zephyr's names: the polling and the interrupt-driven API.
 *
 * The callback runs in interrupt context and is one loop:
 *
 *   while (uart_irq_update(dev) && uart_irq_is_pending(dev)) {
 *           if (uart_irq_rx_ready(dev)) { n = uart_fifo_read(dev, buffer, sizeof(buffer)); … }
 *           if (uart_irq_tx_ready(dev)) { n = uart_fifo_fill(dev, data, length); … }
 *   }
 *
 * with uart_irq_tx_disable(dev) when there is nothing left to send.
 *
 * On the native board one uart_fifo_fill() is one datagram of the wire.
 */
#ifndef ZEPHYR_DRIVERS_UART_H_
#define ZEPHYR_DRIVERS_UART_H_

#include <errno.h>
#include <stdint.h>

#include <zephyr/device.h>

/* Errors, as flags of uart_err_check(). */
enum uart_rx_stop_reason {
	UART_ERROR_OVERRUN = 1 << 0,
	UART_ERROR_PARITY = 1 << 1,
	UART_ERROR_FRAMING = 1 << 2,
	UART_BREAK = 1 << 3,
};

enum uart_config_parity {
	UART_CFG_PARITY_NONE,
	UART_CFG_PARITY_ODD,
	UART_CFG_PARITY_EVEN,
	UART_CFG_PARITY_MARK,
	UART_CFG_PARITY_SPACE,
};

enum uart_config_stop_bits {
	UART_CFG_STOP_BITS_0_5,
	UART_CFG_STOP_BITS_1,
	UART_CFG_STOP_BITS_1_5,
	UART_CFG_STOP_BITS_2,
};

enum uart_config_data_bits {
	UART_CFG_DATA_BITS_5,
	UART_CFG_DATA_BITS_6,
	UART_CFG_DATA_BITS_7,
	UART_CFG_DATA_BITS_8,
	UART_CFG_DATA_BITS_9,
};

enum uart_config_flow_control {
	UART_CFG_FLOW_CTRL_NONE,
	UART_CFG_FLOW_CTRL_RTS_CTS,
	UART_CFG_FLOW_CTRL_DTR_DSR,
};

struct uart_config {
	uint32_t baudrate; /* bits/s */
	uint8_t parity;
	uint8_t stop_bits;
	uint8_t data_bits;
	uint8_t flow_ctrl;
};

typedef void (*uart_irq_callback_user_data_t)(const struct device *dev, void *user_data);

struct uart_driver_api {
	int (*poll_in)(const struct device *dev, unsigned char *p_char);
	void (*poll_out)(const struct device *dev, unsigned char out_char);
	int (*err_check)(const struct device *dev);
	int (*configure)(const struct device *dev, const struct uart_config *cfg);
	int (*config_get)(const struct device *dev, struct uart_config *cfg);
	int (*fifo_fill)(const struct device *dev, const uint8_t *tx_data, int len);
	int (*fifo_read)(const struct device *dev, uint8_t *rx_data, const int size);
	void (*irq_tx_enable)(const struct device *dev);
	void (*irq_tx_disable)(const struct device *dev);
	int (*irq_tx_ready)(const struct device *dev);
	void (*irq_rx_enable)(const struct device *dev);
	void (*irq_rx_disable)(const struct device *dev);
	int (*irq_tx_complete)(const struct device *dev);
	int (*irq_rx_ready)(const struct device *dev);
	void (*irq_err_enable)(const struct device *dev);
	void (*irq_err_disable)(const struct device *dev);
	int (*irq_is_pending)(const struct device *dev);
	int (*irq_update)(const struct device *dev);
	void (*irq_callback_set)(const struct device *dev, uart_irq_callback_user_data_t cb,
	                         void *user_data);
};

#define UART_API(dev) ((const struct uart_driver_api *)(dev)->api)

/* 0: *p_char is the next byte. -1: there is none. Any context. */
static inline int uart_poll_in(const struct device *dev, unsigned char *p_char)
{
	return UART_API(dev)->poll_in(dev, p_char);
}

/* Sends one byte; waits while the transmitter is busy. Any context. */
static inline void uart_poll_out(const struct device *dev, unsigned char out_char)
{
	UART_API(dev)->poll_out(dev, out_char);
}

/* UART_ERROR_… since the last call. Any context. */
static inline int uart_err_check(const struct device *dev)
{
	return UART_API(dev)->err_check(dev);
}

/* 0, or -ENOTSUP for what the wire cannot do; then nothing is changed. Threads. */
static inline int uart_configure(const struct device *dev, const struct uart_config *cfg)
{
	return UART_API(dev)->configure(dev, cfg);
}

static inline int uart_config_get(const struct device *dev, struct uart_config *cfg)
{
	return UART_API(dev)->config_get(dev, cfg);
}

/* How many of `size` bytes were taken; 0 while uart_irq_tx_ready() is 0. Callback only. */
static inline int uart_fifo_fill(const struct device *dev, const uint8_t *tx_data, int size)
{
	return UART_API(dev)->fifo_fill(dev, tx_data, size);
}

/* How many bytes were read, at most size. Callback only. */
static inline int uart_fifo_read(const struct device *dev, uint8_t *rx_data, const int size)
{
	return UART_API(dev)->fifo_read(dev, rx_data, size);
}

/* Enabling an interrupt whose condition holds raises it at once. Any context. */
static inline void uart_irq_tx_enable(const struct device *dev)
{
	UART_API(dev)->irq_tx_enable(dev);
}

static inline void uart_irq_tx_disable(const struct device *dev)
{
	UART_API(dev)->irq_tx_disable(dev);
}

static inline void uart_irq_rx_enable(const struct device *dev)
{
	UART_API(dev)->irq_rx_enable(dev);
}

static inline void uart_irq_rx_disable(const struct device *dev)
{
	UART_API(dev)->irq_rx_disable(dev);
}

static inline void uart_irq_err_enable(const struct device *dev)
{
	UART_API(dev)->irq_err_enable(dev);
}

static inline void uart_irq_err_disable(const struct device *dev)
{
	UART_API(dev)->irq_err_disable(dev);
}

/* Above 0: the transmit interrupt is enabled and bytes can be taken. Callback only. */
static inline int uart_irq_tx_ready(const struct device *dev)
{
	return UART_API(dev)->irq_tx_ready(dev);
}

/* 1: everything has left the wire. */
static inline int uart_irq_tx_complete(const struct device *dev)
{
	return UART_API(dev)->irq_tx_complete(dev);
}

/* 1: the receive interrupt is enabled and there are bytes. Callback only. */
static inline int uart_irq_rx_ready(const struct device *dev)
{
	return UART_API(dev)->irq_rx_ready(dev);
}

static inline int uart_irq_is_pending(const struct device *dev)
{
	return UART_API(dev)->irq_is_pending(dev);
}

/* Always 1: starts a round of the callback's loop. */
static inline int uart_irq_update(const struct device *dev)
{
	return UART_API(dev)->irq_update(dev);
}

/* NULL: none. 0. */
static inline int uart_irq_callback_user_data_set(const struct device *dev,
                                                  uart_irq_callback_user_data_t cb, void *user_data)
{
	UART_API(dev)->irq_callback_set(dev, cb, user_data);
	return 0;
}

static inline int uart_irq_callback_set(const struct device *dev, uart_irq_callback_user_data_t cb)
{
	return uart_irq_callback_user_data_set(dev, cb, NULL);
}

#endif
