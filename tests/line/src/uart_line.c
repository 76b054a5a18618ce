/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A UART with a FIFO in each direction, as an STM32's. A byte that is complete while the FIFO is
 * full is lost. The byte clock is a timer whose interrupt nothing can lock out; what it does costs
 * the processor some sixty instructions.
 */
#define DT_DRV_COMPAT pharos_uart_line

#include "uart_line.h"

#include <zephyr/arch/cpu.h>
#include <zephyr/device.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/irq.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/sys_io.h>

#include <pharos/compat.h>

#define RATE         DT_INST_PROP(0, current_speed)
#define IRQ          DT_INST_IRQ_BY_NAME(0, uart, irq)
#define IRQ_PRIORITY DT_INST_IRQ_BY_NAME(0, uart, priority)
#define TIMER_IRQ    DT_INST_IRQ_BY_NAME(0, timer, irq)
#define FIFO_SIZE    DT_INST_PROP(0, fifo_bytes)
#define FRAME_BITS   10u

/* Arm CMSDK timer, DDI0479, section 4.4. */
#define TIMER        DT_REG_ADDR(DT_INST_PHANDLE(0, timer))
#define TIMER_CTRL   (TIMER + 0x0)
#define TIMER_VALUE  (TIMER + 0x4)
#define TIMER_RELOAD (TIMER + 0x8)
#define TIMER_CLEAR  (TIMER + 0xC)
#define TIMER_RUN    0x9u /* counts, and interrupts at 0 */

/* Armv7-M, NVIC_ISPR0: makes an interrupt pending. */
#define NVIC_ISPR0 0xE000E200u

struct fifo {
	uint32_t count;
	uint8_t bytes[FIFO_SIZE]; /* the oldest first */
};

static struct {
	uart_irq_callback_user_data_t callback;
	void *user_data;
	bool rx_enabled;
	bool tx_enabled;
	struct fifo rx;
	struct fifo tx;
	const uint8_t *bytes;
	size_t count;
	uint8_t *kept;
	size_t room;
	struct uart_line_result result;
} volatile line;

/* --- hardware --------------------------------------------------------------------------------- */

/* Both with the byte clock locked out, or in it. */

static void put(volatile struct fifo *fifo, uint8_t byte)
{
	fifo->bytes[fifo->count] = byte;
	fifo->count++;
}

static uint8_t get(volatile struct fifo *fifo)
{
	const uint8_t byte = fifo->bytes[0];

	fifo->count--;
	for (uint32_t i = 0; i < fifo->count; i++) {
		fifo->bytes[i] = fifo->bytes[i + 1];
	}
	return byte;
}

/* For the few instructions that hardware would do in one step. */
static inline void lock_byte_clock(void)
{
	__asm__ volatile("cpsid i" ::: "memory");
}

static inline void unlock_byte_clock(void)
{
	__asm__ volatile("cpsie i" ::: "memory");
}

static inline bool wants_interrupt(void)
{
	return (line.rx_enabled && line.rx.count > 0) ||
	       (line.tx_enabled && line.tx.count < FIFO_SIZE);
}

static inline void interrupt_if_wanted(void)
{
	if (wants_interrupt()) {
		sys_write32(BIT(IRQ), NVIC_ISPR0);
	}
}

/* One byte has passed in each direction. */
ISR_DIRECT_DECLARE(byte_clock)
{
	sys_write32(1, TIMER_CLEAR);
	if (line.tx.count > 0 && line.result.received < line.room) {
		line.kept[line.result.received++] = get(&line.tx);
	}
	if (line.result.sent < line.count) {
		const uint8_t byte = line.bytes[line.result.sent++];

		if (line.rx.count == FIFO_SIZE) {
			line.result.overruns++;
		} else {
			put(&line.rx, byte);
			line.result.most = MAX(line.result.most, line.rx.count);
		}
	}
	interrupt_if_wanted();
	return 0;
}

static void line_interrupt(const void *unused)
{
	if (line.callback != NULL) {
		line.callback(DEVICE_DT_INST_GET(0), line.user_data);
	}
	interrupt_if_wanted();
}

