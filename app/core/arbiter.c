/* SPDX-License-Identifier: Apache-2.0 */
#include "core/arbiter.h"

#include "core/assert.h"

#define NEVER_YET (-1)

static bool can_command(enum arbiter_source source)
{
	return source >= ARBITER_SOURCE_MAVLINK && source <= ARBITER_SOURCE_SHELL;
}

void arbiter_configure(struct arbiter *self, const struct arbiter_config *config)
{
	PHAROS_ASSERT(config->priority == ARBITER_SOURCE_NONE || can_command(config->priority));
	PHAROS_ASSERT(config->hold_us >= 0 && config->hold_us <= TIME_MAX_US);
	PHAROS_ASSERT(config->loss_us >= 0 && config->loss_us <= TIME_MAX_US);
	if (config->priority != self->config.priority) {
		self->ranked_us = NEVER_YET;
	}
	self->config = *config;
}

void arbiter_init(struct arbiter *self, const struct arbiter_config *config)
{
	*self = (struct arbiter){.ranked_us = NEVER_YET, .heard_us = NEVER_YET};
	arbiter_configure(self, config);
}

bool arbiter_is_outranked(const struct arbiter *self, int64_t now_us, enum arbiter_source source)
{
	PHAROS_ASSERT(can_command(source));
	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	return source != self->config.priority && self->ranked_us != NEVER_YET &&
	       now_us - self->ranked_us < self->config.hold_us;
}

void arbiter_commit(struct arbiter *self, int64_t now_us, enum arbiter_source source)
{
	arbiter_heard(self, now_us, source);
	self->commander = source;
	self->commanded_us = now_us;
	if (source == self->config.priority) {
		self->ranked_us = now_us;
	}
}

void arbiter_heard(struct arbiter *self, int64_t now_us, enum arbiter_source source)
{
	PHAROS_ASSERT(can_command(source));
	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	self->heard_us = now_us;
	self->lost = false;
}

int64_t arbiter_deadline_us(const struct arbiter *self)
{
	if (self->config.loss_us == 0 || self->heard_us == NEVER_YET || self->lost) {
		return TIME_NEVER_US;
	}
	return self->heard_us + self->config.loss_us;
}

bool arbiter_advance(struct arbiter *self, int64_t now_us)
{
	if (now_us < arbiter_deadline_us(self)) {
		return false;
	}
	self->lost = true;
	if (self->config.fallback != ILLUMINATOR_FALLBACK_KEEP) {
		self->commander = ARBITER_SOURCE_FALLBACK;
		self->commanded_us = now_us;
	}
	return true;
}

const char *arbiter_source_name(enum arbiter_source source)
{
	switch (source) {
	case ARBITER_SOURCE_NONE:
		return "none";
	case ARBITER_SOURCE_MAVLINK:
		return "mavlink";
	case ARBITER_SOURCE_DRONECAN:
		return "dronecan";
	case ARBITER_SOURCE_IMC:
		return "imc";
	case ARBITER_SOURCE_SHELL:
		return "shell";
	case ARBITER_SOURCE_FALLBACK:
		return "fallback";
	}
	PHAROS_ASSERT(false);
	return "";
}
