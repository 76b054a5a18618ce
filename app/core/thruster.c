/* SPDX-License-Identifier: Apache-2.0 */
#include "core/thruster.h"

#include "core/assert.h"

void thruster_configure(struct thruster *self, const struct thruster_config *config)
{
	PHAROS_ASSERT(config->min_us >= SERVO_PULSE_MIN_US && config->min_us < config->max_us);
	PHAROS_ASSERT(config->max_us <= SERVO_PULSE_MAX_US);
	PHAROS_ASSERT(config->arm_us >= 0 && config->arm_us <= TIME_MAX_US);
	PHAROS_ASSERT(config->loss_us > 0 && config->loss_us <= TIME_MAX_US);
	self->config = *config;
	self->value_ppm = 0;
	self->neutral_us = TIME_NEVER_US;
}

void thruster_restart(struct thruster *self, int64_t now_us)
{
	self->value_ppm = 0;
	self->neutral_us = TIME_NEVER_US;
	self->armed_us = now_us + self->config.arm_us;
}

void thruster_init(struct thruster *self, int64_t now_us, const struct thruster_config *config)
{
	thruster_configure(self, config);
	thruster_restart(self, now_us);
}

bool thruster_set(struct thruster *self, int64_t now_us, int32_t value_ppm)
{
	PHAROS_ASSERT(value_ppm >= -(int32_t)PPM_ONE && value_ppm <= (int32_t)PPM_ONE);
	if (now_us < self->armed_us) {
		return false;
	}
	self->value_ppm = value_ppm;
	self->neutral_us = (value_ppm == 0) ? TIME_NEVER_US : now_us + self->config.loss_us;
	return true;
}

void thruster_advance(struct thruster *self, int64_t now_us)
{
	if (self->neutral_us <= now_us) {
		self->value_ppm = 0;
		self->neutral_us = TIME_NEVER_US;
	}
}

int64_t thruster_deadline_us(const struct thruster *self)
{
	return self->neutral_us;
}

uint32_t thruster_pulse_us(const struct thruster *self)
{
	const int64_t span_us = (int64_t)self->config.max_us - self->config.min_us;
	/* 0…2 PPM_ONE from one end to the other */
	const int64_t part = self->value_ppm + (int64_t)PPM_ONE;

	return self->config.min_us +
	       (uint32_t)((span_us * part + (int64_t)PPM_ONE) / (2 * PPM_ONE));
}
