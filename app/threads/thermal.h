/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The thermal thread samples the thermistor at 10 Hz. The limit is in force in the light driver
 * before anyone hears of it; then the command thread gets the report.
 */
#ifndef PHAROS_THREADS_THERMAL_H
#define PHAROS_THREADS_THERMAL_H

#include "core/thermal.h"

#define THERMAL_PERIOD_US 100000

/* Before the thread starts: the lamp's limit is 0, as after each reset, until the first sample. */
void thermal_thread_init(const struct thermal_config *config);

/* In force with the next sample. Any thread. */
void thermal_thread_configure(const struct thermal_config *config);

/* A copy of the whole state. Any thread. */
void thermal_thread_get(struct thermal *copy);

/* A good sample has been taken since the reset. Any context. */
bool thermal_thread_has_sampled(void);

/* Thread entry. */
void thermal_thread_run(void *p1, void *p2, void *p3);

#endif
