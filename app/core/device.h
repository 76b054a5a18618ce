/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The device: its lamps, gimbal, outputs, parameters, and who commands them. The one door: whoever
 * wants something changed (a protocol, the shell, a button, heat) calls one of the verbs below with
 * who it is; nothing else changes what is in here.
 *
 *   pharos_device_apply(&device, now_us, &who, LAMP, &event, 1);  says what became of it
 *   …
 *   pharos_device_step(&device, now_us);                          at its deadline
 *   while (pharos_device_take(&device, &effects)) {
 *           perform what is to be done, then let every protocol tell its peers
 *   }
 *
 * A verb checks (may this source do this now?), decides whole and applies whole: a result other
 * than ACCEPTED changed nothing but counters. What follows is collected: a bit for each thing that
 * differs, which itself is read from the device when it is performed. So any number of verbs fit
 * before the effects are taken, and the last value counts.
 *
 * A lamp is a number below DEVICE_LAMPS_MAX (asserted); a channel's meaning is its module's. Zephyr
 * has a `struct device` and a `device_init` of its own, hence the longer names.
 *
 * Context: the thread that owns it, no locks inside. Readable by the owner; only the verbs write.
 */
#ifndef PHAROS_CORE_DEVICE_H
#define PHAROS_CORE_DEVICE_H

#include "core/actuators.h"
#include "core/arbiter.h"
#include "core/gimbal.h"
#include "core/illuminator.h"
#include "core/limits.h"
#include "core/params.h"
#include "core/security.h"
#include "core/self_test.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * Who asks: the way that the request came, and the link of that protocol. is_repeated: the same as
 * this source's command before, sent again by itself; it takes the device from nobody who has
 * commanded it since, but says that its source is there.
 */
struct device_who {
	enum security_way way;
	uint8_t link;
	bool is_repeated;
};

enum device_result {
	DEVICE_ACCEPTED,
	DEVICE_DENIED, /* a value out of range */
	DEVICE_FAILED, /* valid, but not now: heat, no power, a controller that arms, a test runs */
	DEVICE_ABSENT, /* this device has no such thing */
	DEVICE_EXCLUDED,  /* the source may not: excluded by parameter, or without the key */
	DEVICE_OUTRANKED, /* not now: a source with priority is in command */
	DEVICE_KEPT,      /* a repetition; somebody else is in command, and stays so */
};

struct device_lamp {
	struct illuminator illuminator;
	struct arbiter arbiter;
	struct self_test self_test;
};

/* What has been asked for and not been taken yet. Bit n of a mask is lamp n. */
struct device_effects {
	uint8_t lights;   /* illuminator.plan is new: carry it out */
	uint8_t settings; /* illuminator.settings differ: store them if they are to be restored */
	uint8_t statuses; /* settings, flags or limits differ: tell (not: temperature alone) */
	uint8_t reports;  /* illuminator.thermal is a new report */
	uint8_t notices[DEVICE_LAMPS_MAX]; /* bit per illuminator_notice_kind: tell people */
	bool move;                         /* the servos shall get gimbal.pulse_ns now */
	bool outputs;                      /* actuators_outputs() may differ */
	bool has_shutdown;                 /* tell everyone: */
	struct shutdown_notice shutdown;
	struct param_set params; /* have changed: tell, store, put in force outside the core */
};

/* What the board has. actuators: without the times and the thruster, which are parameters. */
struct device_config {
	bool gimbal;
	struct actuators_config actuators;
};

struct pharos_device {
	struct params params;
	struct security security;
	struct device_lamp lamps[DEVICE_LAMPS_MAX];
#ifdef CONFIG_PHAROS_GIMBAL
	bool has_gimbal; /* else the next two mean nothing */
	struct gimbal gimbal;
	struct arbiter gimbal_arbiter;
#endif
#ifdef CONFIG_PHAROS_IMC
	struct actuators actuators;
	enum security_way scheduled[POWER_CHANNELS_MAX]; /* who the channel's schedules are from */
	enum security_way shut_down; /* who the power-down is from, that goes on or is scheduled */
#endif
	struct device_effects effects;
	bool has_effects;
};

/* With self->params as loaded, which the caller does before. The lamps are off. */
void pharos_device_init(struct pharos_device *self, int64_t now_us,
                        const struct device_config *config);

/*
 * The security table's answer. Every verb below asks by itself; a protocol asks where what it is to
 * do lies outside the device: a restart, an update, whose vehicle's system id it takes.
 */
bool pharos_device_may(const struct pharos_device *self, const struct device_who *who,
                       enum security_right right);

/* There is a key, or none any more. What was scheduled without a right to it now lapses. */
void pharos_device_set_keyed(struct pharos_device *self, int64_t now_us, bool has_key);

/* --- commands --------------------------------------------------------------------------------- */

/*
 * To a lamp: ON_OFF, CONFIGURE, BRIGHTNESS, RESTORE (others asserted away); several: all or none,
 * in order. ACCEPTED, DENIED, FAILED, EXCLUDED, OUTRANKED, KEPT.
 */
enum device_result pharos_device_apply(struct pharos_device *self, int64_t now_us,
                                       const struct device_who *who, uint8_t lamp,
                                       const struct illuminator_event *events, size_t count);

/*
 * What was commanded before the reset; a strobe that was allowed then takes the nearest period that
 * is now. ACCEPTED, DENIED, FAILED.
 */
