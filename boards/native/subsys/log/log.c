/* SPDX-License-Identifier: Apache-2.0 */
/* Messages wait in a ring of bytes: a record, its text, its data. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/logging/log_ctrl.h>

#include "log_output.h"

#ifdef CONFIG_LOG_PROCESS_THREAD_CUSTOM_PRIORITY
#define LOG_PRIORITY CONFIG_LOG_PROCESS_THREAD_PRIORITY
#else
#define LOG_PRIORITY K_LOWEST_APPLICATION_THREAD_PRIO
#endif

struct log_ring {
	uint8_t bytes[CONFIG_LOG_BUFFER_SIZE];
	size_t first;
	size_t used;
	uint32_t count;
	uint32_t dropped;
	uint32_t dropped_told;
};

static struct log_ring ring;
static bool panic_mode;

static K_SEM_DEFINE(log_ready, 0, 1);
/* One message at a time on the way out. */
static K_MUTEX_DEFINE(log_output_mutex);

static void ring_put(const void *data, size_t length)
{
	const size_t at = (ring.first + ring.used) % sizeof(ring.bytes);
	const size_t part = MIN(length, sizeof(ring.bytes) - at);

	memcpy(&ring.bytes[at], data, part);
	memcpy(ring.bytes, (const uint8_t *)data + part, length - part);
	ring.used += length;
}

static void ring_get(void *data, size_t length)
{
	const size_t part = MIN(length, sizeof(ring.bytes) - ring.first);

	memcpy(data, &ring.bytes[ring.first], part);
	memcpy((uint8_t *)data + part, ring.bytes, length - part);
	ring.first = (ring.first + length) % sizeof(ring.bytes);
	ring.used -= length;
}

static bool take(struct log_message *message)
{
	const unsigned int key = irq_lock();
	const bool found = ring.count > 0;

	if (found) {
		ring_get(&message->record, sizeof(message->record));
		ring_get(message->text, message->record.text_length);
		ring_get(message->data, message->record.data_kept);
		ring.count--;
	}
	irq_unlock(key);
	return found;
}

static uint32_t take_dropped(void)
{
	const unsigned int key = irq_lock();
	const uint32_t news = ring.dropped - ring.dropped_told;

	ring.dropped_told = ring.dropped;
	irq_unlock(key);
	return news;
}

static bool must_not_wait(void)
{
	return panic_mode || k_is_in_isr();
}

/* Writes one message that waits. */
static bool process_one(void)
{
	struct log_message message;
	const bool direct = panic_mode;
	const bool found = take(&message);
	uint32_t dropped;

	if (found) {
		log_output_message(&message, direct);
	}
	dropped = take_dropped();
	if (dropped > 0) {
		log_output_dropped(dropped, direct);
	}
	return found;
}

bool log_process(void)
{
	(void)k_mutex_lock(&log_output_mutex, K_FOREVER);
	(void)process_one();
	(void)k_mutex_unlock(&log_output_mutex);
	return log_buffered_cnt() > 0;
}

static void submit(const struct log_message *message)
{
	const struct log_record *record = &message->record;
	const size_t size = sizeof(*record) + record->text_length + record->data_kept;
	unsigned int key;

	if (panic_mode) {
		log_output_message(message, true);
		return;
	}
	key = irq_lock();
	if (size > sizeof(ring.bytes) - ring.used) {
		ring.dropped++;
	} else {
		ring_put(record, sizeof(*record));
		ring_put(message->text, record->text_length);
		ring_put(message->data, record->data_kept);
		ring.count++;
	}
	irq_unlock(key);
	if (IS_ENABLED(CONFIG_LOG_MODE_IMMEDIATE) && !must_not_wait()) {
		while (log_process()) {
		}
	} else {
		k_sem_give(&log_ready);
	}
}

static void fill(struct log_message *message, uint8_t level, const struct log_source *source)
{
	memset(&message->record, 0, sizeof(message->record));
	message->record.source = source;
	message->record.time_us = (int64_t)k_ticks_to_us_floor64((uint64_t)k_uptime_ticks());
	message->record.level = level;
}

void log_write(uint8_t level, const struct log_source *source, const char *fmt, ...)
{
	struct log_message message;
	va_list args;
	int length;

	fill(&message, level, source);
	va_start(args, fmt);
	length = vsnprintf(message.text, sizeof(message.text), fmt, args);
	va_end(args);
	if (length < 0) {
		return;
	}
	if (length >= (int)sizeof(message.text)) {
		length = (int)sizeof(message.text) - 1;
		memcpy(&message.text[length - 3], "...", 3);
	}
	message.record.text_length = (uint16_t)length;
	submit(&message);
}

void log_write_hexdump(uint8_t level, const struct log_source *source, const void *data,
                       size_t length, const char *text)
{
	struct log_message message;
	const size_t text_length = strnlen(text, sizeof(message.text) - 1);

	fill(&message, level, source);
	memcpy(message.text, text, text_length);
	message.record.text_length = (uint16_t)text_length;
	message.record.data_length = (uint32_t)length;
	message.record.data_kept = (uint16_t)MIN(length, sizeof(message.data));
	memcpy(message.data, data, message.record.data_kept);
	submit(&message);
}

uint32_t log_buffered_cnt(void)
{
	const unsigned int key = irq_lock();
	const uint32_t count = ring.count;

	irq_unlock(key);
	return count;
}

uint32_t log_dropped_cnt(void)
{
	const unsigned int key = irq_lock();
	const uint32_t dropped = ring.dropped;

	irq_unlock(key);
	return dropped;
}

void log_panic(void)
{
	panic_mode = true;
	while (process_one()) {
	}
}

static void log_thread(void *p1, void *p2, void *p3)
{
	for (;;) {
		(void)k_sem_take(&log_ready, K_FOREVER);
		while (log_process()) {
		}
	}
}

K_THREAD_DEFINE(logging, CONFIG_LOG_PROCESS_THREAD_STACK_SIZE, log_thread, NULL, NULL, NULL,
                LOG_PRIORITY, 0, 0);
