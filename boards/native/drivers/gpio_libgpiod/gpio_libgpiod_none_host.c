/* SPDX-License-Identifier: Apache-2.0 */
/* A build without libgpiod: no chip can be opened, so nothing else is ever called. */
#include "gpio_libgpiod.h"

#include <errno.h>
#include <stddef.h>

const char *gpiochip_backend(void)
{
	return "built without libgpiod";
}

struct gpiochip *gpiochip_open(const char *path)
{
	(void)path;
	errno = ENOTSUP;
	return NULL;
}

void gpiochip_close(struct gpiochip *chip)
{
	(void)chip;
}

unsigned int gpiochip_line_count(struct gpiochip *chip)
{
	(void)chip;
	return 0;
}

int gpiochip_describe(struct gpiochip *chip, unsigned int offset, struct gpiochip_info *info)
{
	(void)chip;
	(void)offset;
	(void)info;
	return -ENOTSUP;
}

struct gpiochip_line *gpiochip_output(struct gpiochip *chip, unsigned int offset, bool level,
                                      enum gpiochip_pull pull)
{
	(void)level;
	return gpiochip_input(chip, offset, pull);
}

struct gpiochip_line *gpiochip_input(struct gpiochip *chip, unsigned int offset,
                                     enum gpiochip_pull pull)
{
	(void)chip;
	(void)offset;
	(void)pull;
	errno = ENOTSUP;
	return NULL;
}

int gpiochip_set(struct gpiochip_line *line, bool level)
{
	(void)line;
	(void)level;
	return -ENOTSUP;
}

int gpiochip_get(struct gpiochip_line *line)
{
	(void)line;
	return -ENOTSUP;
}

int gpiochip_fd(const struct gpiochip_line *line)
{
	(void)line;
	return -ENOTSUP;
}

int gpiochip_read(struct gpiochip_line *line, struct gpiochip_edge *edge)
{
	(void)line;
	(void)edge;
	return -ENOTSUP;
}
