/* SPDX-License-Identifier: Apache-2.0 */
#include "core/device.h"

#include "core/assert.h"
#include "core/device_internal.h"

#include <string.h>

_Static_assert(DEVICE_LAMPS_MAX <= 8, "a bit per lamp");
_Static_assert(ILLUMINATOR_NOTICE_SENSOR_OK < 8, "a bit per kind of notice");
/* What a machine says is the first part of what the device says. */
#define SAYS(machine, result) ((int)machine##_##result == (int)DEVICE_##result)
_Static_assert(SAYS(ILLUMINATOR, ACCEPTED) && SAYS(ILLUMINATOR, DENIED), "illuminator");
_Static_assert(SAYS(ILLUMINATOR, FAILED) && SAYS(ACTUATORS, FAILED), "either");
_Static_assert(SAYS(ACTUATORS, ACCEPTED) && SAYS(ACTUATORS, DENIED), "actuators");
_Static_assert(SAYS(GIMBAL, ACCEPTED) && SAYS(GIMBAL, DENIED), "gimbal");

/* A verb on its way through the transaction. */
struct request {
	int64_t now_us;
	const struct device_who *who;
	enum security_right right;
	const void *events; /* of the machine that carries it out */
	size_t count;
	uint8_t lamp;
};

static int64_t earlier(int64_t a_us, int64_t b_us)
{
	return (a_us < b_us) ? a_us : b_us;
}

static struct device_lamp *lamp_of(struct pharos_device *self, uint8_t lamp)
{
	PHAROS_ASSERT(lamp < DEVICE_LAMPS_MAX);
	return &self->lamps[DEVICE_LAMPS_MAX > 1 ? lamp : 0];
}

static uint8_t bit_of(uint8_t lamp)
{
	return DEVICE_LAMPS_MAX > 1 ? (uint8_t)(1u << lamp) : 1u;
}

/* --- the machines, and what follows from their steps ------------------------------------------ */

struct device_effects *device_effects_of(struct pharos_device *self)
{
	self->has_effects = true;
	return &self->effects;
}

enum illuminator_result device_step_lamp(struct pharos_device *self, int64_t now_us, uint8_t lamp,
                                         const struct illuminator_event *event)
{
	const uint8_t bit = bit_of(lamp);
	struct device_effects *const effects = &self->effects;
	struct illuminator_outbox out;
	const enum illuminator_result result =
		illuminator_step(&lamp_of(self, lamp)->illuminator, now_us, event, &out);

	effects->lights |= out.light ? bit : 0;
	effects->settings |= out.settings ? bit : 0;
	effects->statuses |= out.status ? bit : 0;
	effects->notices[lamp] |= out.notices;
	self->has_effects = self->has_effects || out.light || out.status || out.notices != 0;
	return result;
}

#ifdef CONFIG_PHAROS_IMC
/* A lamp that loses its power goes out, and stays so when power comes back. */
static void follow_power(struct pharos_device *self, int64_t now_us)
{
	const struct actuators *const outputs = &self->actuators;
	const uint32_t channel = 1u << POWER_CHANNEL_LAMP;
	const bool switched = (outputs->config.power & channel) != 0;
	const struct illuminator_event event = {
		.kind = ILLUMINATOR_EVENT_POWER,
		.powered = switched ? (power_outputs(&outputs->power) & channel) != 0
	                            : actuators_is_up(outputs),
	};

	for (uint8_t lamp = 0; lamp < DEVICE_LAMPS_MAX; lamp++) {
		if (event.powered == self->lamps[lamp].illuminator.unpowered) {
			(void)device_step_lamp(self, now_us, lamp, &event);
		}
	}
}

/* One notice at a time: while another waits to be taken, the deadline stays in the past. */
static void advance_outputs(struct pharos_device *self, int64_t now_us)
{
	struct device_effects *const effects = device_effects_of(self);

	effects->outputs = true;
	if (!effects->has_shutdown) {
		effects->has_shutdown =
			actuators_advance(&self->actuators, now_us, &effects->shutdown);
	}
	follow_power(self, now_us);
}

