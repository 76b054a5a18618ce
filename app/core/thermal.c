/* SPDX-License-Identifier: Apache-2.0 */
#include "core/thermal.h"

#include "core/assert.h"
#include "core/limits.h"

/* Longer gaps count as this long: keeps rate and slew within 64 bits, and is hours of slack. */
#define GAP_MAX_US ((int64_t)1000 * US_PER_S)

/* Noise averages out in so long, and a lamp that warms up is seen. */
#define LAG_US 2000000

_Static_assert((uint64_t)GAP_MAX_US * 4000000000u < (uint64_t)INT64_MAX, "a rate times a gap fits");

static void assert_config(const struct thermal_config *c)
{
	PHAROS_ASSERT(c->min_mdegc >= TEMP_FLOOR_MDEGC && c->max_mdegc <= TEMP_CEILING_MDEGC);
	PHAROS_ASSERT(c->min_mdegc < c->max_mdegc);
	PHAROS_ASSERT(c->recover_mdegc < c->throttle_mdegc);
	PHAROS_ASSERT(c->throttle_mdegc < c->shutdown_mdegc);
	PHAROS_ASSERT(c->shutdown_mdegc <= TEMP_CEILING_MDEGC);
	PHAROS_ASSERT(c->recover_mdegc >= TEMP_FLOOR_MDEGC);
	PHAROS_ASSERT(c->hysteresis_mdegc >= 0 && c->hysteresis_mdegc <= TEMP_CEILING_MDEGC);
	PHAROS_ASSERT(c->noise_mdegc >= 0 && c->noise_mdegc <= TEMP_CEILING_MDEGC);
	PHAROS_ASSERT(c->floor_ppm <= PPM_ONE && c->safe_ppm <= PPM_ONE && c->hot_ppm <= PPM_ONE);
	PHAROS_ASSERT(c->max_rate_mdegc_per_s > 0 && c->max_rate_mdegc_per_s <= 4000000000u);
	PHAROS_ASSERT(c->slew_ppm_per_s > 0 && c->slew_ppm_per_s <= 4000000000u);
	PHAROS_ASSERT(c->stuck_us > 0 && c->missing_us > 0 && c->good_samples > 0);
}

void thermal_init(struct thermal *self, int64_t now_us, const struct thermal_config *config)
{
	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	assert_config(config);
	*self = (struct thermal){
		.config = *config,
		.report = {.sensor = THERMAL_SENSOR_WAITING},
		.start_us = now_us,
		.sample_us = now_us,
		.slewed_us = now_us,
		.now_us = now_us,
	};
}

void thermal_configure(struct thermal *self, const struct thermal_config *config)
{
	assert_config(config);
	self->config = *config;
}

static int64_t bounded_gap(int64_t from_us, int64_t to_us)
{
	const int64_t gap_us = to_us - from_us;

	return (gap_us > GAP_MAX_US) ? GAP_MAX_US : gap_us;
}

static bool too_fast(const struct thermal *self, int64_t now_us, int32_t temp_mdegc)
{
	const int64_t gap_us = bounded_gap(self->plausible_us, now_us);
	const int64_t allowed_mdegc =
		self->config.noise_mdegc +
		(int64_t)self->config.max_rate_mdegc_per_s * gap_us / US_PER_S;
	const int64_t change_mdegc = (int64_t)temp_mdegc - self->previous_mdegc;

	return change_mdegc > allowed_mdegc || -change_mdegc > allowed_mdegc;
}

static bool in_range(const struct thermal *self, int32_t temp_mdegc)
{
	return temp_mdegc >= self->config.min_mdegc && temp_mdegc <= self->config.max_mdegc;
}

/* What is wrong with a sample, if anything. */
static enum thermal_fault judge(const struct thermal *self, int64_t now_us,
                                const struct thermal_sample *sample)
{
	switch (sample->status) {
	case THERMAL_SAMPLE_OPEN:
		return THERMAL_FAULT_OPEN;
	case THERMAL_SAMPLE_SHORT:
		return THERMAL_FAULT_SHORT;
	case THERMAL_SAMPLE_OK:
		break;
	}
	if (!in_range(self, sample->temp_mdegc)) {
		return THERMAL_FAULT_RANGE;
	}
	if (!self->has_previous) {
		return THERMAL_FAULT_NONE;
	}
	if (too_fast(self, now_us, sample->temp_mdegc)) {
		return THERMAL_FAULT_RATE;
	}
	if (sample->raw == self->previous_raw &&
	    (self->stuck ||
	     (sample->lit && now_us - self->unchanged_us >= self->config.stuck_us))) {
		return THERMAL_FAULT_STUCK;
	}
	return THERMAL_FAULT_NONE;
}

