/* SPDX-License-Identifier: Apache-2.0 */
#include "core/illuminator.h"

#include "core/assert.h"

#include <stddef.h>

/* CIE 1931 lightness: L* = 100 is PPM_ONE here. Straight below L* = 8, cubic above. */
#define CURVE_STRAIGHT_PPM 80000u
#define CURVE_SHIFT        160000u  /* L* + 16 */
#define CURVE_SPAN         1160000u /* 116 */
/* kappa is (29/3)^3 = 24389/27, so that Y = L* / kappa, and in ppm 100 times as much. */
#define CURVE_KAPPA_NUM    24389u
#define CURVE_KAPPA_DEN    2700u
/* CURVE_SPAN cubed, over PPM_ONE. */
#define CURVE_CUBE         UINT64_C(1560896000000)

_Static_assert((uint64_t)CURVE_SPAN *CURVE_SPAN *(CURVE_SPAN / PPM_ONE * PPM_ONE) <
                       (uint64_t)INT64_MAX,
               "the cube fits");
_Static_assert(CURVE_SHIFT + PPM_ONE == CURVE_SPAN, "full brightness is full light");

uint32_t illuminator_curve_ppm(enum illuminator_curve curve, uint32_t brightness_ppm)
{
	PHAROS_ASSERT(brightness_ppm <= PPM_ONE);
	if (curve == ILLUMINATOR_CURVE_LINEAR) {
		return brightness_ppm;
	}
	if (brightness_ppm <= CURVE_STRAIGHT_PPM) {
		return (brightness_ppm * CURVE_KAPPA_DEN + CURVE_KAPPA_NUM / 2) / CURVE_KAPPA_NUM;
	}
	const uint64_t root = brightness_ppm + CURVE_SHIFT;

	return (uint32_t)((root * root * root + CURVE_CUBE / 2) / CURVE_CUBE);
}

uint32_t illuminator_on_us(uint32_t period_us, uint32_t duty_ppm)
{
	PHAROS_ASSERT(period_us <= STROBE_PERIOD_CEILING_US && duty_ppm <= PPM_ONE);
	const uint64_t on_us = ((uint64_t)period_us * duty_ppm + PPM_ONE / 2) / PPM_ONE;

	return (on_us == 0 && duty_ppm > 0 && period_us > 0) ? 1u : (uint32_t)on_us;
}

uint32_t illuminator_nearest_period_us(const struct illuminator_config *config, uint32_t period_us)
{
	if (period_us == 0) {
		return 0;
	}
	if (period_us < config->min_period_us) {
		return config->min_period_us;
	}
	return (period_us > config->max_period_us) ? config->max_period_us : period_us;
}

static void assert_config(const struct illuminator_config *config)
{
	PHAROS_ASSERT(config->min_period_us >= STROBE_PERIOD_FLOOR_US);
	PHAROS_ASSERT(config->max_period_us >= config->min_period_us);
	PHAROS_ASSERT(config->max_period_us <= STROBE_PERIOD_CEILING_US);
	PHAROS_ASSERT(config->beacon.duty_ppm <= PPM_ONE);
	PHAROS_ASSERT(config->beacon.brightness_ppm <= PPM_ONE);
	PHAROS_ASSERT(program_valid(&config->program));
}

void illuminator_init(struct illuminator *self, const struct illuminator_config *config)
{
	assert_config(config);
	*self = (struct illuminator){
		.settings = {.mode = ILLUMINATOR_MODE_INTERNAL,
	                     .brightness_ppm = PPM_ONE,
	                     .duty_ppm = PPM_ONE},
		.config = *config,
		.thermal = {.sensor = THERMAL_SENSOR_WAITING},
	};
}

static bool values_valid(const struct illuminator_config *config,
                         const struct illuminator_configure *values)
{
	const bool mode =
		values->mode == ILLUMINATOR_MODE_INTERNAL || values->mode == ILLUMINATOR_MODE_SYNC;
	const bool period = values->strobe_period_us == 0 ||
	                    (values->strobe_period_us >= config->min_period_us &&
	                     values->strobe_period_us <= config->max_period_us);

	return mode && period && values->brightness_ppm <= PPM_ONE && values->duty_ppm <= PPM_ONE;
}

