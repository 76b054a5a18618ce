/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Internal strobe: when the gate opens and closes.
 *
 * Edges are absolute: with timing (period, on) in force, cycle k lights at origin + k * period and
 * darkens on_us later, exactly, for any k; nothing accumulates. A late call finds the gate as it
 * ought to be then: it skips what it missed, counts it, and keeps to the grid.
 *
 * Change of timing. Call lit(plan) and dark(plan) the lengths a plan gives its phases:
 *   dark plan (on = false):  lit = 0,      dark = unending
 *   steady (period_us = 0):  lit = unending, dark = 0
 *   strobe:                  lit = on_us,  dark = period_us - on_us
 * When a new plan comes at t during a phase that began at s, the phase ends at
 * max(t, s + its length under the new plan), and the new plan's grid starts from that end.
 * So the length of every phase lies between the least and the greatest length which any plan in
 * force during that phase gives; a change can neither shorten a phase below both settings nor,
 * repeated, keep it from ending. Off is immediate, and on is, unless the dark phase would be too
 * short for the strobe. A plan with the same timing leaves the grid untouched.
 *
 * Context: thread or interrupt, serialised by the caller. advance does no division unless late by
 * more than a whole phase. Spec: MAVLink common 406.
 */
#ifndef PHAROS_CORE_STROBE_H
#define PHAROS_CORE_STROBE_H

#include "core/light.h"

#include <stdbool.h>
#include <stdint.h>

struct strobe_stats {
	uint64_t edges;  /* changes of the gate */
	uint64_t missed; /* edges of the grid that were over when advance came */
};

struct strobe {
	int64_t origin_us; /* cycle 0 of the grid lights */
	int64_t cycle;     /* of the present phase; a grid that starts dark is in cycle -1 */
	int64_t phase_us;  /* when the present phase began by the grid */
	int64_t next_us;   /* when it ends; TIME_NEVER_US: unending */
	uint32_t period_us;
	uint32_t on_us;
	bool on;
	bool lit;
	struct strobe_stats stats;
};

/* Dark, since ever: the first plan that lights does so at once. */
void strobe_init(struct strobe *self);

/*
 * plan: as light.h says (asserted); level_ppm and external_sync are not looked at. now_us
 * 0…TIME_MAX_US, not before the last call (asserted). First catches up to now_us, then changes
 * over. Returns the gate from now_us on.
 */
bool strobe_set(struct strobe *self, int64_t now_us, const struct light_plan *plan);

/* Next edge; TIME_NEVER_US: none without a new plan. */
int64_t strobe_deadline_us(const struct strobe *self);

/* Returns the gate from now_us on. Calling early or often is harmless. */
bool strobe_advance(struct strobe *self, int64_t now_us);

#endif
