/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The application's clock: microseconds since boot, as the core counts them. Any context.
 */
#ifndef PHAROS_THREADS_CLOCK_H
#define PHAROS_THREADS_CLOCK_H

#include <stdint.h>

#include <zephyr/kernel.h>

#include "core/limits.h"

static inline int64_t clock_now_us(void)
{
	return (int64_t)k_ticks_to_us_floor64((uint64_t)k_uptime_ticks());
}

/* The absolute timeout of a core deadline; TIME_NEVER_US is K_FOREVER: what else its user waits for
 * ends the wait.
 */
static inline k_timeout_t clock_timeout(int64_t deadline_us)
{
	return deadline_us == TIME_NEVER_US ? K_FOREVER : K_TIMEOUT_ABS_US(deadline_us);
}

#endif
