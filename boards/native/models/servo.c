/* SPDX-License-Identifier: Apache-2.0 */
#include "models/servo.h"

#include <math.h>

void servo_advance(struct servo *self, int64_t now_us)
{
	if (now_us <= self->time_us) {
		return;
	}

	const double most_mdeg = (double)(now_us - self->time_us) * SERVO_SPEED_MDEG_PER_S * 1e-6;
	const double left_mdeg = self->target_mdeg - self->angle_mdeg;

	self->time_us = now_us;
	if (self->pulse_ns != 0) {
		self->angle_mdeg += fmax(-most_mdeg, fmin(most_mdeg, left_mdeg));
	}
}

void servo_set_pulse_ns(struct servo *self, int64_t now_us, uint32_t pulse_ns)
{
	const double off_middle_ns = (double)pulse_ns - SERVO_MIDDLE_NS;
	const double wanted_mdeg = off_middle_ns / SERVO_NS_PER_DEGREE * 1000.0;

	servo_advance(self, now_us);
	self->pulse_ns = pulse_ns;
	if (pulse_ns != 0) {
		self->target_mdeg = fmax(-SERVO_END_MDEG, fmin(SERVO_END_MDEG, wanted_mdeg));
	}
}
