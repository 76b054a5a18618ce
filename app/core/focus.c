/* SPDX-License-Identifier: Apache-2.0 */
#include "core/focus.h"

#include "core/assert.h"

#define OVERRUN_DIVISOR 10

_Static_assert(FOCUS_TRAVEL_MAX_US < INT64_MAX / (2 * (int64_t)PPM_ONE), "time times ratio fits");

void focus_init(struct focus *self, int64_t travel_us)
{
	PHAROS_ASSERT(travel_us > 0 && travel_us <= FOCUS_TRAVEL_MAX_US);
	*self = (struct focus){.travel_us = travel_us, .end_us = TIME_NEVER_US};
}

uint32_t focus_position_ppm(const struct focus *self, int64_t now_us)
{
	if (self->motor == FOCUS_MOTOR_STOPPED) {
		return self->start_ppm;
	}
	const int64_t run_us = (now_us - self->start_us < self->travel_us) ? now_us - self->start_us
	                                                                   : self->travel_us;
	const uint32_t way_ppm = (uint32_t)(run_us * (int64_t)PPM_ONE / self->travel_us);

	if (self->motor == FOCUS_MOTOR_IN) {
		const uint32_t left_ppm = self->end_ppm - self->start_ppm;

		return self->start_ppm + (way_ppm < left_ppm ? way_ppm : left_ppm);
	}
	const uint32_t left_ppm = self->start_ppm - self->end_ppm;

	return self->start_ppm - (way_ppm < left_ppm ? way_ppm : left_ppm);
}

static void stop(struct focus *self, int64_t now_us)
{
	self->start_ppm = focus_position_ppm(self, now_us);
	self->motor = FOCUS_MOTOR_STOPPED;
	self->end_us = TIME_NEVER_US;
}

/* way_ppm: how far at most; rounded up, and on into an end. */
static void run(struct focus *self, int64_t now_us, uint32_t end_ppm, uint32_t way_ppm)
{
	const bool into_end = end_ppm == 0 || end_ppm == PPM_ONE;
	const int64_t way_us =
		(self->travel_us * (int64_t)way_ppm + (int64_t)PPM_ONE - 1) / (int64_t)PPM_ONE;

	self->start_us = now_us;
	self->end_ppm = end_ppm;
	self->end_us = now_us + way_us + (into_end ? self->travel_us / OVERRUN_DIVISOR : 0);
}

void focus_move(struct focus *self, int64_t now_us, uint32_t position_ppm)
{
	PHAROS_ASSERT(position_ppm <= PPM_ONE);
	stop(self, now_us);
	if (position_ppm == self->start_ppm) {
		return;
	}
	const bool in = position_ppm > self->start_ppm;

	self->motor = in ? FOCUS_MOTOR_IN : FOCUS_MOTOR_OUT;
	run(self, now_us, position_ppm,
	    in ? position_ppm - self->start_ppm : self->start_ppm - position_ppm);
}

bool focus_command(struct focus *self, int64_t now_us, uint32_t action)
{
	if (action >= FOCUS_ACTIONS) {
		return false;
	}
	switch ((enum focus_action)action) {
	case FOCUS_ACTION_RESET:
		stop(self, now_us);
		self->motor = FOCUS_MOTOR_OUT;
		run(self, now_us, 0, PPM_ONE);
		break;
	case FOCUS_ACTION_IN:
		focus_move(self, now_us, PPM_ONE);
		break;
	case FOCUS_ACTION_OUT:
		focus_move(self, now_us, 0);
		break;
	case FOCUS_ACTION_STOP:
		stop(self, now_us);
		break;
	}
	return true;
}

void focus_advance(struct focus *self, int64_t now_us)
{
	if (self->end_us <= now_us) {
		self->start_ppm = self->end_ppm;
		self->motor = FOCUS_MOTOR_STOPPED;
		self->end_us = TIME_NEVER_US;
	}
}

int64_t focus_deadline_us(const struct focus *self)
{
	return self->end_us;
}
