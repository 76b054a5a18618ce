/* SPDX-License-Identifier: Apache-2.0 */
#include "models/lamp.h"

#include <stddef.h>
#include <string.h>

#define PPM 1000000u

void lamp_init(struct lamp *self, uint32_t full_mw)
{
	/* not by assignment: the log is too large for a temporary on a thread's stack */
	memset(self, 0, sizeof(*self));
	self->full_mw = full_mw;
}

void lamp_advance(struct lamp *self, int64_t now_us)
{
	if (now_us <= self->time_us) {
		return;
	}

	const uint64_t step_us = (uint64_t)(now_us - self->time_us);

	self->time_us = now_us;
	if (self->level_ppm == 0) {
		return;
	}
	/* whole and part apart: no overflow within 580 years */
	const uint64_t part = (step_us % PPM) * self->level_ppm + self->light_rest_ppm_us;

	self->light_us += (step_us / PPM) * self->level_ppm + part / PPM;
	self->light_rest_ppm_us = (uint32_t)(part % PPM);
	self->lit_us += step_us;
}

static bool update(struct lamp *self, int64_t now_us)
{
	const uint32_t level_ppm = self->enabled ? self->duty_ppm : 0;
	const bool edge = (level_ppm == 0) != (self->level_ppm == 0);

	if (level_ppm == self->level_ppm) {
		return false;
	}
	lamp_advance(self, now_us);
	self->log[self->changes % LAMP_LOG_SIZE] = (struct lamp_change){
		.time_us = now_us,
		.level_ppm = level_ppm,
	};
	self->changes++;
	self->edges += edge ? 1 : 0;
	self->level_ppm = level_ppm;
	if (level_ppm > self->peak_ppm) {
		self->peak_ppm = level_ppm;
	}
	return true;
}

bool lamp_set_duty(struct lamp *self, int64_t now_us, uint32_t duty_ppm)
{
	self->duty_ppm = duty_ppm;
	return update(self, now_us);
}

bool lamp_set_enable(struct lamp *self, int64_t now_us, bool enabled)
{
	self->enabled = enabled;
	return update(self, now_us);
}

double lamp_power_w(const struct lamp *self)
{
	return (double)self->full_mw * 1e-3 * (double)self->level_ppm * 1e-6;
}

double lamp_energy_mj(const struct lamp *self)
{
	const double full_us = (double)self->light_us + (double)self->light_rest_ppm_us / PPM;

	return full_us * 1e-6 * (double)self->full_mw;
}

void lamp_reset_totals(struct lamp *self, int64_t now_us)
{
	lamp_advance(self, now_us);
	self->light_us = 0;
	self->light_rest_ppm_us = 0;
	self->lit_us = 0;
	self->peak_ppm = self->level_ppm;
}

uint64_t lamp_oldest_change(const struct lamp *self)
{
	return self->changes > LAMP_LOG_SIZE ? self->changes - LAMP_LOG_SIZE : 0;
}

const struct lamp_change *lamp_change_at(const struct lamp *self, uint64_t n)
{
	if (n < lamp_oldest_change(self) || n >= self->changes) {
		return NULL;
	}
	return &self->log[n % LAMP_LOG_SIZE];
}