enum device_result pharos_device_restore(struct pharos_device *self, int64_t now_us, uint8_t lamp,
                                         const struct illuminator_settings *settings);

/*
 * Begins a self-test up to peak_ppm, 1…PPM_ONE. *obstacle: what stands against it, and then FAILED;
 * else NONE, and ACCEPTED, FAILED, EXCLUDED or OUTRANKED.
 */
enum device_result pharos_device_test(struct pharos_device *self, int64_t now_us,
                                      const struct device_who *who, uint8_t lamp, uint32_t peak_ppm,
                                      enum self_test_state *obstacle);

/* Ends the self-test; false: none runs. */
bool pharos_device_cancel_test(struct pharos_device *self, int64_t now_us,
                               const struct device_who *who, uint8_t lamp);

#ifdef CONFIG_PHAROS_GIMBAL
/*
 * To the gimbal, which has an arbiter of its own: AIM, NEUTRAL, RETRACT (others asserted away).
 * ACCEPTED, DENIED, ABSENT, EXCLUDED, OUTRANKED, KEPT. Servos begin to move within GIMBAL_FRAME_US.
 */
enum device_result pharos_device_point(struct pharos_device *self, int64_t now_us,
                                       const struct device_who *who,
                                       const struct gimbal_event *event);

/* The aim moves on by itself, as it does with a target that is tracked: as point, but no command.
 * KEPT: another source is in command.
 */
enum device_result pharos_device_follow(struct pharos_device *self, int64_t now_us,
                                        const struct device_who *who,
                                        const struct gimbal_event *event);

/* Where on an axis a share of its range is, and what share of its fastest rate. There is a gimbal
 * (asserted). As gimbal_share_mdeg and gimbal_share_rate.
 */
int32_t pharos_device_share_mdeg(const struct pharos_device *self, enum gimbal_axis_id axis,
                                 int32_t share_ppm);
int32_t pharos_device_share_rate(const struct pharos_device *self, enum gimbal_axis_id axis,
                                 int32_t share_ppm);
#else
static inline enum device_result pharos_device_point(struct pharos_device *self, int64_t now_us,
                                                     const struct device_who *who,
                                                     const struct gimbal_event *event)
{
	(void)self, (void)now_us, (void)who, (void)event;
	return DEVICE_ABSENT;
}

static inline int32_t pharos_device_share_mdeg(const struct pharos_device *self,
                                               enum gimbal_axis_id axis, int32_t share_ppm)
{
	(void)self, (void)axis, (void)share_ppm;
	return 0;
}

static inline int32_t pharos_device_share_rate(const struct pharos_device *self,
                                               enum gimbal_axis_id axis, int32_t share_ppm)
{
	(void)self, (void)axis, (void)share_ppm;
	return 0;
}
#endif

#ifdef CONFIG_PHAROS_IMC
/*
 * To an output. The lamp's power and the power of the whole device are the lamp's, so they ask its
 * arbiter. ACCEPTED, DENIED, FAILED, EXCLUDED, OUTRANKED.
 */
enum device_result pharos_device_output(struct pharos_device *self, int64_t now_us,
                                        const struct device_who *who,
                                        const struct actuators_event *event);
#endif

/* Results as params_set, or FORBIDDEN. In force at once, as far as the core is concerned. */
enum params_result pharos_device_set_param(struct pharos_device *self, int64_t now_us,
                                           const struct device_who *who, uint32_t index,
                                           int32_t value);
/* False: that source may not. */
bool pharos_device_reset_params(struct pharos_device *self, int64_t now_us,
                                const struct device_who *who);

/* --- reports ---------------------------------------------------------------------------------- */

/* A sign of life that is no command: a heartbeat of a ground station, … */
void pharos_device_heard(struct pharos_device *self, int64_t now_us, const struct device_who *who);

void pharos_device_report_heat(struct pharos_device *self, int64_t now_us, uint8_t lamp,
                               const struct thermal_report *report);

/* What the lamp's driver says of itself. */
void pharos_device_report_driver(struct pharos_device *self, uint8_t lamp, bool fault);

#ifdef CONFIG_PHAROS_GIMBAL
/* The vehicle's attitude, now. Without a gimbal: nothing. */
void pharos_device_report_attitude(struct pharos_device *self, int64_t now_us,
                                   const struct device_who *who, const struct attitude *attitude);

/* The servos can't be driven, or can again. True: that is news. There is a gimbal (asserted). */
bool pharos_device_report_servos(struct pharos_device *self, int64_t now_us, bool fault);
#endif

/* --- time and effects ------------------------------------------------------------------------- */

/* Does what is due. */
void pharos_device_step(struct pharos_device *self, int64_t now_us);
int64_t pharos_device_deadline_us(const struct pharos_device *self);

/* Moves what is to be done into *effects; false: nothing is. */
bool pharos_device_take(struct pharos_device *self, struct device_effects *effects);

/* --- reading ---------------------------------------------------------------------------------- */

/* A lamp, to look at. Where there is but one, its number costs nothing. */
static inline const struct device_lamp *pharos_device_lamp(const struct pharos_device *self,
                                                           uint8_t lamp)
{
	return &self->lamps[DEVICE_LAMPS_MAX > 1 ? lamp : 0];
}

static inline bool pharos_device_has_gimbal(const struct pharos_device *self)
{
#ifdef CONFIG_PHAROS_GIMBAL
	return self->has_gimbal;
#else
	return false;
#endif
}

#endif
