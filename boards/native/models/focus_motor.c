/* SPDX-License-Identifier: Apache-2.0 */
#include "models/focus_motor.h"

void focus_motor_init(struct focus_motor *self, int64_t travel_us)
{
	*self = (struct focus_motor){.travel_us = travel_us};
}

void focus_motor_advance(struct focus_motor *self, int64_t now_us)
{
	if (now_us <= self->time_us) {
		return;
	}
	self->at_us += self->direction * (now_us - self->time_us);
	self->time_us = now_us;
	if (self->at_us < 0) {
		self->at_us = 0;
	} else if (self->at_us > self->travel_us) {
		self->at_us = self->travel_us;
	}
}

void focus_motor_run(struct focus_motor *self, int64_t now_us, bool in, bool out)
{
	focus_motor_advance(self, now_us);
	self->direction = (in ? 1 : 0) - (out ? 1 : 0);
}

int64_t focus_motor_ppm(const struct focus_motor *self)
{
	return self->at_us * 1000000 / self->travel_us;
}