/* What later samples are compared with. */
static void remember(struct thermal *self, int64_t now_us, const struct thermal_sample *sample,
                     enum thermal_fault fault)
{
	self->sample_us = now_us;
	if (sample->status != THERMAL_SAMPLE_OK || !in_range(self, sample->temp_mdegc)) {
		self->unchanged_us = now_us;
		return;
	}
	const bool changed = !self->has_previous || sample->raw != self->previous_raw;

	if (changed || !sample->lit) {
		self->unchanged_us = now_us;
	}
	self->stuck = fault == THERMAL_FAULT_STUCK || (self->stuck && !changed);
	self->has_previous = true;
	self->previous_mdegc = sample->temp_mdegc;
	self->previous_raw = sample->raw;
	self->plausible_us = now_us;
}

static void follow_trend(struct thermal *self, int64_t now_us, int32_t temp_mdegc)
{
	const int64_t gap_us = bounded_gap(self->followed_us, now_us);
	const int64_t change_mdegc = (int64_t)temp_mdegc - self->slow_mdegc;

	self->slow_mdegc += (int32_t)(change_mdegc * gap_us / (gap_us + LAG_US));
	self->followed_us = now_us;
}

/* The last good samples were on the way to a shutdown. */
static bool was_heating(const struct thermal *self)
{
	const int64_t trend_mdegc = (int64_t)self->report.temp_mdegc - self->slow_mdegc;

	return self->report.temp_valid &&
	       self->report.temp_mdegc + trend_mdegc * (THERMAL_TREND_US / LAG_US) >=
	               self->config.shutdown_mdegc;
}

/* A bad sample that is heat by itself. */
static bool reads_hot(const struct thermal *self, enum thermal_fault fault,
                      const struct thermal_sample *sample)
{
	switch (fault) {
	case THERMAL_FAULT_SHORT:
		return true;
	case THERMAL_FAULT_RANGE:
		return sample->temp_mdegc > self->config.max_mdegc;
	case THERMAL_FAULT_RATE:
		return sample->temp_mdegc >= self->config.shutdown_mdegc;
	case THERMAL_FAULT_NONE:
	case THERMAL_FAULT_OPEN:
	case THERMAL_FAULT_STUCK:
	case THERMAL_FAULT_MISSING:
		return false;
	}
	PHAROS_ASSERT(false);
	return true;
}

/* The heat machine, for a temperature that can be believed. */
static enum thermal_state heat_next(const struct thermal_config *config, enum thermal_state state,
                                    int32_t temp_mdegc)
{
	if (temp_mdegc >= config->shutdown_mdegc) {
		return THERMAL_STATE_SHUTDOWN;
	}
	switch (state) {
	case THERMAL_STATE_NORMAL:
		return (temp_mdegc >= config->throttle_mdegc) ? THERMAL_STATE_THROTTLING
		                                              : THERMAL_STATE_NORMAL;
	case THERMAL_STATE_THROTTLING:
		return (temp_mdegc < config->throttle_mdegc - config->hysteresis_mdegc)
		               ? THERMAL_STATE_NORMAL
		               : THERMAL_STATE_THROTTLING;
	case THERMAL_STATE_SHUTDOWN:
		return (temp_mdegc < config->recover_mdegc) ? THERMAL_STATE_NORMAL
		                                            : THERMAL_STATE_SHUTDOWN;
	}
	PHAROS_ASSERT(false);
	return THERMAL_STATE_SHUTDOWN;
}

/* The sensor machine. fault: of this sample; good_in_a_row: with this sample. */
static enum thermal_sensor sensor_next(const struct thermal_config *config,
                                       enum thermal_sensor sensor, enum thermal_fault fault,
                                       uint32_t good_in_a_row)
{
	if (fault != THERMAL_FAULT_NONE) {
		return THERMAL_SENSOR_FAILED;
	}
	switch (sensor) {
	case THERMAL_SENSOR_WAITING:
	case THERMAL_SENSOR_OK:
		return THERMAL_SENSOR_OK;
	case THERMAL_SENSOR_FAILED:
		return (good_in_a_row >= config->good_samples) ? THERMAL_SENSOR_OK
		                                               : THERMAL_SENSOR_FAILED;
	}
	PHAROS_ASSERT(false);
	return THERMAL_SENSOR_FAILED;
}