static struct illuminator_settings with_values(struct illuminator_settings settings,
                                               const struct illuminator_configure *values)
{
	settings.mode = (enum illuminator_mode)values->mode;
	settings.brightness_ppm = values->brightness_ppm;
	settings.strobe_period_us = values->strobe_period_us;
	settings.duty_ppm = values->duty_ppm;
	return settings;
}

static enum illuminator_result decide_values(const struct illuminator *self,
                                             const struct illuminator_configure *values,
                                             struct illuminator_settings *next)
{
	if (!values_valid(&self->config, values)) {
		return ILLUMINATOR_DENIED;
	}
	*next = with_values(*next, values);
	return ILLUMINATOR_ACCEPTED;
}

static enum illuminator_result decide_enable(const struct illuminator *self, bool enable,
                                             struct illuminator_settings *next)
{
	if (enable && (self->unpowered || !thermal_allows_light(&self->thermal))) {
		return ILLUMINATOR_FAILED;
	}
	next->enable = enable;
	return ILLUMINATOR_ACCEPTED;
}

static enum illuminator_result decide_test(const struct illuminator *self,
                                           const struct illuminator_test *test)
{
	struct illuminator_settings unchanged;

	if (test->brightness_ppm > PPM_ONE) {
		return ILLUMINATOR_DENIED;
	}
	return decide_enable(self, test->on, &unchanged);
}

static enum illuminator_result decide_restore(const struct illuminator *self,
                                              const struct illuminator_settings *saved,
                                              struct illuminator_settings *next)
{
	const struct illuminator_configure values = {
		.mode = (uint32_t)saved->mode,
		.brightness_ppm = saved->brightness_ppm,
		.strobe_period_us = saved->strobe_period_us,
		.duty_ppm = saved->duty_ppm,
	};
	const enum illuminator_result result = decide_values(self, &values, next);

	return (result == ILLUMINATOR_ACCEPTED) ? decide_enable(self, saved->enable, next) : result;
}

static struct illuminator_settings after_fallback(const struct illuminator *self,
                                                  const struct illuminator_settings *now,
                                                  enum illuminator_fallback fallback)
{
	const struct illuminator_beacon *const beacon = &self->config.beacon;
	struct illuminator_settings next = *now;

	switch (fallback) {
	case ILLUMINATOR_FALLBACK_KEEP:
		break;
	case ILLUMINATOR_FALLBACK_OFF:
		next.enable = false;
		break;
	case ILLUMINATOR_FALLBACK_BEACON:
		next = (struct illuminator_settings){
			.enable = !self->unpowered,
			.mode = ILLUMINATOR_MODE_INTERNAL,
			.brightness_ppm = beacon->brightness_ppm,
			.strobe_period_us =
				illuminator_nearest_period_us(&self->config, beacon->period_us),
			.duty_ppm = beacon->duty_ppm,
		};
		break;
	}
	return next;
}

/* What an event makes of the settings in *next; looked at only when ACCEPTED. */
static enum illuminator_result decide(const struct illuminator *self,
                                      const struct illuminator_event *event,
                                      struct illuminator_settings *next)
{
	switch (event->kind) {
	case ILLUMINATOR_EVENT_ON_OFF:
		return decide_enable(self, event->on_off, next);
	case ILLUMINATOR_EVENT_CONFIGURE:
		return decide_values(self, &event->configure, next);
	case ILLUMINATOR_EVENT_BRIGHTNESS:
		next->brightness_ppm = event->brightness_ppm;
		return (event->brightness_ppm <= PPM_ONE) ? ILLUMINATOR_ACCEPTED
		                                          : ILLUMINATOR_DENIED;
	case ILLUMINATOR_EVENT_RESTORE:
		return decide_restore(self, &event->restore, next);
	case ILLUMINATOR_EVENT_FALLBACK:
		*next = after_fallback(self, next, event->fallback);
		return ILLUMINATOR_ACCEPTED;
	case ILLUMINATOR_EVENT_POWER:
		next->enable = next->enable && event->powered;
		return ILLUMINATOR_ACCEPTED;
	case ILLUMINATOR_EVENT_TEST:
		return decide_test(self, &event->test);
	case ILLUMINATOR_EVENT_THERMAL:
	case ILLUMINATOR_EVENT_CONFIG:
		return ILLUMINATOR_ACCEPTED;
	}
	PHAROS_ASSERT(false);
	return ILLUMINATOR_DENIED;
}

