/* SPDX-License-Identifier: Apache-2.0 */
#include "core/gate.h"

#include "core/assert.h"
#include "core/limits.h"

static const struct light_plan dark = {.on = false};

static bool follows_sync(const struct gate *self)
{
	return self->plan.on && self->plan.external_sync;
}

static bool runs_program(const struct gate *self)
{
	return self->plan.on && self->plan.program.kind != PROGRAM_NONE;
}

static bool refresh(struct gate *self, int64_t now_us)
{
	if (now_us > self->now_us) {
		self->now_us = now_us;
	}
	if (runs_program(self)) {
		strobe_set(&self->strobe, self->now_us, &dark);
		self->phase = program_at(&self->plan.program, self->now_us - self->program_us);
		return self->phase.scale_ppm > 0;
	}
	if (!follows_sync(self)) {
		return strobe_set(&self->strobe, self->now_us, &self->plan);
	}
	switch (sync_advance(&self->sync, self->now_us)) {
	case SYNC_OUTPUT_DARK:
		strobe_set(&self->strobe, self->now_us, &dark);
		return false;
	case SYNC_OUTPUT_LIT:
		strobe_set(&self->strobe, self->now_us, &dark);
		return true;
	case SYNC_OUTPUT_INTERNAL:
		return strobe_set(&self->strobe, self->now_us, &self->plan);
	}
	PHAROS_ASSERT(false);
	return false;
}

void gate_init(struct gate *self, int64_t now_us, const struct sync_config *sync, bool level)
{
	*self = (struct gate){.plan = dark, .now_us = now_us, .level = level};
	strobe_init(&self->strobe);
	sync_init(&self->sync, now_us, sync, level);
}

bool gate_set(struct gate *self, int64_t now_us, const struct light_plan *plan)
{
	const bool followed = follows_sync(self);
	const bool ran = runs_program(self);

	PHAROS_ASSERT(program_valid(&plan->program));
	refresh(self, now_us);
	if (!ran || !program_equal(&self->plan.program, &plan->program)) {
		self->program_us = self->now_us;
	}
	self->plan = *plan;
	if (follows_sync(self) && !followed) {
		const struct sync_config config = self->sync.config;

		sync_configure(&self->sync, self->now_us, &config, self->level);
	}
	return refresh(self, now_us);
}

bool gate_configure(struct gate *self, int64_t now_us, const struct sync_config *sync)
{
	refresh(self, now_us);
	sync_configure(&self->sync, self->now_us, sync, self->level);
	return refresh(self, now_us);
}

bool gate_input(struct gate *self, int64_t at_us, bool level)
{
	self->level = level;
	if (follows_sync(self)) {
		sync_input(&self->sync, at_us, level);
	}
	return refresh(self, at_us);
}

bool gate_advance(struct gate *self, int64_t now_us)
{
	return refresh(self, now_us);
}

uint32_t gate_level_ppm(const struct gate *self)
{
	const uint64_t scale_ppm = runs_program(self) ? self->phase.scale_ppm : PPM_ONE;

	return (uint32_t)(self->plan.level_ppm * scale_ppm / PPM_ONE);
}

int64_t gate_deadline_us(const struct gate *self)
{
	if (runs_program(self)) {
		return self->program_us + self->phase.until_us;
	}

	const int64_t strobe_us = strobe_deadline_us(&self->strobe);
	const int64_t sync_us = follows_sync(self) ? sync_deadline_us(&self->sync) : TIME_NEVER_US;

	return (sync_us < strobe_us) ? sync_us : strobe_us;
}
