/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The fixture of the native host's tests: a device that sends back what uart0, uart1 and uart2
 * receive. uart3 says "boot FLAGS" (hwinfo's reset cause) at start and "tick N" each second, N
 * from 1.
 */
#include <stdio.h>
#include <string.h>

#include <zephyr/drivers/hwinfo.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>

#define ECHO_SIZE 4096

struct echo {
	const struct device *uart;
	uint8_t bytes[ECHO_SIZE];
	int length;
};

static struct echo echoes[] = {
	{.uart = DEVICE_DT_GET(DT_NODELABEL(uart0))},
	{.uart = DEVICE_DT_GET(DT_NODELABEL(uart1))},
	{.uart = DEVICE_DT_GET(DT_NODELABEL(uart2))},
};

static const struct device *const speaker = DEVICE_DT_GET(DT_NODELABEL(uart3));

static void on_uart(const struct device *dev, void *user_data)
{
	struct echo *echo = user_data;

	while (uart_irq_update(dev) && uart_irq_is_pending(dev)) {
		if (uart_irq_rx_ready(dev)) {
			echo->length += uart_fifo_read(dev, echo->bytes + echo->length,
			                               ECHO_SIZE - echo->length);
			if (echo->length == ECHO_SIZE) {
				uart_irq_rx_disable(dev);
			}
			uart_irq_tx_enable(dev);
		}
		if (uart_irq_tx_ready(dev)) {
			const int n = uart_fifo_fill(dev, echo->bytes, echo->length);

			memmove(echo->bytes, echo->bytes + n, (size_t)(echo->length - n));
			echo->length -= n;
			if (echo->length == 0) {
				uart_irq_tx_disable(dev);
				uart_irq_rx_enable(dev);
			}
		}
	}
}

static void say(const char *text)
{
	for (; *text != '\0'; text++) {
		uart_poll_out(speaker, (unsigned char)*text);
	}
}

int main(void)
{
	char text[32];
	uint32_t cause;

	for (size_t i = 0; i < ARRAY_SIZE(echoes); i++) {
		(void)uart_irq_callback_user_data_set(echoes[i].uart, on_uart, &echoes[i]);
		uart_irq_rx_enable(echoes[i].uart);
	}
	(void)hwinfo_get_reset_cause(&cause);
	(void)hwinfo_clear_reset_cause();
	(void)snprintf(text, sizeof(text), "boot %u\n", (unsigned int)cause);
	say(text);
	for (unsigned int i = 1;; i++) {
		k_sleep(K_TIMEOUT_ABS_MS(1000 * (int64_t)i));
		(void)snprintf(text, sizeof(text), "tick %u\n", i);
		say(text);
	}
}
