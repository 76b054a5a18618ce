/* SPDX-License-Identifier: Apache-2.0 */
/* libgpiod 1.5 and 1.6 (Debian 11 and 12). */
#include "gpio_libgpiod.h"

#include <errno.h>
#include <gpiod.h>
#include <stdio.h>

/* The library's own objects serve as ours. */
static struct gpiod_chip *chip_of(struct gpiochip *chip)
{
	return (struct gpiod_chip *)(void *)chip;
}

static struct gpiod_line *line_of(const struct gpiochip_line *line)
{
	return (struct gpiod_line *)(uintptr_t)line;
}

static struct gpiochip_line *our(struct gpiod_line *line)
{
	return (struct gpiochip_line *)(void *)line;
}

static int flags_of(enum gpiochip_pull pull)
{
	switch (pull) {
	case GPIOCHIP_PULL_NONE:
		return 0;
	case GPIOCHIP_PULL_DOWN:
		return GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
	case GPIOCHIP_PULL_UP:
		return GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
	}
	return 0;
}

const char *gpiochip_backend(void)
{
	return "libgpiod v1";
}

struct gpiochip *gpiochip_open(const char *path)
{
	return (struct gpiochip *)(void *)gpiod_chip_open(path);
}

void gpiochip_close(struct gpiochip *chip)
{
	if (chip != NULL) {
		gpiod_chip_close(chip_of(chip));
	}
}

unsigned int gpiochip_line_count(struct gpiochip *chip)
{
	return gpiod_chip_num_lines(chip_of(chip));
}

static void copy(char *to, const char *from)
{
	snprintf(to, GPIOCHIP_NAME_SIZE, "%s", from != NULL ? from : "");
}

int gpiochip_describe(struct gpiochip *chip, unsigned int offset, struct gpiochip_info *info)
{
	struct gpiod_line *line = gpiod_chip_get_line(chip_of(chip), offset);

	if (line == NULL) {
		return -errno;
	}
	copy(info->name, gpiod_line_name(line));
	copy(info->consumer, gpiod_line_consumer(line));
	return 0;
}

struct gpiochip_line *gpiochip_output(struct gpiochip *chip, unsigned int offset, bool level,
                                      enum gpiochip_pull pull)
{
	struct gpiod_line *line = gpiod_chip_get_line(chip_of(chip), offset);

	if (line == NULL ||
	    gpiod_line_request_output_flags(line, GPIOCHIP_CONSUMER, flags_of(pull), level) != 0) {
		return NULL;
	}
	return our(line);
}

struct gpiochip_line *gpiochip_input(struct gpiochip *chip, unsigned int offset,
                                     enum gpiochip_pull pull)
{
	struct gpiod_line *line = gpiod_chip_get_line(chip_of(chip), offset);

	if (line == NULL || gpiod_line_request_both_edges_events_flags(line, GPIOCHIP_CONSUMER,
	                                                               flags_of(pull)) != 0) {
		return NULL;
	}
	return our(line);
}

int gpiochip_set(struct gpiochip_line *line, bool level)
{
	return gpiod_line_set_value(line_of(line), level) == 0 ? 0 : -errno;
}

int gpiochip_get(struct gpiochip_line *line)
{
	const int value = gpiod_line_get_value(line_of(line));

	return value >= 0 ? value : -errno;
}

int gpiochip_fd(const struct gpiochip_line *line)
{
	return gpiod_line_event_get_fd(line_of(line));
}

int gpiochip_read(struct gpiochip_line *line, struct gpiochip_edge *edge)
{
	struct gpiod_line_event event;

	if (gpiod_line_event_read(line_of(line), &event) != 0) {
		return -errno;
	}
	edge->time_ns = (uint64_t)event.ts.tv_sec * 1000000000u + (uint64_t)event.ts.tv_nsec;
	edge->level = event.event_type == GPIOD_LINE_EVENT_RISING_EDGE;
	return 0;
}
