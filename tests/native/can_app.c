/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The fixture of the CAN tests: a node that does what uart0 tells it, one command a line, and says
 * there what happens, one event a line, with the uptime in us first.
 *
 *   start MODE BITRATE DATA_BITRATE   (re)starts the controller; MODE: CAN_MODE_… in decimal
 *   stop
 *   send ID FLAGS DLC COUNT           queues frames ID, ID + 1, …; waits at most 1 s for a mailbox
 *   echo N                            answers each frame with its id + N; 0: not (as at first)
 *   quiet N                           N = 1: says nothing about frames
 *   recover MS
 *
 *   T rx ID FLAGS DLC    T sent ID ERROR    T state STATE TX_ERRORS RX_ERRORS    T done RESULT
 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <zephyr/drivers/can.h>
#include <zephyr/drivers/uart.h>
#include <zephyr/kernel.h>

#define LINE_SIZE 80

static const struct device *const can = DEVICE_DT_GET(DT_CHOSEN(zephyr_canbus));
static const struct device *const uart = DEVICE_DT_GET(DT_NODELABEL(uart0));

K_MSGQ_DEFINE(lines, LINE_SIZE, 64, 4);
CAN_MSGQ_DEFINE(echoes, 1024);

static uint32_t echo_offset;
static bool quiet;

static void __attribute__((format(printf, 1, 2))) say(const char *format, ...)
{
	char text[LINE_SIZE];
	va_list arguments;
	int length = snprintf(text, sizeof(text), "%lld ",
	                      (long long)k_ticks_to_us_floor64((uint64_t)k_uptime_ticks()));

	va_start(arguments, format);
	length += vsnprintf(text + length, sizeof(text) - (size_t)length, format, arguments);
	va_end(arguments);
	for (int i = 0; i < length; i++) {
		uart_poll_out(uart, (unsigned char)text[i]);
	}
	uart_poll_out(uart, '\n');
}

static void on_uart(const struct device *dev, void *user_data)
{
	static char line[LINE_SIZE];
	static size_t length;
	uint8_t byte;

	while (uart_irq_update(dev) && uart_irq_rx_ready(dev)) {
		while (uart_fifo_read(dev, &byte, 1) == 1) {
			if (byte == '\n') {
				line[length] = '\0';
				length = 0;
				(void)k_msgq_put(&lines, line, K_NO_WAIT);
			} else if (length < LINE_SIZE - 1) {
				line[length++] = (char)byte;
			}
		}
	}
}

static void on_frame(const struct device *dev, struct can_frame *frame, void *user_data)
{
	if (!quiet) {
		say("rx %x %u %u", frame->id, frame->flags, frame->dlc);
	}
	if (echo_offset != 0) {
		frame->id += echo_offset;
		(void)k_msgq_put(&echoes, frame, K_NO_WAIT);
	}
}

static void on_sent(const struct device *dev, int error, void *user_data)
{
	if (!quiet) {
		say("sent %x %d", (unsigned int)(uintptr_t)user_data, error);
	}
}

static void on_state(const struct device *dev, enum can_state state, struct can_bus_err_cnt errors,
                     void *user_data)
{
	say("state %d %u %u", (int)state, errors.tx_err_cnt, errors.rx_err_cnt);
}

static void send_echoes(void *a, void *b, void *c)
{
	struct can_frame frame;

	for (;;) {
		(void)k_msgq_get(&echoes, &frame, K_FOREVER);
		(void)can_send(can, &frame, K_FOREVER, on_sent, (void *)(uintptr_t)frame.id);
	}
}

K_THREAD_DEFINE(echo_thread, 2048, send_echoes, NULL, NULL, NULL, 1, 0, 0);

static int start(const char *arguments)
{
	unsigned int mode = 0;
	unsigned int bitrate = 1000000;
	unsigned int bitrate_data = 4000000;
	int rc;

	(void)sscanf(arguments, "%u %u %u", &mode, &bitrate, &bitrate_data);
	(void)can_stop(can);
	rc = can_set_mode(can, mode);
	rc = rc != 0 ? rc : can_set_bitrate(can, bitrate);
	rc = rc != 0 ? rc : can_set_bitrate_data(can, bitrate_data);
	return rc != 0 ? rc : can_start(can);
}

static int send_frames(const char *arguments)
{
	unsigned int id = 0;
	unsigned int flags = 0;
	unsigned int dlc = 0;
	unsigned int count = 1;
	int rc = 0;

	(void)sscanf(arguments, "%x %u %u %u", &id, &flags, &dlc, &count);
	for (unsigned int i = 0; i < count && rc == 0; i++) {
		struct can_frame frame = {
			.id = id + i, .flags = (uint8_t)flags, .dlc = (uint8_t)dlc};

		memset(frame.data, (int)i, sizeof(frame.data));
		rc = can_send(can, &frame, K_SECONDS(1), on_sent, (void *)(uintptr_t)frame.id);
	}
	return rc;
}

static int run(const char *line)
{
	const size_t length = strcspn(line, " ");
	const char *arguments = line + length;

	if (strncmp(line, "start", length) == 0) {
		return start(arguments);
	}
	if (strncmp(line, "stop", length) == 0) {
		return can_stop(can);
	}
	if (strncmp(line, "send", length) == 0) {
		return send_frames(arguments);
	}
	if (strncmp(line, "echo", length) == 0) {
		echo_offset = (uint32_t)strtoul(arguments, NULL, 10);
		return 0;
	}
	if (strncmp(line, "quiet", length) == 0) {
		quiet = atoi(arguments) != 0;
		return 0;
	}
	if (strncmp(line, "recover", length) == 0) {
		return can_recover(can, K_MSEC(atoi(arguments)));
	}
	return -EINVAL;
}

int main(void)
{
	const struct can_filter standard = {0};
	const struct can_filter extended = {.flags = CAN_FILTER_IDE};
	char line[LINE_SIZE];

	(void)can_add_rx_filter(can, on_frame, NULL, &standard);
	(void)can_add_rx_filter(can, on_frame, NULL, &extended);
	can_set_state_change_callback(can, on_state, NULL);
	(void)uart_irq_callback_user_data_set(uart, on_uart, NULL);
	uart_irq_rx_enable(uart);
	for (;;) {
		(void)k_msgq_get(&lines, line, K_FOREVER);
		say("done %d", run(line));
	}
}