void uart_line_start(const uint8_t *bytes, size_t count, uint8_t *kept, size_t room)
{
	line.bytes = bytes;
	line.count = count;
	line.kept = kept;
	line.room = room;
	line.result = (struct uart_line_result){0};
	sys_write32(sys_clock_hw_cycles_per_sec() / (RATE / FRAME_BITS) - 1, TIMER_RELOAD);
	sys_write32(sys_clock_hw_cycles_per_sec() / (RATE / FRAME_BITS) - 1, TIMER_VALUE);
	sys_write32(TIMER_RUN, TIMER_CTRL);
}

struct uart_line_result uart_line_stop(void)
{
	sys_write32(0, TIMER_CTRL);
	return (struct uart_line_result){
		.sent = line.result.sent,
		.received = line.result.received,
		.overruns = line.result.overruns,
		.most = line.result.most,
	};
}

/* --- driver ----------------------------------------------------------------------------------- */

static int uart_line_poll_in(const struct device *dev, unsigned char *byte)
{
	return -1;
}

static void uart_line_poll_out(const struct device *dev, unsigned char byte)
{
}

static int uart_line_config_get(const struct device *dev, struct uart_config *config)
{
	*config = (struct uart_config){.baudrate = RATE, .data_bits = UART_CFG_DATA_BITS_8};
	return 0;
}

static int uart_line_fifo_fill(const struct device *dev, const uint8_t *bytes, int length)
{
	int filled = 0;

	while (filled < length && line.tx.count < FIFO_SIZE) {
		lock_byte_clock();
		put(&line.tx, bytes[filled++]);
		unlock_byte_clock();
	}
	return filled;
}

static int uart_line_fifo_read(const struct device *dev, uint8_t *bytes, const int size)
{
	int taken = 0;

	while (taken < size && line.rx.count > 0) {
		lock_byte_clock();
		bytes[taken++] = get(&line.rx);
		unlock_byte_clock();
	}
	return taken;
}

static void uart_line_tx_enable(const struct device *dev)
{
	line.tx_enabled = true;
	interrupt_if_wanted();
}

static void uart_line_tx_disable(const struct device *dev)
{
	line.tx_enabled = false;
}

static int uart_line_tx_ready(const struct device *dev)
{
	return line.tx_enabled && line.tx.count < FIFO_SIZE ? 1 : 0;
}

static void uart_line_rx_enable(const struct device *dev)
{
	line.rx_enabled = true;
	interrupt_if_wanted();
}

static void uart_line_rx_disable(const struct device *dev)
{
	line.rx_enabled = false;
}

static int uart_line_rx_ready(const struct device *dev)
{
	return line.rx.count > 0 ? 1 : 0;
}

static int uart_line_is_pending(const struct device *dev)
{
	return wants_interrupt() ? 1 : 0;
}

static void uart_line_callback_set(const struct device *dev, uart_irq_callback_user_data_t callback,
                                   void *user_data)
{
	line.callback = callback;
	line.user_data = user_data;
}

static int uart_line_init(const struct device *dev)
{
	IRQ_CONNECT(IRQ, IRQ_PRIORITY, line_interrupt, NULL, 0);
	IRQ_DIRECT_CONNECT(TIMER_IRQ, 0, byte_clock, IRQ_ZERO_LATENCY);
	irq_enable(IRQ);
	irq_enable(TIMER_IRQ);
	return 0;
}

static DEVICE_API(uart, uart_line_api) = {
	.poll_in = uart_line_poll_in,
	.poll_out = uart_line_poll_out,
	.config_get = uart_line_config_get,
	.fifo_fill = uart_line_fifo_fill,
	.fifo_read = uart_line_fifo_read,
	.irq_tx_enable = uart_line_tx_enable,
	.irq_tx_disable = uart_line_tx_disable,
	.irq_tx_ready = uart_line_tx_ready,
	.irq_rx_enable = uart_line_rx_enable,
	.irq_rx_disable = uart_line_rx_disable,
	.irq_rx_ready = uart_line_rx_ready,
	.irq_is_pending = uart_line_is_pending,
	.irq_callback_set = uart_line_callback_set,
};

DEVICE_DT_INST_DEFINE(0, uart_line_init, NULL, NULL, NULL, POST_KERNEL,
                      CONFIG_PHAROS_DRIVERS_INIT_PRIORITY, &uart_line_api);
