/* SPDX-License-Identifier: Apache-2.0 */
#include "core/gimbal.h"

#include "core/assert.h"

#define NDEG_PER_MDEG INT64_C(1000000)
#define FULL_NDEG     (ANGLE_FULL_MDEG * NDEG_PER_MDEG)
#define NS_PER_US     1000
#define NEVER_YET     (-1)

/* --- small conversions ------------------------------------------------------------------------ */

static int64_t ndeg(int32_t mdeg)
{
	return mdeg * NDEG_PER_MDEG;
}

/* To the nearest. */
static int32_t mdeg(int64_t ndeg)
{
	const int64_t half = NDEG_PER_MDEG / 2;

	return (int32_t)((ndeg + (ndeg < 0 ? -half : half)) / NDEG_PER_MDEG);
}

static int64_t clamp(int64_t value, int64_t low, int64_t high)
{
	if (value < low) {
		return low;
	}
	return value > high ? high : value;
}

/* Within half a turn. */
static int64_t wrap_ndeg(int64_t value)
{
	const int64_t rest = value % FULL_NDEG;

	if (rest > FULL_NDEG / 2) {
		return rest - FULL_NDEG;
	}
	return rest <= -FULL_NDEG / 2 ? rest + FULL_NDEG : rest;
}

/* No elevation is beyond straight up or down. */
static int64_t upright(int64_t value)
{
	return clamp(value, -FULL_NDEG / 4, FULL_NDEG / 4);
}

static int64_t magnitude(int64_t value)
{
	return value < 0 ? -value : value;
}

static struct direction own_direction(const struct gimbal *self)
{
	return (struct direction){
		.yaw_mdeg = mdeg(self->axes[GIMBAL_PAN].position_ndeg),
		.pitch_mdeg = mdeg(self->axes[GIMBAL_TILT].position_ndeg),
	};
}

static uint32_t pulse_ns(const struct gimbal *self, enum gimbal_axis_id id)
{
	const struct gimbal_axis_config *const config = &self->config.axes[id];
	const int64_t range_ndeg = ndeg(config->max_mdeg - config->min_mdeg);
	const int64_t range_ns = (int64_t)(config->pulse_max_us - config->pulse_min_us) * NS_PER_US;
	const int64_t along_ndeg =
		clamp(self->axes[id].position_ndeg - ndeg(config->min_mdeg), 0, range_ndeg);
	const int64_t pulse = along_ndeg * range_ns / range_ndeg +
	                      (int64_t)(config->pulse_min_us + config->trim_us) * NS_PER_US;

	return (uint32_t)clamp(pulse, GIMBAL_PULSE_MIN_US * NS_PER_US,
	                       GIMBAL_PULSE_MAX_US * NS_PER_US);
}

/* --- from aims to targets --------------------------------------------------------------------- */

static bool wants_lock(const struct gimbal *self)
{
	return self->axes[GIMBAL_PAN].lock || self->axes[GIMBAL_TILT].lock;
}

static bool attitude_is_fresh(const struct gimbal *self, int64_t now_us)
{
	return self->attitude_us != NEVER_YET &&
	       now_us - self->attitude_us < self->config.attitude_timeout_us;
}

/* What is to start from where the axes are does so. */
static void adopt(struct gimbal *self)
{
	struct gimbal_axis *const pan = &self->axes[GIMBAL_PAN];
	struct gimbal_axis *const tilt = &self->axes[GIMBAL_TILT];
	int64_t yaw_ndeg = pan->position_ndeg;
	int64_t pitch_ndeg = tilt->position_ndeg;

	if (!pan->adopt && !tilt->adopt) {
		return;
	}
	if (tilt->lock) {
		const struct direction own = own_direction(self);
		const struct direction level =
			direction_from_body(own, &self->attitude, own.yaw_mdeg);

		yaw_ndeg = ndeg(level.yaw_mdeg);
		pitch_ndeg = ndeg(level.pitch_mdeg);
	}
	if (pan->adopt) {
		pan->aim_ndeg = pan->lock ? yaw_ndeg + ndeg(self->attitude.yaw_mdeg) : yaw_ndeg;
	}
	if (tilt->adopt) {
		tilt->aim_ndeg = pitch_ndeg;
	}
	pan->adopt = false;
	tilt->adopt = false;
}

