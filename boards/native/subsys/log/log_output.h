/* SPDX-License-Identifier: Apache-2.0 */
/* A message of the log, and its way out: through a shell, or straight to the console. */
#ifndef LOG_OUTPUT_H
#define LOG_OUTPUT_H

#include <stdbool.h>
#include <stdint.h>

#include <zephyr/logging/log.h>

struct log_record {
	const struct log_source *source;
	int64_t time_us;
	uint32_t data_length; /* as it was given; data_kept of it are here */
	uint16_t data_kept;
	uint16_t text_length;
	uint8_t level;
};

struct log_message {
	struct log_record record;
	char text[LOG_TEXT_MAX + 1];
	uint8_t data[LOG_DATA_MAX];
};

/* direct: past the shell, without waiting for anything. Otherwise from threads only. */
void log_output_message(const struct log_message *message, bool direct);
void log_output_dropped(uint32_t count, bool direct);

#endif
