/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The grid, and what a change of timing does to it. With a period of 10, lit for 3:
 *
 *   cycle     0         1         2
 *   time      o         o+10      o+20
 *   gate      ###_______###_______###___
 *
 * Edges are computed from origin and cycle, never by adding to the edge before; so no rounding and
 * no late call can move them. A new plan keeps the present phase and the time at which it began
 * (s), and asks only when the phase ends under the new lengths: max(now, s + length). From that
 * end a new grid starts. Period 10 to 4, lit for 1, told at t in a dark phase that began at s:
 *
 *   old       ###_______###_______
 *                s  t             under the old plan dark until s + 7
 *   new       ###___#___#___#___  dark until s + 3, then lit on a grid with this origin
 *
 * Before a change, think of who sends it: a station that drags a slider sends forty plans a second.
 * If a plan restarted the phase, the gate would never turn; if it ended the phase, the lamp would
 * flash at forty hertz. tests/unit/core/src/strobe_test.c and tests/sim hold it to the bounds that
 * strobe.h states.
 */
#include "core/strobe.h"

#include "core/assert.h"
#include "core/limits.h"

#define UNENDING TIME_NEVER_US

void strobe_init(struct strobe *self)
{
	*self = (struct strobe){.phase_us = -TIME_MAX_US, .next_us = TIME_NEVER_US};
}

static bool is_strobe(const struct strobe *self)
{
	return self->on && self->period_us > 0;
}

/* Length of the phases that the timing in force gives. */
static int64_t phase_length(const struct strobe *self, bool lit)
{
	if (!is_strobe(self)) {
		return (self->on == lit) ? UNENDING : 0;
	}
	return lit ? self->on_us : self->period_us - self->on_us;
}

/* By the grid: when the phase (cycle, lit) ends. */
static int64_t phase_end(const struct strobe *self)
{
	if (!is_strobe(self)) {
		return TIME_NEVER_US;
	}
	if (self->lit) {
		return self->origin_us + self->cycle * self->period_us + self->on_us;
	}
	return self->origin_us + (self->cycle + 1) * self->period_us;
}

/* The present phase ends at next_us, and the other one begins. */
static void flip(struct strobe *self)
{
	self->lit = !self->lit;
	self->cycle += self->lit ? 1 : 0;
	self->phase_us = self->next_us;
	self->next_us = phase_end(self);
}

/* More than one edge is over: to the phase that now_us lies in, without passing the others. */
static void skip(struct strobe *self, int64_t now_us)
{
	const int64_t cycle = (now_us - self->origin_us) / self->period_us;
	const int64_t begin_us = self->origin_us + cycle * self->period_us;
	const bool lit = now_us - begin_us < self->on_us;
	const int64_t edges_before = 2 * self->cycle + (self->lit ? 0 : 1);
	const int64_t edges_after = 2 * cycle + (lit ? 0 : 1);

	self->stats.missed += (uint64_t)(edges_after - edges_before);
	self->cycle = cycle;
	self->lit = lit;
	self->phase_us = lit ? begin_us : begin_us + self->on_us;
	self->next_us = phase_end(self);
}

bool strobe_advance(struct strobe *self, int64_t now_us)
{
	PHAROS_ASSERT(now_us >= self->phase_us && now_us <= TIME_MAX_US);
	if (now_us < self->next_us) {
		return self->lit;
	}
	const bool before = self->lit;

	flip(self);
	if (now_us >= self->next_us) {
		skip(self, now_us);
		/* One of the edges that are over is made now, if they leave the gate changed. */
		self->stats.missed += (self->lit == before) ? 1u : 0u;
	}
	self->stats.edges += (self->lit != before) ? 1u : 0u;
	return self->lit;
}

static bool same_timing(const struct strobe *self, const struct light_plan *plan)
{
	if (!plan->on || !self->on) {
		return plan->on == self->on;
	}
	return plan->period_us == self->period_us && plan->on_us == self->on_us;
}

static void assert_plan(const struct light_plan *plan)
{
	if (plan->on && plan->period_us > 0) {
		PHAROS_ASSERT(plan->period_us >= STROBE_PERIOD_FLOOR_US);
		PHAROS_ASSERT(plan->period_us <= STROBE_PERIOD_CEILING_US);
		PHAROS_ASSERT(plan->on_us > 0 && plan->on_us < plan->period_us);
	}
}

bool strobe_set(struct strobe *self, int64_t now_us, const struct light_plan *plan)
{
	PHAROS_ASSERT(now_us >= 0);
	assert_plan(plan);
	strobe_advance(self, now_us);
	if (same_timing(self, plan)) {
		return self->lit;
	}
	self->on = plan->on;
	self->period_us = plan->on ? plan->period_us : 0;
	self->on_us = (self->period_us > 0) ? plan->on_us : 0;

	const int64_t length_us = phase_length(self, self->lit);
	const int64_t end_us = (length_us == UNENDING) ? TIME_NEVER_US : self->phase_us + length_us;

	self->next_us = (end_us < now_us) ? now_us : end_us;
	if (is_strobe(self)) {
		/* Lit: this is cycle 0. Dark: cycle 0 is the one that begins at its end. */
		self->origin_us = self->lit ? self->next_us - self->on_us : self->next_us;
		self->cycle = self->lit ? 0 : -1;
	}
	return strobe_advance(self, now_us);
}

int64_t strobe_deadline_us(const struct strobe *self)
{
	return self->next_us;
}