static void set_target(struct gimbal *self, enum gimbal_axis_id id, int64_t wanted_ndeg)
{
	const struct gimbal_axis_config *const config = &self->config.axes[id];
	struct gimbal_axis *const axis = &self->axes[id];

	axis->target_ndeg = clamp(wanted_ndeg, ndeg(config->min_mdeg), ndeg(config->max_mdeg));
	axis->beyond_ndeg = magnitude(wanted_ndeg - axis->target_ndeg);
}

static void follow_aims(struct gimbal *self)
{
	const struct gimbal_axis *const pan = &self->axes[GIMBAL_PAN];
	const struct gimbal_axis *const tilt = &self->axes[GIMBAL_TILT];
	int64_t yaw_ndeg = pan->aim_ndeg;
	int64_t pitch_ndeg = tilt->aim_ndeg;

	if (pan->lock) {
		yaw_ndeg -= ndeg(self->attitude.yaw_mdeg);
	}
	if (tilt->lock) {
		const struct direction level = {
			.yaw_mdeg = angle_wrap_mdeg(mdeg(wrap_ndeg(yaw_ndeg))),
			.pitch_mdeg = mdeg(upright(pitch_ndeg)),
		};
		const struct direction own =
			direction_to_body(level, &self->attitude, own_direction(self).yaw_mdeg);

		yaw_ndeg = ndeg(own.yaw_mdeg);
		pitch_ndeg = ndeg(own.pitch_mdeg);
	}
	set_target(self, GIMBAL_PAN, wrap_ndeg(yaw_ndeg));
	set_target(self, GIMBAL_TILT, wrap_ndeg(pitch_ndeg));
}

static void retarget(struct gimbal *self, int64_t now_us)
{
	const bool held = wants_lock(self) && !attitude_is_fresh(self, now_us);

	self->stats.attitude_losses += held && !self->held ? 1 : 0;
	self->held = held;
	if (!held) {
		adopt(self);
		follow_aims(self);
		return;
	}
	for (int i = 0; i < GIMBAL_AXES; i++) {
		self->axes[i].target_ndeg = self->axes[i].position_ndeg;
		self->axes[i].beyond_ndeg = 0;
	}
}

/* --- time ------------------------------------------------------------------------------------- */

/* Moves the aim of a rate, which does not run away from an axis that can't follow. */
static void turn(struct gimbal *self, enum gimbal_axis_id id, int64_t by_ndeg)
{
	const struct gimbal_axis_config *const config = &self->config.axes[id];
	struct gimbal_axis *const axis = &self->axes[id];
	const int64_t aim_ndeg = axis->aim_ndeg;
	const int64_t beyond_ndeg = axis->beyond_ndeg;

	if (!wants_lock(self)) {
		axis->aim_ndeg =
			clamp(aim_ndeg + by_ndeg, ndeg(config->min_mdeg), ndeg(config->max_mdeg));
	} else if (id == GIMBAL_TILT) {
		axis->aim_ndeg = upright(aim_ndeg + by_ndeg);
	} else {
		axis->aim_ndeg = wrap_ndeg(aim_ndeg + by_ndeg);
	}
	follow_aims(self);
	if (axis->beyond_ndeg > beyond_ndeg) {
		axis->aim_ndeg = aim_ndeg;
		follow_aims(self);
	}
}

static void follow_rates(struct gimbal *self, int64_t now_us)
{
	const int64_t end_us = self->rated_us + self->config.rate_timeout_us;
	const int64_t until_us = now_us < end_us ? now_us : end_us;
	bool expired = false;

	for (int i = 0; i < GIMBAL_AXES; i++) {
		struct gimbal_axis *const axis = &self->axes[i];

		if (axis->rate == 0) {
			continue;
		}
		if (!self->held && until_us > self->stepped_us) {
			turn(self, (enum gimbal_axis_id)i,
			     axis->rate * (until_us - self->stepped_us));
		}
		if (now_us >= end_us) {
			axis->rate = 0;
			expired = true;
		}
	}
	self->stats.rate_timeouts += expired ? 1 : 0;
}