static uint32_t derated_ppm(const struct thermal_config *config, enum thermal_state state,
                            int32_t temp_mdegc)
{
	if (state == THERMAL_STATE_SHUTDOWN) {
		return 0;
	}
	if (temp_mdegc <= config->throttle_mdegc) {
		return PPM_ONE;
	}
	const int64_t span = config->shutdown_mdegc - config->throttle_mdegc;
	const int64_t above = temp_mdegc - config->throttle_mdegc;
	const int64_t depth = PPM_ONE - config->floor_ppm;

	return PPM_ONE - (uint32_t)((depth * above + span - 1) / span);
}

static void fall_to(struct thermal *self, int64_t now_us, uint32_t target_ppm)
{
	if (target_ppm < self->report.limit_ppm) {
		self->report.limit_ppm = target_ppm;
	}
	self->slewed_us = now_us;
	self->rise_carry = 0;
}

static void rise_to(struct thermal *self, int64_t now_us, uint32_t target_ppm)
{
	const int64_t gap_us = bounded_gap(self->slewed_us, now_us);
	const uint64_t credit =
		(uint64_t)self->config.slew_ppm_per_s * (uint64_t)gap_us + self->rise_carry;
	const uint64_t rise_ppm = credit / US_PER_S;

	if (rise_ppm >= target_ppm - self->report.limit_ppm) {
		self->report.limit_ppm = target_ppm;
		self->rise_carry = 0;
	} else {
		self->report.limit_ppm += (uint32_t)rise_ppm;
		self->rise_carry = (uint32_t)(credit % US_PER_S);
	}
	self->slewed_us = now_us;
}

static uint32_t flags_of(enum thermal_state state, enum thermal_sensor sensor)
{
	uint32_t flags = (sensor == THERMAL_SENSOR_FAILED) ? THERMAL_FLAG_THERMISTOR : 0;

	switch (state) {
	case THERMAL_STATE_NORMAL:
		break;
	case THERMAL_STATE_THROTTLING:
		flags |= THERMAL_FLAG_THROTTLING;
		break;
	case THERMAL_STATE_SHUTDOWN:
		flags |= THERMAL_FLAG_SHUTDOWN;
		break;
	}
	return flags;
}

static void enter(struct thermal *self, enum thermal_state state, enum thermal_sensor sensor,
                  enum thermal_fault fault)
{
	struct thermal_report *report = &self->report;

	if (sensor == THERMAL_SENSOR_FAILED && report->sensor != THERMAL_SENSOR_FAILED) {
		self->stats.sensor_failures++;
	}
	if (state == THERMAL_STATE_SHUTDOWN && report->state != THERMAL_STATE_SHUTDOWN) {
		self->stats.shutdowns++;
	}
	/* While good samples heal a failed sensor, the fault is the one that they heal. */
	if (fault != THERMAL_FAULT_NONE || sensor != THERMAL_SENSOR_FAILED) {
		report->fault = fault;
	}
	report->state = state;
	report->sensor = sensor;
	report->flags = flags_of(state, sensor);
	report->temp_valid = sensor == THERMAL_SENSOR_OK;
	report->temp_mdegc = report->temp_valid ? self->previous_mdegc : 0;
}

/* What a failed sensor allows at most. */
static uint32_t failed_ppm(const struct thermal *self, int64_t now_us)
{
	const struct thermal_config *const config = &self->config;
	const bool late = config->first_us > 0 && now_us - self->start_us >= config->first_us;

	if (self->report.state == THERMAL_STATE_SHUTDOWN || (!self->has_previous && !late)) {
		return 0;
	}
	return (self->hot && config->hot_ppm < config->safe_ppm) ? config->hot_ppm
	                                                         : config->safe_ppm;
}

