/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Functions that run before main(): SYS_INIT(fn, LEVEL, priority), int fn(void).
 *
 * Levels run in the order EARLY, PRE_KERNEL_1, PRE_KERNEL_2, POST_KERNEL, APPLICATION; within a
 * level by priority, 0 first; then in link order. EARLY and PRE_KERNEL_*: no thread runs yet,
 * nothing may block. POST_KERNEL and APPLICATION: in the main thread.
 *
 * A device is an init_entry whose dev is set: init_fn.dev(dev) is called and its result handed to
 * device_init_result().
 */
#ifndef ZEPHYR_INIT_H_
#define ZEPHYR_INIT_H_

#include <stdint.h>

#include <zephyr/sys/iterable_sections.h>

struct device;

enum init_level {
	INIT_LEVEL_EARLY,
	INIT_LEVEL_PRE_KERNEL_1,
	INIT_LEVEL_PRE_KERNEL_2,
	INIT_LEVEL_POST_KERNEL,
	INIT_LEVEL_APPLICATION,
	INIT_LEVEL_COUNT,
};

union init_function {
	int (*sys)(void);
	int (*dev)(const struct device *dev);
};

struct init_entry {
	union init_function init_fn;
	const struct device *dev; /* NULL: init_fn.sys */
	uint16_t level;
	uint16_t priority; /* 0…999, as in Zephyr */
};

#define INIT_LEVEL_OF(level) INIT_LEVEL_##level

#define SYS_INIT_NAMED(name, fn, init_level, prio)                                                 \
	static const STRUCT_SECTION_ITERABLE(init_entry, init_entry_##name) = {                    \
		.init_fn = {.sys = (fn)},                                                          \
		.dev = NULL,                                                                       \
		.level = INIT_LEVEL_OF(init_level),                                                \
		.priority = (prio),                                                                \
	}

#define SYS_INIT(fn, init_level, prio) SYS_INIT_NAMED(fn, fn, init_level, prio)

/* Implemented beside the device model: rc is what the device's init function returned. */
void device_init_result(const struct device *dev, int rc);

#endif