static struct light_plan plan_of(const struct illuminator_settings *settings,
                                 const struct illuminator_config *config)
{
	struct light_plan plan = {.on = settings->enable};

	if (!settings->enable) {
		return plan;
	}
	plan.external_sync = settings->mode == ILLUMINATOR_MODE_SYNC;
	plan.level_ppm = illuminator_curve_ppm(config->curve, settings->brightness_ppm);
	const uint32_t on_us = illuminator_on_us(settings->strobe_period_us, settings->duty_ppm);

	if (on_us > 0 && on_us < settings->strobe_period_us) {
		plan.period_us = settings->strobe_period_us;
		plan.on_us = on_us;
	}
	if (!plan.external_sync && settings->strobe_period_us == 0) {
		plan.program = config->program;
	}
	return plan;
}

/* What the lamp shows while it is tested, after this event. */
static struct illuminator_test test_after(const struct illuminator *self,
                                          const struct illuminator_event *event)
{
	const struct illuminator_test none = {.on = false};

	switch (event->kind) {
	case ILLUMINATOR_EVENT_TEST:
		return event->test;
	case ILLUMINATOR_EVENT_THERMAL:
		return event->thermal.state == THERMAL_STATE_SHUTDOWN ? none : self->test;
	case ILLUMINATOR_EVENT_POWER:
		return event->powered ? self->test : none;
	case ILLUMINATOR_EVENT_CONFIG:
		return self->test;
	case ILLUMINATOR_EVENT_ON_OFF:
	case ILLUMINATOR_EVENT_CONFIGURE:
	case ILLUMINATOR_EVENT_BRIGHTNESS:
	case ILLUMINATOR_EVENT_RESTORE:
	case ILLUMINATOR_EVENT_FALLBACK:
		return none;
	}
	PHAROS_ASSERT(false);
	return none;
}

static struct light_plan test_plan(const struct illuminator_test *test,
                                   enum illuminator_curve curve)
{
	return (struct light_plan){
		.on = true,
		.level_ppm = illuminator_curve_ppm(curve, test->brightness_ppm),
	};
}

static bool settings_equal(const struct illuminator_settings *a,
                           const struct illuminator_settings *b)
{
	return a->enable == b->enable && a->mode == b->mode &&
	       a->brightness_ppm == b->brightness_ppm &&
	       a->strobe_period_us == b->strobe_period_us && a->duty_ppm == b->duty_ppm;
}

static bool plan_equal(const struct light_plan *a, const struct light_plan *b)
{
	return a->on == b->on && a->external_sync == b->external_sync &&
	       a->level_ppm == b->level_ppm && a->period_us == b->period_us &&
	       a->on_us == b->on_us && program_equal(&a->program, &b->program);
}

static bool config_equal(const struct illuminator_config *a, const struct illuminator_config *b)
{
	return a->min_period_us == b->min_period_us && a->max_period_us == b->max_period_us &&
	       a->curve == b->curve;
}

static uint8_t notice_bit(enum illuminator_notice_kind kind)
{
	return (uint8_t)(1u << kind);
}

static uint8_t heat_notice(enum thermal_state before, enum thermal_state now)
{
	if (now == before) {
		return 0;
	}
	switch (now) {
	case THERMAL_STATE_SHUTDOWN:
		return notice_bit(ILLUMINATOR_NOTICE_SHUTDOWN);
	case THERMAL_STATE_THROTTLING:
		return notice_bit(ILLUMINATOR_NOTICE_THROTTLING_BEGINS);
	case THERMAL_STATE_NORMAL:
		break;
	}
	return notice_bit(before == THERMAL_STATE_SHUTDOWN ? ILLUMINATOR_NOTICE_RECOVERED
	                                                   : ILLUMINATOR_NOTICE_THROTTLING_ENDS);
}

