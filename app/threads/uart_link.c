/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/uart_link.h"

#include <errno.h>
#include <string.h>

#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/ring_buffer.h>

#include <pharos/compat.h>

#include "threads/command.h"
#include "threads/devices.h"
#include "threads/link.h"
#include "threads/supervisor.h"

#define BITS_PER_BYTE 10u /* start, 8 data, stop */

struct uart_link {
	struct ring_buf rx; /* the interrupt puts, the thread takes */
	struct ring_buf
		tx; /* the command thread puts frames with their length, the interrupt takes */
#ifdef CONFIG_PHAROS_ROUTING
	struct ring_buf forward; /* the same, of others' frames: taken while tx is empty */
#endif
	struct k_sem rx_ready;
	bool rx_stopped;
	struct mavlink_framer framer;
	struct link_stats stats;
	uint16_t sending_length; /* the frame that the interrupt is sending; 0: none */
	uint16_t sending_at;
	uint8_t sending[MAVLINK_FRAME_MAX];
	uint8_t rx_bytes[UART_RX_RING_SIZE];
	uint8_t tx_bytes[UART_TX_RING_SIZE];
#ifdef CONFIG_PHAROS_ROUTING
	uint8_t forward_bytes[UART_FORWARD_RING_SIZE];
#endif
};

static struct uart_link links[UART_LINKS_MAX];

K_MEM_SLAB_DEFINE_STATIC(frame_pool, ROUND_UP(sizeof(struct link_frame), 8), LINK_FRAMES_MAX, 8);

/* --- interrupt -------------------------------------------------------------------------------- */

/* A full ring stops reception until the thread has made room, so nothing is dropped here. */
static void receive(const struct device *uart, struct uart_link *link)
{
	uint8_t *into;
	const uint32_t room = ring_buf_put_claim(&link->rx, &into, UART_RX_RING_SIZE);

	if (room == 0) {
		link->stats.rx_overruns++;
		link->rx_stopped = true;
		uart_irq_rx_disable(uart);
	} else {
		const int got = uart_fifo_read(uart, into, (int)room);

		ring_buf_put_finish(&link->rx, got > 0 ? (uint32_t)got : 0);
		link->stats.rx_bytes += got > 0 ? (uint32_t)got : 0;
	}
	k_sem_give(&link->rx_ready);
}

static bool take_from(struct uart_link *link, struct ring_buf *queue)
{
	uint16_t length;

	if (ring_buf_get(queue, (uint8_t *)&length, sizeof(length)) == 0) {
		return false;
	}
	ring_buf_get(queue, link->sending, length);
	link->sending_length = length;
	link->sending_at = 0;
	return true;
}

/* The next frame to send, when the last is gone. */
static bool take_frame(struct uart_link *link)
{
	if (link->sending_length > 0 || take_from(link, &link->tx)) {
		return true;
	}
#ifdef CONFIG_PHAROS_ROUTING
	return take_from(link, &link->forward);
#else
	return false;
#endif
}

/* A frame goes to the driver in one piece where the hardware takes it, so one frame is one write.
 */
static void transmit(const struct device *uart, struct uart_link *link)
{
	if (!take_frame(link)) {
		uart_irq_tx_disable(uart);
		return;
	}
	const int sent = uart_fifo_fill(uart, &link->sending[link->sending_at],
	                                link->sending_length - link->sending_at);

	link->sending_at += sent > 0 ? (uint16_t)sent : 0;
	link->stats.tx_bytes += sent > 0 ? (uint32_t)sent : 0;
	if (link->sending_at == link->sending_length) {
		link->sending_length = 0;
		link->stats.tx_frames++;
	}
}

static void uart_interrupt(const struct device *uart, void *user_data)
{
	struct uart_link *const link = user_data;

	uart_irq_update(uart);
	if (uart_err_check(uart) > 0) {
		link->stats.rx_errors++;
	}
	if (uart_irq_rx_ready(uart) > 0) {
		receive(uart, link);
	}
	if (uart_irq_tx_ready(uart) > 0) {
		transmit(uart, link);
	}
}

/* --- links ------------------------------------------------------------------------------------ */

static struct uart_link *find(uint8_t link)
{
	return link < UART_LINKS_MAX && devices.uart_links[link] != NULL ? &links[link] : NULL;
}

/* Puts the whole frame into a queue and has it sent. False: no room. */
static bool enqueue(uint8_t number, struct ring_buf *queue, const uint8_t *frame, size_t length)
{
	const uint16_t prefix = (uint16_t)length;

	if (ring_buf_space_get(queue) < sizeof(prefix) + length) {
		return false;
	}
	/* the interrupt must not see a length without its frame */
	const unsigned int key = irq_lock();

	ring_buf_put(queue, (const uint8_t *)&prefix, sizeof(prefix));
	ring_buf_put(queue, frame, (uint32_t)length);
	irq_unlock(key);
	uart_irq_tx_enable(devices.uart_links[number]);
	return true;
}

