/* SPDX-License-Identifier: Apache-2.0 */
#include "core/sync.h"

#include "core/assert.h"
#include "core/limits.h"

static int64_t filtered_us(const struct sync *self)
{
	return self->pending ? self->pending_us + self->config.filter_us : TIME_NEVER_US;
}

static int64_t timeout_us(const struct sync *self)
{
	const bool armed = self->config.timeout_us > 0 && !self->timed_out;

	return armed ? self->activity_us + self->config.timeout_us : TIME_NEVER_US;
}

static bool is_active(const struct sync *self, bool level)
{
	return level == (self->config.polarity == SYNC_ACTIVE_HIGH);
}

void sync_configure(struct sync *self, int64_t now_us, const struct sync_config *config, bool level)
{
	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	PHAROS_ASSERT(config->pulse_us >= 1);
	const struct sync_stats stats = self->stats;

	*self = (struct sync){
		.config = *config,
		.stats = stats,
		.now_us = now_us,
		.activity_us = now_us,
		.pulse_end_us = now_us,
	};
	self->active = is_active(self, level);
}

void sync_init(struct sync *self, int64_t now_us, const struct sync_config *config, bool level)
{
	*self = (struct sync){.now_us = now_us};
	sync_configure(self, now_us, config, level);
}

static void edge_to_active(struct sync *self, int64_t at_us)
{
	const bool pulsing = at_us < self->pulse_end_us;

	if (pulsing && self->config.retrigger == SYNC_RETRIGGER_IGNORE) {
		self->stats.ignored++;
		return;
	}
	self->stats.pulses++;
	self->pulse_end_us = at_us + self->config.pulse_us;
}

static void accept_change(struct sync *self, int64_t at_us)
{
	self->pending = false;
	self->active = !self->active;
	self->stats.changes++;
	self->activity_us = at_us;
	self->timed_out = false;
	if (self->config.mode == SYNC_MODE_EDGE && self->active) {
		edge_to_active(self, at_us);
	}
}

/* At most: a time-out, the change that ends it, and the next time-out. */
static void settle(struct sync *self, int64_t now_us)
{
	for (uint32_t i = 0; i < 3; i++) {
		const int64_t change_us = filtered_us(self);
		const int64_t silence_us = timeout_us(self);

		if (change_us <= now_us && change_us <= silence_us) {
			accept_change(self, change_us);
		} else if (silence_us <= now_us) {
			self->timed_out = true;
			self->stats.timeouts++;
		}
	}
	self->now_us = now_us;
}

void sync_input(struct sync *self, int64_t at_us, bool level)
{
	PHAROS_ASSERT(at_us >= 0 && at_us <= TIME_MAX_US);
	if (at_us < self->now_us) {
		self->stats.late++;
		at_us = self->now_us;
	}
	settle(self, at_us);
	const bool differs = is_active(self, level) != self->active;

	if (self->pending && !differs) {
		self->pending = false;
		self->stats.glitches++;
	} else if (!self->pending && differs) {
		self->pending = true;
		self->pending_us = at_us;
		settle(self, at_us);
	}
}

static enum sync_output output(const struct sync *self)
{
	if (self->timed_out) {
		switch (self->config.policy) {
		case SYNC_POLICY_OFF:
			return SYNC_OUTPUT_DARK;
		case SYNC_POLICY_ON:
			return SYNC_OUTPUT_LIT;
		case SYNC_POLICY_INTERNAL:
			return SYNC_OUTPUT_INTERNAL;
		}
	}
	const bool lit = (self->config.mode == SYNC_MODE_LEVEL) ? self->active
	                                                        : self->now_us < self->pulse_end_us;

	return lit ? SYNC_OUTPUT_LIT : SYNC_OUTPUT_DARK;
}

enum sync_output sync_advance(struct sync *self, int64_t now_us)
{
	PHAROS_ASSERT(now_us <= TIME_MAX_US);
	if (now_us > self->now_us) {
		settle(self, now_us);
	}
	return output(self);
}

int64_t sync_deadline_us(const struct sync *self)
{
	int64_t deadline_us = filtered_us(self);

	if (timeout_us(self) < deadline_us) {
		deadline_us = timeout_us(self);
	}
	if (!self->timed_out && self->now_us < self->pulse_end_us &&
	    self->pulse_end_us < deadline_us) {
		deadline_us = self->pulse_end_us;
	}
	return deadline_us;
}
