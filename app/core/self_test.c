/* SPDX-License-Identifier: Apache-2.0 */
#include "core/self_test.h"

#include "core/assert.h"

void self_test_init(struct self_test *self)
{
	*self = (struct self_test){.state = SELF_TEST_NONE};
}

void self_test_driver(struct self_test *self, bool fault)
{
	self->driver_fault = fault;
}

/* What is wrong with the device; NONE: nothing. */
static enum self_test_state defect(const struct self_test *self, const struct illuminator *light)
{
	if (light->unpowered) {
		return SELF_TEST_NO_POWER;
	}
	if (light->thermal.sensor != THERMAL_SENSOR_OK) {
		return SELF_TEST_SENSOR_FAILED;
	}
	if (light->thermal.state == THERMAL_STATE_SHUTDOWN) {
		return SELF_TEST_TOO_HOT;
	}
	return self->driver_fault ? SELF_TEST_DRIVER_FAILED : SELF_TEST_NONE;
}

enum self_test_state self_test_obstacle(const struct self_test *self,
                                        const struct illuminator *light)
{
	return self->state == SELF_TEST_RUNNING ? SELF_TEST_RUNNING : defect(self, light);
}

static struct illuminator_event show(bool on, uint32_t brightness_ppm)
{
	return (struct illuminator_event){
		.kind = ILLUMINATOR_EVENT_TEST,
		.test = {.on = on, .brightness_ppm = brightness_ppm},
	};
}

struct illuminator_event self_test_first(void)
{
	return show(true, 0);
}

void self_test_begin(struct self_test *self, int64_t now_us, uint32_t peak_ppm)
{
	PHAROS_ASSERT(self->state != SELF_TEST_RUNNING);
	PHAROS_ASSERT(peak_ppm > 0 && peak_ppm <= PPM_ONE);
	self->state = SELF_TEST_RUNNING;
	self->peak_ppm = peak_ppm;
	self->step = 0;
	self->step_us = now_us + SELF_TEST_STEP_US;
}

/* Up in the first half of the steps, down in the second. */
static uint32_t brightness_ppm(const struct self_test *self)
{
	const uint32_t half = SELF_TEST_STEPS / 2;
	const uint32_t height = self->step <= half ? self->step : SELF_TEST_STEPS - self->step;

	return (uint32_t)((uint64_t)self->peak_ppm * height / half);
}

static bool end(struct self_test *self, enum self_test_state state, struct illuminator_event *event)
{
	self->state = state;
	*event = show(false, 0);
	return true;
}

bool self_test_step(struct self_test *self, int64_t now_us, const struct illuminator *light,
                    struct illuminator_event *event)
{
	if (self->state != SELF_TEST_RUNNING) {
		return false;
	}

	const enum self_test_state wrong = defect(self, light);

	if (!light->test.on) {
		self->state = wrong != SELF_TEST_NONE ? wrong : SELF_TEST_INTERRUPTED;
		return false;
	}
	if (wrong != SELF_TEST_NONE) {
		return end(self, wrong, event);
	}
	if (now_us < self->step_us) {
		return false;
	}
	self->step++;
	self->step_us += SELF_TEST_STEP_US;
	if (self->step == SELF_TEST_STEPS) {
		return end(self, SELF_TEST_PASSED, event);
	}
	*event = show(true, brightness_ppm(self));
	return true;
}

struct illuminator_event self_test_cancel(struct self_test *self)
{
	PHAROS_ASSERT(self->state == SELF_TEST_RUNNING);
	self->state = SELF_TEST_CANCELLED;
	return show(false, 0);
}

int64_t self_test_deadline_us(const struct self_test *self)
{
	return self->state == SELF_TEST_RUNNING ? self->step_us : TIME_NEVER_US;
}

uint8_t self_test_percent(const struct self_test *self)
{
	return (uint8_t)(self->step * 100 / SELF_TEST_STEPS);
}

const char *self_test_text(enum self_test_state state)
{
	switch (state) {
	case SELF_TEST_NONE:
		return "none yet";
	case SELF_TEST_RUNNING:
		return "running";
	case SELF_TEST_PASSED:
		return "passed";
	case SELF_TEST_SENSOR_FAILED:
		return "temperature sensor failed";
	case SELF_TEST_DRIVER_FAILED:
		return "lamp driver reports a fault";
	case SELF_TEST_TOO_HOT:
		return "over temperature";
	case SELF_TEST_NO_POWER:
		return "lamp has no power";
	case SELF_TEST_INTERRUPTED:
		return "interrupted by a command";
	case SELF_TEST_CANCELLED:
		return "cancelled";
	}
	PHAROS_ASSERT(false);
	return "";
}
