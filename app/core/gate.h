/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lamp's gate: internal strobe, external sync with the strobe as a possible stand-in, or a
 * program, which sets the level as well.
 *
 * The strobe starts anew when the sync input's time-out hands over to it; the sync input when a
 * plan begins to follow it; a program when a plan brings it, and again when its timing changes.
 * Times before the last call's count as the last call's. Context: thread or interrupt, serialised
 * by the caller (lock interrupts around the calls from a thread).
 */
#ifndef PHAROS_CORE_GATE_H
#define PHAROS_CORE_GATE_H

#include "core/light.h"
#include "core/strobe.h"
#include "core/sync.h"

struct gate {
	struct light_plan plan;
	struct strobe strobe;
	struct sync sync;
	int64_t now_us;     /* up to when everything is decided */
	int64_t program_us; /* when the program began */
	struct program_phase phase;
	bool level; /* raw input as last told */
};

/* Dark. sync and level: see sync_init. */
void gate_init(struct gate *self, int64_t now_us, const struct sync_config *sync, bool level);

/* All return the gate from now_us (at_us) on; ranges as in strobe.h and sync.h. */
bool gate_set(struct gate *self, int64_t now_us, const struct light_plan *plan);
bool gate_configure(struct gate *self, int64_t now_us, const struct sync_config *sync);
bool gate_input(struct gate *self, int64_t at_us, bool level);
bool gate_advance(struct gate *self, int64_t now_us);

/* The lamp's level while the gate is lit, 0…PPM_ONE; to be set before the gate opens. */
uint32_t gate_level_ppm(const struct gate *self);

/* When to call gate_advance; TIME_NEVER_US: not before another call. */
int64_t gate_deadline_us(const struct gate *self);

#endif