static void init_outputs(struct pharos_device *self, int64_t now_us,
                         const struct device_config *config)
{
	struct actuators_config outputs = config->actuators;

	outputs.grace_us = (int64_t)self->params.values[PARAM_DOWN_TIME] * US_PER_S;
	outputs.focus_travel_us = (int64_t)self->params.values[PARAM_ZOOM_TIME] * US_PER_MS;
	params_thruster(&self->params, &outputs.thruster_config);
	actuators_init(&self->actuators, now_us, &outputs);
	for (uint8_t channel = 0; channel < POWER_CHANNELS_MAX; channel++) {
		self->scheduled[channel] = SECURITY_WAY_SHELL;
	}
	self->shut_down = SECURITY_WAY_SHELL;
	follow_power(self, now_us);
}
#endif

#ifdef CONFIG_PHAROS_GIMBAL
struct arbiter_config device_gimbal_arbiter_config(const struct params *params)
{
	struct arbiter_config config;

	params_arbiter(params, &config);
	config.loss_us = 0;
	return config;
}

static void init_gimbal(struct pharos_device *self, int64_t now_us, bool has_servos)
{
	const struct arbiter_config arbiter = device_gimbal_arbiter_config(&self->params);
	struct gimbal_config config;

	self->has_gimbal = has_servos && self->params.values[PARAM_GMB_ENABLE] != 0;
	params_gimbal(&self->params, &config);
	gimbal_init(&self->gimbal, now_us, &config);
	arbiter_init(&self->gimbal_arbiter, &arbiter);
}
#endif

void pharos_device_init(struct pharos_device *self, int64_t now_us,
                        const struct device_config *config)
{
	struct illuminator_config illuminator;
	struct arbiter_config arbiter;

	self->security.has_key = false;
	params_security(&self->params, &self->security);
	params_illuminator(&self->params, &illuminator);
	params_arbiter(&self->params, &arbiter);
	for (uint8_t lamp = 0; lamp < DEVICE_LAMPS_MAX; lamp++) {
		illuminator_init(&self->lamps[lamp].illuminator, &illuminator);
		arbiter_init(&self->lamps[lamp].arbiter, &arbiter);
		self_test_init(&self->lamps[lamp].self_test);
	}
#ifdef CONFIG_PHAROS_GIMBAL
	init_gimbal(self, now_us, config->gimbal);
#endif
#ifdef CONFIG_PHAROS_IMC
	init_outputs(self, now_us, config);
#endif
	memset(&self->effects, 0, sizeof(self->effects));
	self->has_effects = false;
}

/* --- the transaction -------------------------------------------------------------------------- */

static void show_commander(struct pharos_device *self)
{
	params_tell(&self->params, PARAM_LGT_SRC_NOW, (int32_t)self->lamps[0].arbiter.commander);
}

static bool is_anothers(const struct arbiter *arbiter, enum arbiter_source source)
{
	const enum arbiter_source commander = arbiter->commander;

	return commander != source && commander != ARBITER_SOURCE_NONE &&
	       commander != ARBITER_SOURCE_FALLBACK;
}

/* May this source do this now? */
static enum device_result check(const struct pharos_device *self, struct arbiter *arbiter,
                                const struct request *request)
{
	const enum arbiter_source source = security_source(request->who->way);

	if (!pharos_device_may(self, request->who, request->right)) {
		return DEVICE_EXCLUDED;
	}
	if (request->who->is_repeated && is_anothers(arbiter, source)) {
		arbiter_heard(arbiter, request->now_us, source);
		return DEVICE_KEPT;
	}
	return arbiter_is_outranked(arbiter, request->now_us, source) ? DEVICE_OUTRANKED
	                                                              : DEVICE_ACCEPTED;
}

/* carry_out decides whole and applies whole; then the source is in command. */
static enum device_result
transact(struct pharos_device *self, struct arbiter *arbiter, const struct request *request,
         enum device_result (*carry_out)(struct pharos_device *self, const struct request *request))
{
	enum device_result result = check(self, arbiter, request);

	if (result != DEVICE_ACCEPTED) {
		return result;
	}
	result = carry_out(self, request);
	if (result == DEVICE_ACCEPTED) {
		arbiter_commit(arbiter, request->now_us, security_source(request->who->way));
		show_commander(self);
	}
	return result;
}

/* --- lamps ------------------------------------------------------------------------------------ */

