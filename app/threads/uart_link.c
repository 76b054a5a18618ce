/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/uart_link.h"

#include <errno.h>
#include <string.h>

#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/ring_buffer.h>

#include <pharos/drivers/strap.h>

#include "threads/devices.h"
#include "threads/link.h"
#include "threads/startup.h"
#include "threads/supervisor.h"
#include "threads/uart_framing.h"

#define FRAME_BITS 10u /* start, 8 data, stop */

/* While the thread wakes and takes that many, the rest of the ring fills. */
#define RX_WANTED_MAX (UART_RX_RING_SIZE / 4)

/* A silent line is noticed that much late at most: in these steps the thread looks for bytes. */
#define SILENCE_STEP_US (MAVLINK_FRAMER_IDLE_US / 5)

struct uart_link {
	enum uart_protocol protocol;
	struct ring_buf rx; /* the interrupt puts, the thread takes */
	struct ring_buf
		tx; /* the command thread puts frames with their length, the interrupt takes */
#ifdef CONFIG_PHAROS_ROUTING
	struct ring_buf forward; /* the same, of others' frames: taken while tx is empty */
#endif
	struct k_sem rx_ready;
	atomic_t rx_wanted; /* bytes in the ring that wake the thread */
	bool rx_stopped;
	const struct uart_framing *framing;
	union uart_framing_state state; /* the framing's */
	struct link_stats stats;
	uint16_t sending_length; /* the frame that the interrupt is sending; 0: none */
	uint16_t sending_at;
	uint8_t sending[UART_FRAME_MAX];
	uint8_t rx_bytes[UART_RX_RING_SIZE];
	uint8_t tx_bytes[UART_TX_RING_SIZE];
#ifdef CONFIG_PHAROS_ROUTING
	uint8_t forward_bytes[UART_FORWARD_RING_SIZE];
#endif
};

static struct uart_link links[UART_LINKS_MAX];

/* --- interrupt -------------------------------------------------------------------------------- */

/* Waking the thread costs what several bytes do: only when the framing can say more. */
static void wake_if_enough(struct uart_link *link)
{
	if (ring_buf_size_get(&link->rx) >= (uint32_t)atomic_get(&link->rx_wanted)) {
		k_sem_give(&link->rx_ready);
	}
}

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
	wake_if_enough(link);
}

