/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A gimbal of two servos that turn the beam: pan (yaw, positive to the right) and tilt (pitch,
 * positive up), in thousandths of a degree from straight ahead of the vehicle.
 *
 * Each axis has an aim: an angle or a rate. Without lock it is an angle of the axis itself. A
 * locked tilt is an elevation over the horizon, and then pan counts from the vehicle's heading; a
 * locked pan counts from north. Locks take the vehicle's attitude out. While that is older than
 * attitude_timeout_us, a gimbal with a lock holds still where it is, and goes on when it comes.
 * A rate not renewed for rate_timeout_us is 0.
 *
 * What lies beyond an axis's limits is approached to the limit. An axis never turns faster than its
 * rate. Positions are told at GIMBAL_FRAME_US while they change, and not when they don't. There is
 * no feedback: where the gimbal is means where its servos were told to be.
 *
 * Context: the thread that owns it, no locks inside. Spec: mavlink.io/en/services/gimbal_v2.html.
 */
#ifndef PHAROS_CORE_GIMBAL_H
#define PHAROS_CORE_GIMBAL_H

#include "core/angle.h"
#include "core/limits.h"

#include <stdbool.h>
#include <stdint.h>

enum gimbal_axis_id {
	GIMBAL_PAN,
	GIMBAL_TILT,
	GIMBAL_AXES
};

/*
 * -GIMBAL_ANGLE_MAX_MDEG <= min_mdeg < max_mdeg <= GIMBAL_ANGLE_MAX_MDEG; 1 <= rate <=
 * GIMBAL_RATE_MAX; pulses within GIMBAL_PULSE_MIN_US…_MAX_US, the first may be the longer one: all
 * asserted. Neutral and retracted positions beyond the limits are at them.
 */
struct gimbal_axis_config {
	int32_t min_mdeg;
	int32_t max_mdeg;
	int32_t neutral_mdeg;
	int32_t retract_mdeg;
	int32_t rate_mdeg_per_s; /* the fastest */
	int32_t pulse_min_us;    /* at min_mdeg */
	int32_t pulse_max_us;    /* at max_mdeg */
	int32_t trim_us;         /* added to every pulse */
};

struct gimbal_config {
	struct gimbal_axis_config axes[GIMBAL_AXES];
	int64_t rate_timeout_us;
	int64_t attitude_timeout_us;
};

enum gimbal_aim_kind {
	GIMBAL_KEEP, /* as before; a gimbal that was neutral or retracted stays where it is */
	GIMBAL_ANGLE,
	GIMBAL_RATE,
};

/* value: of ANGLE within ±ANGLE_FULL_MDEG, of RATE within ±GIMBAL_RATE_MAX. lock: not of KEEP. */
struct gimbal_aim {
	enum gimbal_aim_kind kind;
	bool lock;
	int32_t value;
};

enum gimbal_event_kind {
	GIMBAL_EVENT_AIM, /* aim, of each axis */
	GIMBAL_EVENT_NEUTRAL,
	GIMBAL_EVENT_RETRACT,
	GIMBAL_EVENT_ATTITUDE, /* attitude: the vehicle's, now */
	GIMBAL_EVENT_CONFIG,   /* config */
	GIMBAL_EVENT_FAULT,    /* fault: a servo can't be driven, or can again */
};

struct gimbal_event {
	enum gimbal_event_kind kind;
	union {
		struct gimbal_aim aim[GIMBAL_AXES];
		struct attitude attitude;
		struct gimbal_config config;
		bool fault;
	};
};

/* DENIED: a value of an aim out of range; nothing changed. */
enum gimbal_result {
	GIMBAL_ACCEPTED,
	GIMBAL_DENIED,
};

/* move: the servos shall get these pulses now. */
struct gimbal_outbox {
	bool move;
	uint32_t pulse_ns[GIMBAL_AXES];
};

enum gimbal_mode {
	GIMBAL_MODE_NEUTRAL,
	GIMBAL_MODE_RETRACTED,
	GIMBAL_MODE_AIMED,
};

struct gimbal_stats {
	uint32_t accepted; /* aims, neutral, retract */
	uint32_t denied;
	uint32_t rate_timeouts;
	uint32_t attitude_losses;
};

/* Positions and aims are kept in 10^-9 degrees, so that slow rates add up exactly. */
struct gimbal_axis {
	enum gimbal_aim_kind kind; /* ANGLE or RATE */
	bool lock;
	bool adopt;   /* the aim starts from where the axis is */
	int32_t rate; /* of the aim, mdeg/s */
	int64_t aim_ndeg;
	int64_t target_ndeg; /* within the limits */
	int64_t beyond_ndeg; /* how far the aim is beyond them */
	int64_t position_ndeg;
	int32_t speed; /* of the last step, mdeg/s */
};

/* Readable by the owner; only the functions below write. */
struct gimbal {
	struct gimbal_config config;
	enum gimbal_mode mode;
	struct gimbal_axis axes[GIMBAL_AXES];
	struct attitude attitude;
	int64_t attitude_us; /* of the last one; -1: none yet */
	int64_t rated_us;    /* of the last rate */
	int64_t stepped_us;  /* positions are up to here */
	int64_t frame_us;    /* when the servos are told next; TIME_NEVER_US: still */
	uint32_t pulse_ns[GIMBAL_AXES];
	bool held; /* for want of an attitude */
	bool fault;
	struct gimbal_stats stats;
};

/*
 * Where the beam points. *_locked: the aim's lock is in force. attitude_lost: a lock is wanted, but
 * can't be.
 */
struct gimbal_report {
	enum gimbal_mode mode;
	bool pan_locked;
	bool tilt_locked;
	bool attitude_lost;
	bool fault;
	bool at_limit[GIMBAL_AXES];
	struct direction own;   /* pan and tilt */
	struct direction level; /* from the vehicle's heading and the horizon; own if not known */
	int32_t speed[GIMBAL_AXES];
	bool heading_known;
	int32_t heading_mdeg; /* the vehicle's yaw */
};

/* At the neutral position, of which the servos are told at now_us. config as above (asserted). */
void gimbal_init(struct gimbal *self, int64_t now_us, const struct gimbal_config *config);

/* now_us 0…TIME_MAX_US, never going back. The servos move with gimbal_advance. */
enum gimbal_result gimbal_step(struct gimbal *self, int64_t now_us,
                               const struct gimbal_event *event);

/* Does what is due. *out is overwritten. */
void gimbal_advance(struct gimbal *self, int64_t now_us, struct gimbal_outbox *out);

/* When gimbal_advance has something to do; TIME_NEVER_US: not without an event. */
int64_t gimbal_deadline_us(const struct gimbal *self);

struct gimbal_report gimbal_report(const struct gimbal *self, int64_t now_us);

/* Angle of a share of the axis's range: -PPM_ONE is its minimum, PPM_ONE its maximum (asserted). */
int32_t gimbal_share_mdeg(const struct gimbal *self, enum gimbal_axis_id axis, int32_t share_ppm);

/* A share of an axis's fastest rate, -PPM_ONE…PPM_ONE, in mdeg/s. */
int32_t gimbal_share_rate(const struct gimbal *self, enum gimbal_axis_id axis, int32_t share_ppm);

/* For people, constant and never NULL: "neutral", … */
const char *gimbal_mode_name(enum gimbal_mode mode);

#endif