static uint8_t sensor_notice(const struct thermal_report *before, const struct thermal_report *now)
{
	const bool failed = now->sensor == THERMAL_SENSOR_FAILED;
	const bool had_failed = before->sensor == THERMAL_SENSOR_FAILED;

	if (failed && (!had_failed || now->fault != before->fault)) {
		return notice_bit(ILLUMINATOR_NOTICE_SENSOR_FAILED);
	}
	return had_failed && now->sensor == THERMAL_SENSOR_OK
	               ? notice_bit(ILLUMINATOR_NOTICE_SENSOR_OK)
	               : 0;
}

static void take_report(struct illuminator *self, const struct thermal_report *report,
                        struct illuminator_outbox *out)
{
	out->status = report->flags != self->thermal.flags;
	out->notices = heat_notice(self->thermal.state, report->state) |
	               sensor_notice(&self->thermal, report);
	self->thermal = *report;
}

/* The event is accepted: all changes, and what they call for. */
static void apply(struct illuminator *self, int64_t now_us, const struct illuminator_event *event,
                  const struct illuminator_settings *next, struct illuminator_outbox *out)
{
	const struct light_plan before = self->plan;

	if (event->kind == ILLUMINATOR_EVENT_CONFIG) {
		assert_config(&event->config);
		out->status = !config_equal(&self->config, &event->config);
		self->config = event->config;
	} else if (event->kind == ILLUMINATOR_EVENT_THERMAL) {
		take_report(self, &event->thermal, out);
	} else if (event->kind == ILLUMINATOR_EVENT_POWER) {
		self->unpowered = !event->powered;
	}
	if (!settings_equal(&self->settings, next)) {
		self->settings = *next;
		self->revision++;
		self->changed_us = now_us;
		out->settings = true;
		out->status = true;
	}
	self->test = test_after(self, event);
	self->plan = self->test.on ? test_plan(&self->test, self->config.curve)
	                           : plan_of(&self->settings, &self->config);
	out->light = !plan_equal(&before, &self->plan);
}

enum illuminator_result illuminator_step(struct illuminator *self, int64_t now_us,
                                         const struct illuminator_event *event,
                                         struct illuminator_outbox *out)
{
	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	struct illuminator_settings next = self->settings;
	const enum illuminator_result result = decide(self, event, &next);

	*out = (struct illuminator_outbox){.light = false};
	switch (result) {
	case ILLUMINATOR_ACCEPTED:
		self->stats.accepted++;
		apply(self, now_us, event, &next, out);
		break;
	case ILLUMINATOR_DENIED:
		self->stats.denied++;
		break;
	case ILLUMINATOR_FAILED:
		self->stats.failed++;
		break;
	}
	return result;
}

enum illuminator_result illuminator_try(const struct illuminator *self,
                                        const struct illuminator_event *events, size_t count)
{
	enum illuminator_result result = ILLUMINATOR_ACCEPTED;
	struct illuminator_settings next = self->settings;

	for (size_t i = 0; i < count && result == ILLUMINATOR_ACCEPTED; i++) {
		result = decide(self, &events[i], &next);
	}
	return result;
}

uint32_t illuminator_error_flags(const struct illuminator *self)
{
	return self->thermal.flags;
}

const char *illuminator_notice_text(enum illuminator_notice_kind kind)
{
	switch (kind) {
	case ILLUMINATOR_NOTICE_THROTTLING_BEGINS:
		return "Thermal throttling begins";
	case ILLUMINATOR_NOTICE_THROTTLING_ENDS:
		return "Thermal throttling ends";
	case ILLUMINATOR_NOTICE_SHUTDOWN:
		return "Over-temperature shutdown";
	case ILLUMINATOR_NOTICE_RECOVERED:
		return "Recovered from over-temperature";
	case ILLUMINATOR_NOTICE_SENSOR_FAILED:
		return "Temperature sensor failed";
	case ILLUMINATOR_NOTICE_SENSOR_OK:
		return "Temperature sensor ok again";
	}
	PHAROS_ASSERT(false);
	return "";
}