static void slew(struct gimbal *self, enum gimbal_axis_id id, int64_t duration_us)
{
	struct gimbal_axis *const axis = &self->axes[id];
	const int64_t most_ndeg = self->config.axes[id].rate_mdeg_per_s * duration_us;
	const int64_t by_ndeg =
		clamp(axis->target_ndeg - axis->position_ndeg, -most_ndeg, most_ndeg);

	axis->position_ndeg += by_ndeg;
	axis->speed = (int32_t)(by_ndeg / duration_us);
}

/* Brings everything to now_us. */
static void run(struct gimbal *self, int64_t now_us)
{
	const int64_t duration_us = now_us - self->stepped_us;

	PHAROS_ASSERT(now_us <= TIME_MAX_US && duration_us >= 0);
	retarget(self, now_us);
	if (duration_us > 0) {
		follow_rates(self, now_us);
		slew(self, GIMBAL_PAN, duration_us);
		slew(self, GIMBAL_TILT, duration_us);
		self->stepped_us = now_us;
	}
}

static bool is_moving(const struct gimbal *self)
{
	for (int i = 0; i < GIMBAL_AXES; i++) {
		const struct gimbal_axis *const axis = &self->axes[i];

		if (axis->position_ndeg != axis->target_ndeg || axis->rate != 0 ||
		    self->pulse_ns[i] != pulse_ns(self, (enum gimbal_axis_id)i)) {
			return true;
		}
	}
	return false;
}

/* Frames begin with the movement. */
static void schedule(struct gimbal *self, int64_t now_us)
{
	if (!is_moving(self)) {
		self->frame_us = TIME_NEVER_US;
		self->axes[GIMBAL_PAN].speed = 0;
		self->axes[GIMBAL_TILT].speed = 0;
	} else if (self->frame_us == TIME_NEVER_US) {
		self->frame_us = now_us + GIMBAL_FRAME_US;
	}
}

int64_t gimbal_deadline_us(const struct gimbal *self)
{
	if (wants_lock(self) && !self->held) {
		const int64_t lost_us = self->attitude_us + self->config.attitude_timeout_us;

		return lost_us < self->frame_us ? lost_us : self->frame_us;
	}
	return self->frame_us;
}

static void tell_servos(struct gimbal *self, struct gimbal_outbox *out)
{
	for (int i = 0; i < GIMBAL_AXES; i++) {
		const uint32_t pulse = pulse_ns(self, (enum gimbal_axis_id)i);

		out->move = out->move || pulse != self->pulse_ns[i];
		out->pulse_ns[i] = pulse;
		self->pulse_ns[i] = pulse;
	}
}

void gimbal_advance(struct gimbal *self, int64_t now_us, struct gimbal_outbox *out)
{
	out->move = false;
	if (now_us < gimbal_deadline_us(self)) {
		return;
	}
	run(self, now_us);
	if (now_us >= self->frame_us) {
		tell_servos(self, out);
		self->frame_us += GIMBAL_FRAME_US;
		if (self->frame_us <= now_us) {
			self->frame_us = now_us + GIMBAL_FRAME_US;
		}
	}
	schedule(self, now_us);
}

/* --- events ----------------------------------------------------------------------------------- */

static bool is_valid(const struct gimbal_aim *aim)
{
	switch (aim->kind) {
	case GIMBAL_KEEP:
		return true;
	case GIMBAL_ANGLE:
		return magnitude(aim->value) <= ANGLE_FULL_MDEG;
	case GIMBAL_RATE:
		return magnitude(aim->value) <= GIMBAL_RATE_MAX;
	}
	PHAROS_ASSERT(false);
	return false;
}

/* Both axes stand at an angle of their own. */
static void pose(struct gimbal *self, enum gimbal_mode mode)
{
	self->mode = mode;
	for (int i = 0; i < GIMBAL_AXES; i++) {
		const struct gimbal_axis_config *const config = &self->config.axes[i];
		struct gimbal_axis *const axis = &self->axes[i];
		const int32_t angle =
			mode == GIMBAL_MODE_RETRACTED ? config->retract_mdeg : config->neutral_mdeg;

		axis->kind = GIMBAL_ANGLE;
		axis->lock = false;
		axis->adopt = false;
		axis->rate = 0;
		axis->aim_ndeg = ndeg((int32_t)clamp(angle, config->min_mdeg, config->max_mdeg));
	}
}

