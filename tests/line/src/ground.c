/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The ground's end of the line: a second of commands without a byte's pause between them, while the
 * light strobes. Every command is answered, and no byte is lost.
 */
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/framer.h"
#include "threads/uart_link.h"

#include "uart_line.h"

#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>

#define BYTES     96000 /* more than a second's at 921600 baud */
#define STREAM_MS 1100

#define SYSTEM 1
#define LIGHT  243

static uint8_t to_light[BYTES];
static uint8_t from_light[BYTES];

struct answers {
	uint32_t accepted;
	uint32_t others;
	uint32_t crc_errors;
};

/* On with a strobe of 50 Hz, on again, … */
static size_t command(uint8_t *bytes, uint32_t number)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_LONG);
	const struct mavlink_sender sender = {
		.version = 2, .sequence = (uint8_t)number, .system_id = 255, .component_id = 190};
	mavlink_command_long_t wire = {.target_system = SYSTEM, .target_component = LIGHT};

	if (number % 2 == 0) {
		wire.command = MAV_CMD_ILLUMINATOR_ON_OFF;
		wire.param1 = 1;
	} else {
		wire.command = MAV_CMD_DO_ILLUMINATOR_CONFIGURE;
		wire.param1 = ILLUMINATOR_MODE_INTERNAL_CONTROL;
		wire.param2 = (float)(number % 100);
		wire.param3 = 0.02f;
		wire.param4 = 50;
	}
	return mavlink_frame_build(bytes, &sender, &kind, &wire);
}

static struct answers read_answers(const uint8_t *bytes, size_t count)
{
	static struct mavlink_framer framer;
	struct answers found = {0};
	struct mavlink_frame frame;

	mavlink_framer_init(&framer);
	while (count > 0) {
		const size_t taken = mavlink_framer_write(&framer, bytes, count);

		bytes += taken;
		count -= taken;
		while (mavlink_framer_next(&framer, &frame)) {
			if (frame.message_id != MAVLINK_MSG_ID_COMMAND_ACK) {
				continue;
			}
			if (mavlink_frame_byte(&frame, 2) == MAV_RESULT_ACCEPTED) {
				found.accepted++;
			} else {
				found.others++;
			}
		}
	}
	found.crc_errors = framer.stats.crc_errors;
	return found;
}

/* An idle processor's clock jumps in QEMU, past the line's next byte: it never is. */
static void wait_busy(int64_t ms)
{
	const int64_t end = k_uptime_get() + ms;

	while (k_uptime_get() < end) {
	}
}

static void ground_run(void *p1, void *p2, void *p3)
{
	uint32_t commands = 0;
	size_t used = 0;
	struct link_stats before;
	struct link_stats after;

	while (used + MAVLINK_FRAME_MAX <= sizeof(to_light)) {
		used += command(to_light + used, commands++);
	}
	uart_link_stats_get(0, &before);
	uart_line_start(to_light, used, from_light, sizeof(from_light));
	wait_busy(STREAM_MS);

	const struct uart_line_result result = uart_line_stop();

	uart_link_stats_get(0, &after);

	const struct answers answers = read_answers(from_light, result.received);
	const uint32_t dropped = after.tx_dropped - before.tx_dropped;

	printk("line: %u commands in %u bytes; %u accepted, %u not; %u bytes back\n", commands,
	       (unsigned int)result.sent, answers.accepted, answers.others,
	       (unsigned int)result.received);
	printk("line: %u overruns, at most %u bytes waited; %u frames taken, %u resyncs, %u "
	       "answers dropped\n",
	       result.overruns, result.most, after.rx_frames - before.rx_frames,
	       after.framing.resyncs - before.framing.resyncs, dropped);
	printk("line: %s\n", result.sent == used && result.overruns == 0 &&
	                                     answers.accepted == commands && answers.others == 0 &&
	                                     answers.crc_errors == 0 && dropped == 0
	                             ? "passed"
	                             : "failed");
}

K_THREAD_DEFINE(ground, 4096, ground_run, NULL, NULL, NULL, K_LOWEST_APPLICATION_THREAD_PRIO, 0,
                3000);
