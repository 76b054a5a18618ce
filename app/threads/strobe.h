/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Carries out light plans: core/gate decides when the lamp is lit, a kernel timer set to absolute
 * times and the sync input's interrupt carry it to the light driver. No thread.
 */
#ifndef PHAROS_THREADS_STROBE_H
#define PHAROS_THREADS_STROBE_H

#include <stdbool.h>

#include "core/gate.h"

/* Before anything else of this file: the lamp is dark. Sets the result of STARTUP_SYNC. */
void strobe_timer_init(const struct sync_config *sync);

/* The plan is in force on return. Thread context. */
void strobe_timer_set(const struct light_plan *plan);

/* New sync parameters. Thread context. */
void strobe_timer_configure(const struct sync_config *sync);

/* True when the lamp has given light at any time since the last call. Thermal thread only. */
bool strobe_timer_was_lit(void);

#endif