static void aim_axis(struct gimbal *self, int64_t now_us, enum gimbal_axis_id id,
                     const struct gimbal_aim *aim)
{
	const int32_t fastest = self->config.axes[id].rate_mdeg_per_s;
	struct gimbal_axis *const axis = &self->axes[id];

	switch (aim->kind) {
	case GIMBAL_KEEP:
		break;
	case GIMBAL_ANGLE:
		axis->kind = GIMBAL_ANGLE;
		axis->adopt = false;
		axis->rate = 0;
		axis->aim_ndeg = wrap_ndeg(ndeg(aim->value));
		break;
	case GIMBAL_RATE:
		axis->adopt = axis->adopt || axis->kind != GIMBAL_RATE;
		axis->kind = GIMBAL_RATE;
		axis->rate = (int32_t)clamp(aim->value, -fastest, fastest);
		self->rated_us = now_us;
		break;
	}
}

/* A lock that comes or goes changes what both axes' aims count from. */
static void aim_both(struct gimbal *self, int64_t now_us, const struct gimbal_aim *aims)
{
	bool anew = self->mode != GIMBAL_MODE_AIMED;

	for (int i = 0; i < GIMBAL_AXES; i++) {
		const bool lock = aims[i].kind == GIMBAL_KEEP ? self->axes[i].lock : aims[i].lock;

		anew = anew || lock != self->axes[i].lock;
		self->axes[i].lock = lock;
	}
	self->mode = GIMBAL_MODE_AIMED;
	for (int i = 0; i < GIMBAL_AXES; i++) {
		self->axes[i].adopt = self->axes[i].adopt || anew;
		aim_axis(self, now_us, (enum gimbal_axis_id)i, &aims[i]);
	}
}

static void check_config(const struct gimbal_config *config)
{
	for (int i = 0; i < GIMBAL_AXES; i++) {
		const struct gimbal_axis_config *const axis = &config->axes[i];

		PHAROS_ASSERT(axis->min_mdeg >= -GIMBAL_ANGLE_MAX_MDEG);
		PHAROS_ASSERT(axis->min_mdeg < axis->max_mdeg);
		PHAROS_ASSERT(axis->max_mdeg <= GIMBAL_ANGLE_MAX_MDEG);
		PHAROS_ASSERT(axis->rate_mdeg_per_s >= 1);
		PHAROS_ASSERT(axis->rate_mdeg_per_s <= GIMBAL_RATE_MAX);
		PHAROS_ASSERT(axis->pulse_min_us >= GIMBAL_PULSE_MIN_US);
		PHAROS_ASSERT(axis->pulse_min_us <= GIMBAL_PULSE_MAX_US);
		PHAROS_ASSERT(axis->pulse_max_us >= GIMBAL_PULSE_MIN_US);
		PHAROS_ASSERT(axis->pulse_max_us <= GIMBAL_PULSE_MAX_US);
		PHAROS_ASSERT(magnitude(axis->trim_us) <= GIMBAL_PULSE_MAX_US);
	}
	PHAROS_ASSERT(config->rate_timeout_us >= 0 && config->rate_timeout_us <= TIME_MAX_US);
	PHAROS_ASSERT(config->attitude_timeout_us >= 0);
	PHAROS_ASSERT(config->attitude_timeout_us <= TIME_MAX_US);
}

void gimbal_init(struct gimbal *self, int64_t now_us, const struct gimbal_config *config)
{
	check_config(config);
	*self = (struct gimbal){
		.config = *config,
		.attitude_us = NEVER_YET,
		.stepped_us = now_us,
		.frame_us = now_us,
	};
	pose(self, GIMBAL_MODE_NEUTRAL);
	for (int i = 0; i < GIMBAL_AXES; i++) {
		self->axes[i].position_ndeg = self->axes[i].aim_ndeg;
	}
	retarget(self, now_us);
}

static void configure(struct gimbal *self, const struct gimbal_config *config)
{
	check_config(config);
	self->config = *config;
	if (self->mode != GIMBAL_MODE_AIMED) {
		pose(self, self->mode);
	}
}

static void take_attitude(struct gimbal *self, int64_t now_us, const struct attitude *attitude)
{
	self->attitude = (struct attitude){
		.roll_mdeg = angle_wrap_mdeg(attitude->roll_mdeg),
		.pitch_mdeg = angle_wrap_mdeg(attitude->pitch_mdeg),
		.yaw_mdeg = angle_wrap_mdeg(attitude->yaw_mdeg),
	};
	self->attitude_us = now_us;
}

