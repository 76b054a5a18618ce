/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the lamp shall do, complete: the illuminator makes it, strobe, sync and gate carry it out.
 */
#ifndef PHAROS_CORE_LIGHT_H
#define PHAROS_CORE_LIGHT_H

#include "core/program.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * on            false: dark, whatever the rest says.
 * external_sync true: the sync input gates the lamp; period_us and on_us are then what the internal
 *               strobe does when the input times out with that policy.
 * level_ppm     0…1 000 000, linear light (= power) after the curve, while the gate is lit.
 * period_us     0: steady; else the strobe's period, STROBE_PERIOD_FLOOR_US…_CEILING_US.
 * on_us         lit part of each period, 1…period_us - 1; 0 when period_us is 0.
 * program       modulates the level; NONE unless internal and steady.
 */
struct light_plan {
	bool on;
	bool external_sync;
	uint32_t level_ppm;
	uint32_t period_us;
	uint32_t on_us;
	struct program program;
};

#endif