static enum device_result carry_out_lamp(struct pharos_device *self, const struct request *request)
{
	const struct illuminator_event *const events = request->events;
	enum illuminator_result result = ILLUMINATOR_ACCEPTED;

	for (size_t i = 0; i < request->count; i++) {
		PHAROS_ASSERT(events[i].kind <= ILLUMINATOR_EVENT_TEST); /* a command */
	}
	if (request->count > 1) {
		result = illuminator_try(&self->lamps[request->lamp].illuminator, events,
		                         request->count);
	}
	for (size_t i = 0; i < request->count && result == ILLUMINATOR_ACCEPTED; i++) {
		result = device_step_lamp(self, request->now_us, request->lamp, &events[i]);
	}
	return (enum device_result)result;
}

enum device_result pharos_device_apply(struct pharos_device *self, int64_t now_us,
                                       const struct device_who *who, uint8_t lamp,
                                       const struct illuminator_event *events, size_t count)
{
	const struct request request = {now_us, who, SECURITY_LIGHT, events, count, lamp};

	return transact(self, &lamp_of(self, lamp)->arbiter, &request, carry_out_lamp);
}

enum device_result pharos_device_restore(struct pharos_device *self, int64_t now_us, uint8_t lamp,
                                         const struct illuminator_settings *settings)
{
	struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_RESTORE, .restore = *settings};

	event.restore.strobe_period_us = illuminator_nearest_period_us(
		&lamp_of(self, lamp)->illuminator.config, settings->strobe_period_us);
	return (enum device_result)device_step_lamp(self, now_us, lamp, &event);
}

enum device_result pharos_device_test(struct pharos_device *self, int64_t now_us,
                                      const struct device_who *who, uint8_t lamp, uint32_t peak_ppm,
                                      enum self_test_state *obstacle)
{
	struct device_lamp *const tested = lamp_of(self, lamp);
	const struct illuminator_event first = self_test_first();

	*obstacle = self_test_obstacle(&tested->self_test, &tested->illuminator);
	if (*obstacle != SELF_TEST_NONE) {
		return DEVICE_FAILED;
	}

	const enum device_result result = pharos_device_apply(self, now_us, who, lamp, &first, 1);

	if (result == DEVICE_ACCEPTED) {
		self_test_begin(&tested->self_test, now_us, peak_ppm);
	}
	return result;
}

bool pharos_device_cancel_test(struct pharos_device *self, int64_t now_us,
                               const struct device_who *who, uint8_t lamp)
{
	struct self_test *const test = &lamp_of(self, lamp)->self_test;

	if (test->state != SELF_TEST_RUNNING || !pharos_device_may(self, who, SECURITY_LIGHT)) {
		return false;
	}

	const struct illuminator_event event = self_test_cancel(test);

	(void)device_step_lamp(self, now_us, lamp, &event);
	return true;
}

/* --- gimbal ----------------------------------------------------------------------------------- */

#ifdef CONFIG_PHAROS_GIMBAL

static enum device_result carry_out_gimbal(struct pharos_device *self,
                                           const struct request *request)
{
	const struct gimbal_event *const event = request->events;

	PHAROS_ASSERT(event->kind == GIMBAL_EVENT_AIM || event->kind == GIMBAL_EVENT_NEUTRAL ||
	              event->kind == GIMBAL_EVENT_RETRACT);
	return (enum device_result)gimbal_step(&self->gimbal, request->now_us, event);
}

enum device_result pharos_device_point(struct pharos_device *self, int64_t now_us,
                                       const struct device_who *who,
                                       const struct gimbal_event *event)
{
	const struct request request = {
		.now_us = now_us, .who = who, .right = SECURITY_GIMBAL, .events = event};

	return self->has_gimbal ? transact(self, &self->gimbal_arbiter, &request, carry_out_gimbal)
	                        : DEVICE_ABSENT;
}

enum device_result pharos_device_follow(struct pharos_device *self, int64_t now_us,
                                        const struct device_who *who,
                                        const struct gimbal_event *event)
{
	const struct request request = {.now_us = now_us, .who = who, .events = event};

	if (!self->has_gimbal) {
		return DEVICE_ABSENT;
	}
	return self->gimbal_arbiter.commander == security_source(who->way) &&
	                       pharos_device_may(self, who, SECURITY_GIMBAL)
	               ? carry_out_gimbal(self, &request)
	               : DEVICE_KEPT;
}

