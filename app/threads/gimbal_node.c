/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/gimbal_node.h"

#include <zephyr/device.h>
#include <zephyr/logging/log.h>

#include <pharos/drivers/servo.h>

#include "core/assert.h"
#include "threads/clock.h"
#include "threads/command.h"
#include "threads/devices.h"

LOG_MODULE_REGISTER(gimbal);

/* The same sources as the light's, and the same ranks; silence changes nothing. */
static void arbiter_config(const struct params *params, struct arbiter_config *config)
{
	params_arbiter(params, config);
	config->loss_us = 0;
}

static bool has_servos(void)
{
	const struct device *const servos[] = {devices.servo_pan, devices.servo_tilt};

	for (size_t i = 0; i < ARRAY_SIZE(servos); i++) {
		if (servos[i] == NULL) {
			return false;
		}
		if (!device_is_ready(servos[i])) {
			LOG_ERR("%s is not ready; no gimbal", servos[i]->name);
			return false;
		}
	}
	return true;
}

void gimbal_node_init(struct command *command)
{
	struct gimbal_node *const self = &command->gimbal;
	struct arbiter_config arbiter;
	struct gimbal_config config;

	if (command->params.values[PARAM_GMB_ENABLE] == 0 || !has_servos()) {
		return;
	}
	params_gimbal(&command->params, &config);
	arbiter_config(&command->params, &arbiter);
	gimbal_init(&self->gimbal, clock_now_us(), &config);
	arbiter_init(&self->arbiter, &arbiter);
	self->active = true;
}

void gimbal_node_configure(struct command *command, const struct param_set *changed)
{
	struct gimbal_node *const self = &command->gimbal;

	if (!self->active) {
		return;
	}
	if (param_set_touches(changed, PARAM_GROUP_GIMBAL)) {
		struct gimbal_event event = {.kind = GIMBAL_EVENT_CONFIG};

		params_gimbal(&command->params, &event.config);
		(void)gimbal_step(&self->gimbal, clock_now_us(), &event);
	}
	if (param_set_touches(changed, PARAM_GROUP_ARBITER)) {
		struct arbiter_config config;

		arbiter_config(&command->params, &config);
		arbiter_configure(&self->arbiter, &config);
	}
}

static void told(struct gimbal_node *self, bool fault, int error)
{
	const struct gimbal_event event = {.kind = GIMBAL_EVENT_FAULT, .fault = fault};

	if (self->gimbal.fault != fault) {
		(void)gimbal_step(&self->gimbal, clock_now_us(), &event);
		if (fault) {
			LOG_ERR("cannot drive the servos: error %d", error);
		} else {
			LOG_INF("the servos can be driven again");
		}
	}
}

void gimbal_node_step(struct command *command)
{
	struct gimbal_node *const self = &command->gimbal;
	struct gimbal_outbox out;

	if (!self->active) {
		return;
	}
	gimbal_advance(&self->gimbal, clock_now_us(), &out);
	if (out.move) {
		const int pan = servo_set_pulse(devices.servo_pan, out.pulse_ns[GIMBAL_PAN]);
		const int tilt = servo_set_pulse(devices.servo_tilt, out.pulse_ns[GIMBAL_TILT]);

		self->servo_errors += pan != 0 || tilt != 0 ? 1 : 0;
		told(self, pan != 0 || tilt != 0, pan != 0 ? pan : tilt);
	}
}

int64_t gimbal_node_deadline_us(const struct command *command)
{
	return command->gimbal.active ? gimbal_deadline_us(&command->gimbal.gimbal) : TIME_NEVER_US;
}

bool gimbal_node_is_active(const struct command *command)
{
	return command->gimbal.active;
}

int32_t gimbal_node_share_mdeg(const struct command *command, enum gimbal_axis_id axis,
                               int32_t share_ppm)
{
	PHAROS_ASSERT(command->gimbal.active);
	return gimbal_share_mdeg(&command->gimbal.gimbal, axis, share_ppm);
}

int32_t gimbal_node_share_rate(const struct command *command, enum gimbal_axis_id axis,
                               int32_t share_ppm)
{
	PHAROS_ASSERT(command->gimbal.active);
	const int64_t fastest = command->gimbal.gimbal.config.axes[axis].rate_mdeg_per_s;

	return (int32_t)(fastest * share_ppm / (int32_t)PPM_ONE);
}

enum arbiter_source gimbal_node_commander(const struct command *command)
{
	return command->gimbal.active ? command->gimbal.arbiter.commander : ARBITER_SOURCE_NONE;
}

enum arbiter_verdict command_point(struct command *command, enum arbiter_source source,
                                   const struct gimbal_event *event, enum gimbal_result *result)
{
	struct gimbal_node *const self = &command->gimbal;
	const int64_t now_us = clock_now_us();

	*result = GIMBAL_ABSENT;
	if (!self->active) {
		return ARBITER_GRANTED;
	}

	const enum arbiter_verdict verdict = arbiter_check(&self->arbiter, now_us, source);

	if (verdict == ARBITER_GRANTED) {
		*result = gimbal_step(&self->gimbal, now_us, event);
		if (*result == GIMBAL_ACCEPTED) {
			arbiter_commit(&self->arbiter, now_us, source);
		}
	}
	return verdict;
}