int uart_link_send(uint8_t number, const uint8_t *frame, size_t length)
{
	struct uart_link *const link = find(number);

	if (link == NULL) {
		return -ENODEV;
	}
	if (!enqueue(number, &link->tx, frame, length)) {
		link->stats.tx_dropped++;
		return -ENOBUFS;
	}
	return 0;
}

uint32_t uart_link_rate(uint8_t number)
{
	struct uart_config config;

	if (find(number) == NULL || uart_config_get(devices.uart_links[number], &config) != 0) {
		return 0;
	}
	return config.baudrate / BITS_PER_BYTE;
}

#ifdef CONFIG_PHAROS_ROUTING
int uart_link_forward(uint8_t number, const uint8_t *frame, size_t length)
{
	struct uart_link *const link = find(number);

	if (link == NULL) {
		return -ENODEV;
	}
	if (!enqueue(number, &link->forward, frame, length)) {
		link->stats.forward_dropped++;
		return -ENOBUFS;
	}
	link->stats.forwarded++;
	return 0;
}
#endif

int uart_link_stats_get(uint8_t number, struct link_stats *stats)
{
	struct uart_link *const link = find(number);

	if (link == NULL) {
		return -ENODEV;
	}
	const unsigned int key = irq_lock();

	*stats = link->stats;
	stats->framer = link->framer.stats;
	irq_unlock(key);
	return 0;
}

void link_frame_free(struct link_frame *frame)
{
	k_mem_slab_free(&frame_pool, (void *)frame);
}

/* --- thread ----------------------------------------------------------------------------------- */

/* To the command thread, which takes it before this one goes on; waits while it is behind. */
static void post(uint8_t number, struct uart_link *link, const struct mavlink_frame *received)
{
	void *block;

	while (k_mem_slab_alloc(&frame_pool, &block, K_MSEC(SUPERVISOR_REPORT_MS)) != 0) {
		supervisor_report(SUPERVISOR_UART_LINK0 + number);
	}
	struct link_frame *const frame = block;

	frame->link = number;
	frame->length = received->length;
	memcpy(frame->bytes, received->bytes, received->length);
	while (command_post_frame(frame) != 0) {
		supervisor_report(SUPERVISOR_UART_LINK0 + number);
	}
	link->stats.rx_frames++;
}

static void post_all(uint8_t number, struct uart_link *link)
{
	struct mavlink_frame frame;

	while (mavlink_framer_next(&link->framer, &frame)) {
		post(number, link, &frame);
	}
}

/* All bytes of the ring through the framer; room in the ring resumes reception. */
static void drain(uint8_t number, struct uart_link *link)
{
	uint8_t *from;
	uint32_t count;

	link->framer.opaque = link_is_opaque();
	while ((count = ring_buf_get_claim(&link->rx, &from, UART_RX_RING_SIZE)) > 0) {
		for (uint32_t used = 0; used < count;) {
			used += (uint32_t)mavlink_framer_write(&link->framer, from + used,
			                                       count - used);
			post_all(number, link);
		}
		ring_buf_get_finish(&link->rx, count);
		if (link->rx_stopped) {
			link->rx_stopped = false;
			uart_irq_rx_enable(devices.uart_links[number]);
		}
	}
}

/* The line is silent: an unfinished frame was perhaps none, and hides good ones. */
static void idle(uint8_t number, struct uart_link *link)
{
	struct mavlink_frame frame;

	while (mavlink_framer_idle(&link->framer, &frame)) {
		post(number, link, &frame);
		post_all(number, link);
	}
}

void uart_links_init(void)
{
	for (uint8_t number = 0; number < UART_LINKS_MAX; number++) {
		struct uart_link *const link = &links[number];
		const struct device *const uart = devices.uart_links[number];

		if (uart == NULL) {
			continue;
		}
		ring_buf_init(&link->rx, sizeof(link->rx_bytes), link->rx_bytes);
		ring_buf_init(&link->tx, sizeof(link->tx_bytes), link->tx_bytes);
#ifdef CONFIG_PHAROS_ROUTING
		ring_buf_init(&link->forward, sizeof(link->forward_bytes), link->forward_bytes);
#endif
		k_sem_init(&link->rx_ready, 0, 1);
		mavlink_framer_init(&link->framer);
		uart_irq_callback_user_data_set(uart, uart_interrupt, link);
		uart_irq_rx_enable(uart);
	}
}

void uart_link_run(void *argument, void *p2, void *p3)
{
	const uint8_t number = (uint8_t)(uintptr_t)argument;
	struct uart_link *const link = &links[number];

	if (devices.uart_links[number] == NULL) {
		return;
	}
	for (;;) {
		const bool pending = mavlink_framer_pending(&link->framer);
		const k_timeout_t wait =
			pending ? K_USEC(MAVLINK_FRAMER_IDLE_US) : K_MSEC(SUPERVISOR_REPORT_MS);

		supervisor_report(SUPERVISOR_UART_LINK0 + number);
		if (k_sem_take(&link->rx_ready, wait) == 0) {
			drain(number, link);
		} else if (pending) {
			idle(number, link);
		}
	}
}