static void fail(struct thermal *self, int64_t now_us, enum thermal_fault fault, bool hot)
{
	self->good_in_a_row = 0;
	self->hot = self->hot || hot || was_heating(self);
	enter(self,
	      (self->hot && self->config.hot_ppm == 0) ? THERMAL_STATE_SHUTDOWN
	                                               : self->report.state,
	      THERMAL_SENSOR_FAILED, fault);
	if (!self->has_previous) {
		self->report.limit_ppm = failed_ppm(self, now_us);
	}
	fall_to(self, now_us, failed_ppm(self, now_us));
}

static void take_good(struct thermal *self, int64_t now_us, int32_t temp_mdegc)
{
	const enum thermal_sensor before = self->report.sensor;

	self->good_in_a_row += (self->good_in_a_row < self->config.good_samples) ? 1u : 0u;
	const enum thermal_sensor sensor =
		sensor_next(&self->config, before, THERMAL_FAULT_NONE, self->good_in_a_row);
	enum thermal_state state = heat_next(&self->config, self->report.state, temp_mdegc);

	if (sensor == THERMAL_SENSOR_FAILED) {
		/* Not believed yet: it may make things darker, never brighter. */
		state = (state > self->report.state) ? state : self->report.state;
		enter(self, state, sensor, THERMAL_FAULT_NONE);
		const uint32_t allowed_ppm = failed_ppm(self, now_us);
		const uint32_t target_ppm = derated_ppm(&self->config, state, temp_mdegc);

		fall_to(self, now_us, (target_ppm < allowed_ppm) ? target_ppm : allowed_ppm);
		return;
	}
	const uint32_t target_ppm = derated_ppm(&self->config, state, temp_mdegc);

	enter(self, state, sensor, THERMAL_FAULT_NONE);
	self->hot = false;
	if (before == THERMAL_SENSOR_OK) {
		follow_trend(self, now_us, temp_mdegc);
	} else {
		self->slow_mdegc = temp_mdegc;
		self->followed_us = now_us;
	}
	if (before == THERMAL_SENSOR_WAITING) {
		self->report.limit_ppm = target_ppm;
		self->slewed_us = now_us;
	} else if (target_ppm > self->report.limit_ppm) {
		rise_to(self, now_us, target_ppm);
	} else {
		fall_to(self, now_us, target_ppm);
	}
}

static bool is_missing(const struct thermal *self, int64_t now_us)
{
	return now_us - self->sample_us > self->config.missing_us;
}

static void take(struct thermal *self, int64_t now_us, const struct thermal_sample *sample)
{
	const enum thermal_fault fault = judge(self, now_us, sample);

	self->stats.samples++;
	remember(self, now_us, sample, fault);
	if (fault == THERMAL_FAULT_NONE) {
		take_good(self, now_us, sample->temp_mdegc);
	} else {
		self->stats.bad_samples++;
		fail(self, now_us, fault, reads_hot(self, fault, sample));
	}
}

struct thermal_report thermal_step(struct thermal *self, int64_t now_us,
                                   const struct thermal_sample *sample)
{
	struct thermal_report *const report = &self->report;

	PHAROS_ASSERT(now_us >= self->now_us && now_us <= TIME_MAX_US);
	self->now_us = now_us;
	if (is_missing(self, now_us)) {
		fail(self, now_us, THERMAL_FAULT_MISSING, false);
	}
	if (sample != NULL) {
		take(self, now_us, sample);
	}
	report->dark = report->sensor == THERMAL_SENSOR_FAILED && report->limit_ppm == 0;
	return *report;
}

const char *thermal_fault_name(enum thermal_fault fault)
{
	switch (fault) {
	case THERMAL_FAULT_NONE:
		return "none";
	case THERMAL_FAULT_OPEN:
		return "open";
	case THERMAL_FAULT_SHORT:
		return "short";
	case THERMAL_FAULT_RANGE:
		return "out of range";
	case THERMAL_FAULT_RATE:
		return "implausible change";
	case THERMAL_FAULT_STUCK:
		return "stuck";
	case THERMAL_FAULT_MISSING:
		return "no samples";
	}
	PHAROS_ASSERT(false);
	return "";
}

const char *thermal_state_name(enum thermal_state state)
{
	switch (state) {
	case THERMAL_STATE_NORMAL:
		return "normal";
	case THERMAL_STATE_THROTTLING:
		return "throttling";
	case THERMAL_STATE_SHUTDOWN:
		return "shutdown";
	}
	PHAROS_ASSERT(false);
	return "";
}