static bool take_from(struct uart_link *link, struct ring_buf *queue)
{
	uint16_t length;

	if (ring_buf_is_empty(queue)) {
		return false;
	}
	ring_buf_get(queue, (uint8_t *)&length, sizeof(length));
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
	return link < UART_LINKS_MAX && startup_result(STARTUP_UART_LINK0 + link) == 0
	               ? &links[link]
	               : NULL;
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

enum uart_protocol uart_link_protocol(uint8_t number)
{
	const struct uart_link *const link = find(number);

	return link != NULL ? link->protocol : UART_PROTOCOL_NONE;
}

uint32_t uart_link_rate(uint8_t number)
{
	struct uart_config config;

	if (find(number) == NULL) {
		return 0;
	}
	if (uart_config_get(devices.uart_links[number], &config) != 0) {
		config.baudrate = devices.uart_bauds[number]; /* it cannot be another */
	}
	return config.baudrate / FRAME_BITS;
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
	stats->framing = link->framing->stats(&link->state);
	irq_unlock(key);
	return 0;
}

/* --- receiving -------------------------------------------------------------------------------- */

/* To the command thread, which takes each before this one goes on. */
static void post(uint8_t number, struct uart_link *link, const union uart_packet *packet)
{
	link->framing->post(number, packet);
	link->stats.rx_frames++;
}

static void post_all(uint8_t number, struct uart_link *link)
{
	union uart_packet packet;

	while (link->framing->next(&link->state, &packet)) {
		post(number, link, &packet);
	}
}

static void take(uint8_t number, struct uart_link *link, const uint8_t *bytes, size_t count)
{
	for (size_t used = 0; used < count;) {
		used += link->framing->write(&link->state, bytes + used, count - used);
		post_all(number, link);
	}
}

/* The line is silent. */
static void give_up(uint8_t number, struct uart_link *link)
{
	union uart_packet packet;

	while (link->framing->idle(&link->state, &packet)) {
		post(number, link, &packet);
		post_all(number, link);
	}
}

/*
 * All bytes of the ring through the framing; room in the ring resumes reception. False: there were
 * none.
 */
static bool drain(uint8_t number, struct uart_link *link)
{
	uint8_t *from;
	uint32_t count;
	bool any = false;

	while ((count = ring_buf_get_claim(&link->rx, &from, UART_RX_RING_SIZE)) > 0) {
		take(number, link, from, count);
		ring_buf_get_finish(&link->rx, count);
		if (link->rx_stopped) {
			link->rx_stopped = false;
			uart_irq_rx_enable(devices.uart_links[number]);
		}
		any = true;
	}
	return any;
}

/* --- start and thread ------------------------------------------------------------------------- */

/* What the UART's strap says that it speaks, or else its parameter. */
static enum uart_protocol choose(uint8_t number, const struct params *params)
{
#ifdef CONFIG_PHAROS_IMC
	const int strap = strap_get(startup_ready(STARTUP_STRAP, devices.strap),
	                            (enum strap)(STRAP_UART0_PROTOCOL + number));

	return (enum uart_protocol)(
		strap != STRAP_OPEN ? strap : params->values[PARAM_UART0_PROTO + number]);
#else
	return UART_PROTOCOL_MAVLINK;
#endif
}

static void init_framing(struct uart_link *link, uint8_t number, const struct params *params)
{
	static const struct uart_framing *const framings[] = {
		[UART_PROTOCOL_MAVLINK] = &uart_framing_mavlink,
#ifdef CONFIG_PHAROS_IMC
		[UART_PROTOCOL_IMC] = &uart_framing_imc,
#endif
	};

	link->protocol = choose(number, params);
	link->framing = framings[link->protocol];
	link->framing->init(&link->state);
}

void uart_links_init(const struct params *params)
{
	for (uint8_t number = 0; number < UART_LINKS_MAX; number++) {
		struct uart_link *const link = find(number);
		const struct device *const uart = devices.uart_links[number];

		if (link == NULL) {
			continue;
		}
		ring_buf_init(&link->rx, sizeof(link->rx_bytes), link->rx_bytes);
		ring_buf_init(&link->tx, sizeof(link->tx_bytes), link->tx_bytes);
#ifdef CONFIG_PHAROS_ROUTING
		ring_buf_init(&link->forward, sizeof(link->forward_bytes), link->forward_bytes);
#endif
		k_sem_init(&link->rx_ready, 0, 1);
		init_framing(link, number, params);
		uart_irq_callback_user_data_set(uart, uart_interrupt, link);
		uart_irq_rx_enable(uart);
	}
}

void uart_link_run(void *argument, void *p2, void *p3)
{
	const uint8_t number = (uint8_t)(uintptr_t)argument;
	struct uart_link *const link = &links[number];

	for (uint32_t silent_us = 0;;) {
		const bool unfinished = link->framing->pending(&link->state);
		const k_timeout_t wait =
			unfinished ? K_USEC(SILENCE_STEP_US) : K_MSEC(SUPERVISOR_REPORT_MS);

		atomic_set(&link->rx_wanted,
		           (atomic_val_t)MIN(link->framing->wanted(&link->state), RX_WANTED_MAX));
		wake_if_enough(link); /* what came before the interrupt knew */
		supervisor_report(SUPERVISOR_UART_LINK0 + number);

		const bool woken = k_sem_take(&link->rx_ready, wait) == 0;
		const bool silent = !drain(number, link) && !woken && unfinished;

		silent_us = silent ? silent_us + SILENCE_STEP_US : 0;
		if (silent_us >= MAVLINK_FRAMER_IDLE_US) {
			silent_us = 0;
			give_up(number, link);
		}
	}
}
