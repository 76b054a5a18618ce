/* SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include <zephyr/kernel.h>

#include "kernel/port.h"
#include "log_output.h"

#ifdef CONFIG_SHELL_LOG_BACKEND
#include "subsys/shell/shell_internal.h"
#endif

#define PREFIX_MAX    64
#define BYTES_IN_LINE 16
/* "00 " for each byte, a gap in the middle, a bar, the bytes as text */
#define DUMP_MAX      (PREFIX_MAX + BYTES_IN_LINE * 4 + 4)

static const char *const level_names[] = {"", "err", "wrn", "inf", "dbg"};

#ifdef CONFIG_SHELL_LOG_BACKEND

static enum shell_vt100_color color_of(uint8_t level)
{
	switch (level) {
	case LOG_LEVEL_ERR:
		return SHELL_ERROR;
	case LOG_LEVEL_WRN:
		return SHELL_WARNING;
	default:
		return SHELL_NORMAL;
	}
}

static bool to_shell(uint8_t level, const char *line, size_t length)
{
	STRUCT_SECTION_FOREACH(shell, sh) {
		if (shell_ready(sh) && sh->ctx->log_backend) {
			shell_out_log(sh, color_of(level), line, length);
			return true;
		}
	}
	return false;
}

#else

static bool to_shell(uint8_t level, const char *line, size_t length)
{
	return false;
}

#endif

/* line has room for one more byte after length. */
static void put_line(uint8_t level, char *line, size_t length, bool direct)
{
	if (!direct && to_shell(level, line, length)) {
		return;
	}
	line[length] = '\n';
	port_console_write(line, length + 1);
}

static size_t put_prefix(char *line, const struct log_record *record)
{
	const int64_t us = record->time_us;
	const int64_t seconds = us / USEC_PER_SEC;
	const int length =
		snprintf(line, PREFIX_MAX,
	                 "[%02" PRId64 ":%02" PRId64 ":%02" PRId64 ".%03" PRId64 ",%03" PRId64
	                 "] <%s> %.24s: ",
	                 seconds / 3600, seconds / 60 % 60, seconds % 60, us / 1000 % 1000,
	                 us % 1000, level_names[record->level], record->source->name);

	return (size_t)MIN(length, PREFIX_MAX - 1);
}

static void put_dump_line(const struct log_message *message, size_t indent, size_t at, bool direct)
{
	char line[DUMP_MAX + 1];
	const size_t count = MIN(message->record.data_kept - at, (size_t)BYTES_IN_LINE);
	size_t length = indent;

	memset(line, ' ', indent);
	for (size_t i = 0; i < BYTES_IN_LINE; i++) {
		if (i == BYTES_IN_LINE / 2) {
			line[length++] = ' ';
		}
		if (i < count) {
			(void)snprintf(&line[length], 4, "%02x ", message->data[at + i]);
		} else {
			memcpy(&line[length], "   ", 3);
		}
		length += 3;
	}
	line[length++] = '|';
	for (size_t i = 0; i < count; i++) {
		const uint8_t byte = message->data[at + i];

		line[length++] = byte >= ' ' && byte <= '~' ? (char)byte : '.';
	}
	put_line(message->record.level, line, length, direct);
}

void log_output_message(const struct log_message *message, bool direct)
{
	const struct log_record *record = &message->record;
	char line[PREFIX_MAX + LOG_TEXT_MAX + 1];
	const size_t indent = put_prefix(line, record);

	memcpy(&line[indent], message->text, record->text_length);
	put_line(record->level, line, indent + record->text_length, direct);
	for (size_t at = 0; at < record->data_kept; at += BYTES_IN_LINE) {
		put_dump_line(message, indent, at, direct);
	}
	if (record->data_length > record->data_kept) {
		const int length =
			snprintf(line, sizeof(line), "%*s(%" PRIu32 " more bytes)", (int)indent, "",
		                 record->data_length - record->data_kept);

		put_line(record->level, line, (size_t)length, direct);
	}
}

void log_output_dropped(uint32_t count, bool direct)
{
	char line[64];
	const int length =
		snprintf(line, sizeof(line), "--- %" PRIu32 " messages dropped ---", count);

	put_line(LOG_LEVEL_WRN, line, (size_t)length, direct);
}