int32_t pharos_device_share_mdeg(const struct pharos_device *self, enum gimbal_axis_id axis,
                                 int32_t share_ppm)
{
	PHAROS_ASSERT(self->has_gimbal);
	return gimbal_share_mdeg(&self->gimbal, axis, share_ppm);
}

int32_t pharos_device_share_rate(const struct pharos_device *self, enum gimbal_axis_id axis,
                                 int32_t share_ppm)
{
	PHAROS_ASSERT(self->has_gimbal);
	return gimbal_share_rate(&self->gimbal, axis, share_ppm);
}

void pharos_device_report_attitude(struct pharos_device *self, int64_t now_us,
                                   const struct device_who *who, const struct attitude *attitude)
{
	const struct gimbal_event event = {.kind = GIMBAL_EVENT_ATTITUDE, .attitude = *attitude};

	if (self->has_gimbal && pharos_device_may(self, who, SECURITY_EXIST)) {
		(void)gimbal_step(&self->gimbal, now_us, &event);
	}
}

bool pharos_device_report_servos(struct pharos_device *self, int64_t now_us, bool fault)
{
	const struct gimbal_event event = {.kind = GIMBAL_EVENT_FAULT, .fault = fault};

	PHAROS_ASSERT(self->has_gimbal);
	if (self->gimbal.fault == fault) {
		return false;
	}
	(void)gimbal_step(&self->gimbal, now_us, &event);
	return true;
}

static void step_gimbal(struct pharos_device *self, int64_t now_us)
{
	struct gimbal_outbox out;

	if (!self->has_gimbal) {
		return;
	}
	gimbal_advance(&self->gimbal, now_us, &out);
	if (out.move) {
		device_effects_of(self)->move = true;
	}
}

#endif

/* --- outputs ---------------------------------------------------------------------------------- */

#ifdef CONFIG_PHAROS_IMC

static enum device_result carry_out_outputs(struct pharos_device *self,
                                            const struct request *request)
{
	const enum actuators_result result =
		actuators_step(&self->actuators, request->now_us, request->events);

	if (result == ACTUATORS_ACCEPTED) {
		advance_outputs(self, request->now_us);
	}
	return (enum device_result)result;
}

/* Whose schedules they are, so that they lapse with its right to have them. */
static void note_schedule(struct pharos_device *self, const struct device_who *who,
                          const struct actuators_event *event)
{
	if (event->kind == ACTUATORS_EVENT_POWER &&
	    (event->timed.op == POWER_OP_SCHEDULE_ON || event->timed.op == POWER_OP_SCHEDULE_OFF)) {
		self->scheduled[event->number] = who->way;
	} else if (event->kind == ACTUATORS_EVENT_SHUTDOWN) {
		self->shut_down = who->way;
	}
}

void device_lapse(struct pharos_device *self, int64_t now_us)
{
	const struct device_who down = {.way = self->shut_down};

	for (uint8_t channel = 0; channel < POWER_CHANNELS_MAX; channel++) {
		const struct device_who who = {.way = self->scheduled[channel]};

		if (!pharos_device_may(self, &who, SECURITY_OUTPUTS)) {
			(void)power_command(&self->actuators.power, now_us, channel,
			                    POWER_OP_RESET_SCHEDULES, 0);
		}
	}
	if (!pharos_device_may(self, &down, SECURITY_OUTPUTS)) {
		shutdown_lapse(&self->actuators.shutdown);
	}
	advance_outputs(self, now_us);
}

/* Is it the lamp's too? */
static bool is_lamps(const struct actuators_event *event)
{
	return event->kind == ACTUATORS_EVENT_SHUTDOWN ||
	       (event->kind == ACTUATORS_EVENT_POWER && event->number == POWER_CHANNEL_LAMP);
}

