/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/self_test_service.h"

#include "proto/mavlink/dialect.h"
#include "proto/mavlink/illuminator_service.h"
#include "proto/mavlink/internal.h"

#include <string.h>

#define USER_1_SELF_TEST 1
#define TELL_PERCENT     10

void mavlink_self_test_init(struct mavlink_self_test *self, struct pharos_device *device,
                            uint8_t lamp)
{
	*self = (struct mavlink_self_test){.device = device, .lamp = lamp};
}

static const struct self_test *test_of(const struct mavlink_self_test *self)
{
	return &pharos_device_lamp(self->device, self->lamp)->self_test;
}

/* Percent of the wire; 0 and "not given" are all. */
static bool peak_of(float wire, uint32_t *peak_ppm)
{
	if (wire != wire || wire == 0.0f) {
		*peak_ppm = PPM_ONE;
		return true;
	}
	if (!(wire > 0.0f && wire <= 100.0f)) {
		return false;
	}
	*peak_ppm = (uint32_t)(wire * (PPM_ONE / 100.0f) + 0.5f);
	*peak_ppm += *peak_ppm == 0 ? 1 : 0;
	return true;
}

bool mavlink_self_test_knows(const struct mavlink_command *command)
{
	uint32_t what;

	return mavlink_whole(command->param[0], UINT8_MAX, &what) && what == USER_1_SELF_TEST;
}

uint8_t mavlink_self_test_run(const struct mavlink_context *context,
                              const struct mavlink_command *command, struct mavlink_reply *reply)
{
	struct mavlink_illuminator *const service = context->component->service;
	struct mavlink_self_test *const self = &service->self_test;
	const struct device_who who = mavlink_who(context);
	enum self_test_state obstacle;
	uint32_t peak_ppm;

	if (!peak_of(command->param[1], &peak_ppm)) {
		return MAV_RESULT_DENIED;
	}

	const enum device_result result = pharos_device_test(self->device, context->now_us, &who,
	                                                     self->lamp, peak_ppm, &obstacle);

	if (obstacle == SELF_TEST_RUNNING) {
		return MAV_RESULT_TEMPORARILY_REJECTED; /* someone else's */
	}
	if (result != DEVICE_ACCEPTED) {
		reply->detail = (int32_t)obstacle;
		return mavlink_result(result);
	}
	self->asked = true;
	self->told_percent = 0;
	return MAV_RESULT_IN_PROGRESS;
}

bool mavlink_self_test_cancel(const struct mavlink_context *context)
{
	struct mavlink_illuminator *const service = context->component->service;
	struct mavlink_self_test *const self = &service->self_test;

	const struct device_who who = mavlink_who(context);

	if (!pharos_device_cancel_test(self->device, context->now_us, &who, self->lamp)) {
		return false;
	}
	self->asked = false;
	return true;
}

static void tell_people(const struct mavlink_context *context, enum self_test_state state)
{
	char text[MAVLINK_TEXT_BYTES] = "Self-test: ";
	const size_t start = strlen(text);
	const char *const what = self_test_text(state);

	for (size_t i = 0; start + i + 1 < sizeof(text) && what[i] != '\0'; i++) {
		text[start + i] = what[i];
	}
	(void)mavlink_endpoint_text(
		context->endpoint, context->now_us,
		state == SELF_TEST_PASSED ? MAV_SEVERITY_INFO : MAV_SEVERITY_WARNING, text);
}

bool mavlink_self_test_step(struct mavlink_self_test *self, const struct mavlink_context *context)
{
	const enum self_test_state state = test_of(self)->state;

	if (mavlink_self_test_deadline_us(self) > context->now_us) {
		return true;
	}
	if (!mavlink_outbox_has_room(context->out)) {
		return false;
	}
	if (state == SELF_TEST_RUNNING) {
		self->told_percent = self_test_percent(test_of(self));
		mavlink_command_progress(context, self->told_percent);
		return true;
	}
	self->asked = false;
	mavlink_command_done(context,
	                     state == SELF_TEST_PASSED ? MAV_RESULT_ACCEPTED : MAV_RESULT_FAILED,
	                     (int32_t)state);
	tell_people(context, state);
	return true;
}

/* At once, when there is news; the owner of the test wakes for its next. */
int64_t mavlink_self_test_deadline_us(const struct mavlink_self_test *self)
{
	const struct self_test *const test = test_of(self);
	const bool news = test->state != SELF_TEST_RUNNING ||
	                  self_test_percent(test) >= self->told_percent + TELL_PERCENT;

	return self->asked && news ? 0 : TIME_NEVER_US;
}
