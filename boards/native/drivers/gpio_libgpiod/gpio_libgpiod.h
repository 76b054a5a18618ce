/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lines of a GPIO chip of the host, over whichever libgpiod there is: version 1
 * (gpio_libgpiod_v1_host.c), version 2 (gpio_libgpiod_v2_host.c), or none at all
 * (gpio_libgpiod_none_host.c). Levels are electrical: 1 is high.
 *
 * Nothing blocks. Errors are -errno, or NULL with errno set; -ENODEV: the chip has gone.
 */
#ifndef GPIO_LIBGPIOD_H_
#define GPIO_LIBGPIOD_H_

#include <stdbool.h>
#include <stdint.h>

#define GPIOCHIP_CONSUMER "pharos" /* who the kernel says uses our lines */

enum {
	GPIOCHIP_NAME_SIZE = 64
};

enum gpiochip_pull {
	GPIOCHIP_PULL_NONE,
	GPIOCHIP_PULL_DOWN,
	GPIOCHIP_PULL_UP,
};

struct gpiochip_info {
	char name[GPIOCHIP_NAME_SIZE];     /* empty: it has none */
	char consumer[GPIOCHIP_NAME_SIZE]; /* who uses it; empty: nobody says so */
};

struct gpiochip_edge {
	uint64_t time_ns; /* CLOCK_MONOTONIC, by the kernel's interrupt handler */
	bool level;       /* from then on */
};

struct gpiochip;
struct gpiochip_line;

/* "libgpiod v1"; what --help and the control socket show. */
const char *gpiochip_backend(void);

struct gpiochip *gpiochip_open(const char *path);

/* Releases its lines as well. NULL: nothing happens. */
void gpiochip_close(struct gpiochip *chip);

unsigned int gpiochip_line_count(struct gpiochip *chip);

/* offset < gpiochip_line_count(). 0 or -errno. */
int gpiochip_describe(struct gpiochip *chip, unsigned int offset, struct gpiochip_info *info);

/*
 * The line as an output, or as an input whose edges are queued. A chip without pulls ignores pull.
 * EBUSY: somebody has it. The kernel takes the line back when the process ends, however it ends.
 */
struct gpiochip_line *gpiochip_output(struct gpiochip *chip, unsigned int offset, bool level,
                                      enum gpiochip_pull pull);
struct gpiochip_line *gpiochip_input(struct gpiochip *chip, unsigned int offset,
                                     enum gpiochip_pull pull);

/* 0 or -errno. */
int gpiochip_set(struct gpiochip_line *line, bool level);

/* 0, 1 or -errno. */
int gpiochip_get(struct gpiochip_line *line);

/* Inputs: readable when an edge is queued. */
int gpiochip_fd(const struct gpiochip_line *line);

/* The oldest queued edge; only when gpiochip_fd() is readable. 0 or -errno. */
int gpiochip_read(struct gpiochip_line *line, struct gpiochip_edge *edge);

#endif