enum device_result pharos_device_output(struct pharos_device *self, int64_t now_us,
                                        const struct device_who *who,
                                        const struct actuators_event *event)
{
	const struct request request = {
		.now_us = now_us, .who = who, .right = SECURITY_OUTPUTS, .events = event};
	enum device_result result = DEVICE_EXCLUDED;

	if (is_lamps(event)) {
		result = transact(self, &self->lamps[0].arbiter, &request, carry_out_outputs);
	} else if (pharos_device_may(self, who, SECURITY_OUTPUTS)) {
		result = carry_out_outputs(self, &request);
	}
	if (result == DEVICE_ACCEPTED) {
		note_schedule(self, who, event);
	}
	return result;
}

#endif

/* --- reports ---------------------------------------------------------------------------------- */

void pharos_device_heard(struct pharos_device *self, int64_t now_us, const struct device_who *who)
{
	if (!pharos_device_may(self, who, SECURITY_EXIST)) {
		return;
	}
	for (uint8_t lamp = 0; lamp < DEVICE_LAMPS_MAX; lamp++) {
		arbiter_heard(&self->lamps[lamp].arbiter, now_us, security_source(who->way));
	}
}

void pharos_device_report_heat(struct pharos_device *self, int64_t now_us, uint8_t lamp,
                               const struct thermal_report *report)
{
	const struct illuminator_event event = {.kind = ILLUMINATOR_EVENT_THERMAL,
	                                        .thermal = *report};

	(void)device_step_lamp(self, now_us, lamp, &event);
	device_effects_of(self)->reports |= bit_of(lamp);
}

void pharos_device_report_driver(struct pharos_device *self, uint8_t lamp, bool fault)
{
	self_test_driver(&lamp_of(self, lamp)->self_test, fault);
}

/* --- time and effects ------------------------------------------------------------------------- */

/* Every commander is silent. */
static void step_arbiter(struct pharos_device *self, int64_t now_us, uint8_t lamp)
{
	struct arbiter *const arbiter = &self->lamps[lamp].arbiter;

	if (arbiter_advance(arbiter, now_us)) {
		const struct illuminator_event event = {
			.kind = ILLUMINATOR_EVENT_FALLBACK,
			.fallback = arbiter->config.fallback,
		};

		(void)device_step_lamp(self, now_us, lamp, &event);
		show_commander(self);
	}
}

/* The sweep of a self-test, and what it finds. */
static void step_self_test(struct pharos_device *self, int64_t now_us, uint8_t lamp)
{
	struct device_lamp *const tested = &self->lamps[lamp];
	struct illuminator_event event;

	while (self_test_step(&tested->self_test, now_us, &tested->illuminator, &event)) {
		(void)device_step_lamp(self, now_us, lamp, &event);
	}
}

void pharos_device_step(struct pharos_device *self, int64_t now_us)
{
	for (uint8_t lamp = 0; lamp < DEVICE_LAMPS_MAX; lamp++) {
		step_arbiter(self, now_us, lamp);
		step_self_test(self, now_us, lamp);
	}
#ifdef CONFIG_PHAROS_GIMBAL
	step_gimbal(self, now_us);
#endif
#ifdef CONFIG_PHAROS_IMC
	if (actuators_deadline_us(&self->actuators) <= now_us) {
		advance_outputs(self, now_us);
	}
#endif
}

int64_t pharos_device_deadline_us(const struct pharos_device *self)
{
	int64_t deadline_us = TIME_NEVER_US;

	for (uint8_t lamp = 0; lamp < DEVICE_LAMPS_MAX; lamp++) {
		const struct device_lamp *const its = &self->lamps[lamp];

		deadline_us = earlier(deadline_us, arbiter_deadline_us(&its->arbiter));
		deadline_us = earlier(deadline_us, self_test_deadline_us(&its->self_test));
	}
#ifdef CONFIG_PHAROS_GIMBAL
	if (self->has_gimbal) {
		deadline_us = earlier(deadline_us, gimbal_deadline_us(&self->gimbal));
	}
#endif
#ifdef CONFIG_PHAROS_IMC
	deadline_us = earlier(deadline_us, actuators_deadline_us(&self->actuators));
#endif
	return deadline_us;
}

bool pharos_device_take(struct pharos_device *self, struct device_effects *effects)
{
	if (!self->has_effects) {
		return false;
	}
	*effects = self->effects;
	memset(&self->effects, 0, sizeof(self->effects));
	self->has_effects = false;
	return true;
}
