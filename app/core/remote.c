/* SPDX-License-Identifier: Apache-2.0 */
#include "core/remote.h"

#include "core/assert.h"

#define AXIS_MAX_PPM ((int32_t)PPM_ONE)

void remote_init(struct remote *self)
{
	*self = (struct remote){.release_us = TIME_NEVER_US, .renew_us = TIME_NEVER_US};
}

static bool axis_valid(int32_t value_ppm)
{
	return value_ppm >= -AXIS_MAX_PPM && value_ppm <= AXIS_MAX_PPM;
}

static bool axes_move(const struct remote_input *input)
{
	return input->pan_ppm != 0 || input->tilt_ppm != 0;
}

static struct remote_output change(struct remote *self, int64_t now_us,
                                   const struct remote_input *input)
{
	const struct remote_input before = self->input;

	self->input = *input;
	self->renew_us = axes_move(input) ? now_us + REMOTE_RENEW_US : TIME_NEVER_US;
	return (struct remote_output){
		.toggle_light = input->light && !before.light,
		.toggle_strobe = input->strobe && !before.strobe,
		.set_brightness = input->brightness_ppm != 0 &&
	                          input->brightness_ppm != before.brightness_ppm,
		.move = axes_move(input) || axes_move(&before),
		.brightness_ppm = input->brightness_ppm,
		.pan_ppm = input->pan_ppm,
		.tilt_ppm = input->tilt_ppm,
	};
}

struct remote_output remote_update(struct remote *self, int64_t now_us,
                                   const struct remote_input *input)
{
	PHAROS_ASSERT(input->brightness_ppm <= PPM_ONE);
	PHAROS_ASSERT(axis_valid(input->pan_ppm) && axis_valid(input->tilt_ppm));
	self->release_us = now_us + REMOTE_HOLD_US;
	return change(self, now_us, input);
}

struct remote_output remote_advance(struct remote *self, int64_t now_us)
{
	static const struct remote_input released;

	if (now_us >= self->release_us) {
		self->release_us = TIME_NEVER_US;
		return change(self, now_us, &released);
	}
	if (now_us >= self->renew_us) {
		const struct remote_input same = self->input;

		return change(self, now_us, &same);
	}
	return (struct remote_output){.move = false};
}

int64_t remote_deadline_us(const struct remote *self)
{
	return (self->renew_us < self->release_us) ? self->renew_us : self->release_us;
}