enum gimbal_result gimbal_step(struct gimbal *self, int64_t now_us,
                               const struct gimbal_event *event)
{
	if (event->kind == GIMBAL_EVENT_AIM &&
	    (!is_valid(&event->aim[GIMBAL_PAN]) || !is_valid(&event->aim[GIMBAL_TILT]))) {
		self->stats.denied++;
		return GIMBAL_DENIED;
	}
	run(self, now_us);
	switch (event->kind) {
	case GIMBAL_EVENT_AIM:
		self->stats.accepted++;
		aim_both(self, now_us, event->aim);
		break;
	case GIMBAL_EVENT_NEUTRAL:
		self->stats.accepted++;
		pose(self, GIMBAL_MODE_NEUTRAL);
		break;
	case GIMBAL_EVENT_RETRACT:
		self->stats.accepted++;
		pose(self, GIMBAL_MODE_RETRACTED);
		break;
	case GIMBAL_EVENT_ATTITUDE:
		take_attitude(self, now_us, &event->attitude);
		break;
	case GIMBAL_EVENT_CONFIG:
		configure(self, &event->config);
		break;
	case GIMBAL_EVENT_FAULT:
		self->fault = event->fault;
		break;
	}
	retarget(self, now_us);
	schedule(self, now_us);
	return GIMBAL_ACCEPTED;
}

/* --- telling ---------------------------------------------------------------------------------- */

/* The aim is beyond a limit, or a rate pushes against it. */
static bool is_at_limit(const struct gimbal *self, enum gimbal_axis_id id)
{
	const struct gimbal_axis_config *const config = &self->config.axes[id];
	const struct gimbal_axis *const axis = &self->axes[id];

	return axis->beyond_ndeg > 0 ||
	       (axis->rate > 0 && axis->target_ndeg >= ndeg(config->max_mdeg)) ||
	       (axis->rate < 0 && axis->target_ndeg <= ndeg(config->min_mdeg));
}

struct gimbal_report gimbal_report(const struct gimbal *self, int64_t now_us)
{
	const struct gimbal_axis *const pan = &self->axes[GIMBAL_PAN];
	const struct gimbal_axis *const tilt = &self->axes[GIMBAL_TILT];
	const bool fresh = attitude_is_fresh(self, now_us);
	const struct direction own = own_direction(self);

	return (struct gimbal_report){
		.mode = self->mode,
		.pan_locked = pan->lock && fresh,
		.tilt_locked = tilt->lock && fresh,
		.attitude_lost = wants_lock(self) && !fresh,
		.fault = self->fault,
		.at_limit = {is_at_limit(self, GIMBAL_PAN), is_at_limit(self, GIMBAL_TILT)},
		.own = own,
		.level = fresh ? direction_from_body(own, &self->attitude, own.yaw_mdeg) : own,
		.speed = {pan->speed, tilt->speed},
		.heading_known = fresh,
		.heading_mdeg = self->attitude.yaw_mdeg,
	};
}

int32_t gimbal_share_mdeg(const struct gimbal *self, enum gimbal_axis_id axis, int32_t share_ppm)
{
	const struct gimbal_axis_config *const config = &self->config.axes[axis];
	const int64_t range_mdeg = config->max_mdeg - config->min_mdeg;
	const int64_t one = PPM_ONE;

	PHAROS_ASSERT(share_ppm >= -one && share_ppm <= one);
	return (int32_t)(config->min_mdeg + (range_mdeg * (share_ppm + one) + one) / (2 * one));
}

int32_t gimbal_share_rate(const struct gimbal *self, enum gimbal_axis_id axis, int32_t share_ppm)
{
	const int64_t fastest = self->config.axes[axis].rate_mdeg_per_s;

	return (int32_t)(fastest * share_ppm / (int32_t)PPM_ONE);
}

const char *gimbal_mode_name(enum gimbal_mode mode)
{
	switch (mode) {
	case GIMBAL_MODE_NEUTRAL:
		return "neutral";
	case GIMBAL_MODE_RETRACTED:
		return "retracted";
	case GIMBAL_MODE_AIMED:
		return "aimed";
	}
	PHAROS_ASSERT(false);
	return "";
}
