/* SPDX-License-Identifier: Apache-2.0 */
/* libgpiod 2 (Debian 13 and later). */
#include "gpio_libgpiod.h"

#include <errno.h>
#include <gpiod.h>
#include <stdio.h>
#include <stdlib.h>

struct gpiochip_line {
	unsigned int offset;
	struct gpiod_line_request *request;
	struct gpiod_edge_event_buffer *events; /* inputs */
	struct gpiochip_line *next;
};

struct gpiochip {
	struct gpiod_chip *chip;
	unsigned int line_count;
	struct gpiochip_line *lines;
};

const char *gpiochip_backend(void)
{
	return "libgpiod v2";
}

static int count_lines(struct gpiochip *chip)
{
	struct gpiod_chip_info *info = gpiod_chip_get_info(chip->chip);

	if (info == NULL) {
		return -1;
	}
	chip->line_count = (unsigned int)gpiod_chip_info_get_num_lines(info);
	gpiod_chip_info_free(info);
	return 0;
}

struct gpiochip *gpiochip_open(const char *path)
{
	struct gpiochip *chip = calloc(1, sizeof(*chip));

	if (chip == NULL) {
		return NULL;
	}
	chip->chip = gpiod_chip_open(path);
	if (chip->chip == NULL || count_lines(chip) != 0) {
		const int error = errno;

		gpiochip_close(chip);
		errno = error;
		return NULL;
	}
	return chip;
}

static void free_line(struct gpiochip_line *line)
{
	if (line->request != NULL) {
		gpiod_line_request_release(line->request);
	}
	if (line->events != NULL) {
		gpiod_edge_event_buffer_free(line->events);
	}
	free(line);
}

void gpiochip_close(struct gpiochip *chip)
{
	if (chip == NULL) {
		return;
	}
	while (chip->lines != NULL) {
		struct gpiochip_line *line = chip->lines;

		chip->lines = line->next;
		free_line(line);
	}
	if (chip->chip != NULL) {
		gpiod_chip_close(chip->chip);
	}
	free(chip);
}

unsigned int gpiochip_line_count(struct gpiochip *chip)
{
	return chip->line_count;
}

static void copy(char *to, const char *from)
{
	snprintf(to, GPIOCHIP_NAME_SIZE, "%s", from != NULL ? from : "");
}

int gpiochip_describe(struct gpiochip *chip, unsigned int offset, struct gpiochip_info *info)
{
	struct gpiod_line_info *line = gpiod_chip_get_line_info(chip->chip, offset);

	if (line == NULL) {
		return -errno;
	}
	copy(info->name, gpiod_line_info_get_name(line));
	copy(info->consumer, gpiod_line_info_get_consumer(line));
	gpiod_line_info_free(line);
	return 0;
}

static enum gpiod_line_bias bias_of(enum gpiochip_pull pull)
{
	switch (pull) {
	case GPIOCHIP_PULL_NONE:
		return GPIOD_LINE_BIAS_AS_IS;
	case GPIOCHIP_PULL_DOWN:
		return GPIOD_LINE_BIAS_PULL_DOWN;
	case GPIOCHIP_PULL_UP:
		return GPIOD_LINE_BIAS_PULL_UP;
	}
	return GPIOD_LINE_BIAS_AS_IS;
}

/* settings: all that is asked of the line. */
static struct gpiod_line_request *request(struct gpiochip *chip, unsigned int offset,
                                          struct gpiod_line_settings *settings)
{
	struct gpiod_request_config *consumer = gpiod_request_config_new();
	struct gpiod_line_config *config = gpiod_line_config_new();
	struct gpiod_line_request *result = NULL;
	int error = ENOMEM;

	if (consumer != NULL && config != NULL &&
	    gpiod_line_config_add_line_settings(config, &offset, 1, settings) == 0) {
		gpiod_request_config_set_consumer(consumer, GPIOCHIP_CONSUMER);
		result = gpiod_chip_request_lines(chip->chip, consumer, config);
		error = errno;
	}
	gpiod_request_config_free(consumer);
	gpiod_line_config_free(config);
	errno = error;
	return result;
}

static struct gpiochip_line *add_line(struct gpiochip *chip, unsigned int offset,
                                      struct gpiod_line_settings *settings, bool edges)
{
	struct gpiochip_line *line = calloc(1, sizeof(*line));
	int error;

	if (line == NULL) {
		return NULL;
	}
	line->offset = offset;
	line->events = edges ? gpiod_edge_event_buffer_new(1) : NULL;
	line->request = request(chip, offset, settings);
	if (line->request == NULL || (edges && line->events == NULL)) {
		error = errno;
		free_line(line);
		errno = error;
		return NULL;
	}
	line->next = chip->lines;
	chip->lines = line;
	return line;
}

struct gpiochip_line *gpiochip_output(struct gpiochip *chip, unsigned int offset, bool level,
                                      enum gpiochip_pull pull)
{
	struct gpiod_line_settings *settings = gpiod_line_settings_new();
	struct gpiochip_line *line;

	if (settings == NULL) {
		return NULL;
	}
	gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT);
	gpiod_line_settings_set_output_value(settings, level ? GPIOD_LINE_VALUE_ACTIVE
	                                                     : GPIOD_LINE_VALUE_INACTIVE);
	gpiod_line_settings_set_bias(settings, bias_of(pull));
	line = add_line(chip, offset, settings, false);
	gpiod_line_settings_free(settings);
	return line;
}

struct gpiochip_line *gpiochip_input(struct gpiochip *chip, unsigned int offset,
                                     enum gpiochip_pull pull)
{
	struct gpiod_line_settings *settings = gpiod_line_settings_new();
	struct gpiochip_line *line;

	if (settings == NULL) {
		return NULL;
	}
	gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT);
	gpiod_line_settings_set_edge_detection(settings, GPIOD_LINE_EDGE_BOTH);
	gpiod_line_settings_set_event_clock(settings, GPIOD_LINE_CLOCK_MONOTONIC);
	gpiod_line_settings_set_bias(settings, bias_of(pull));
	line = add_line(chip, offset, settings, true);
	gpiod_line_settings_free(settings);
	return line;
}

int gpiochip_set(struct gpiochip_line *line, bool level)
{
	const enum gpiod_line_value value =
		level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;

	return gpiod_line_request_set_value(line->request, line->offset, value) == 0 ? 0 : -errno;
}

int gpiochip_get(struct gpiochip_line *line)
{
	const enum gpiod_line_value value =
		gpiod_line_request_get_value(line->request, line->offset);

	return value == GPIOD_LINE_VALUE_ERROR ? -errno : value == GPIOD_LINE_VALUE_ACTIVE;
}

int gpiochip_fd(const struct gpiochip_line *line)
{
	return gpiod_line_request_get_fd(line->request);
}

int gpiochip_read(struct gpiochip_line *line, struct gpiochip_edge *edge)
{
	struct gpiod_edge_event *event;

	if (gpiod_line_request_read_edge_events(line->request, line->events, 1) != 1) {
		return -errno;
	}
	event = gpiod_edge_event_buffer_get_event(line->events, 0);
	edge->time_ns = gpiod_edge_event_get_timestamp_ns(event);
	edge->level = gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE;
	return 0;
}
