/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The device's parameters: one table, from which MAVLink, DroneCAN, IMC, the shell, the storage and
 * the documents take names, units, ranges and defaults. The set and its order are fixed.
 *
 * A value is an int32_t. A set is checked against its own range and against its neighbours (recover
 * < throttle < shutdown, …); a refused set changed nothing. Results tell which parameters changed,
 * as a mask, so that the caller can tell those concerned.
 *
 * Context: the thread that owns it. Defaults come from Kconfig (CONFIG_PHAROS_…).
 */
#ifndef PHAROS_CORE_PARAMS_H
#define PHAROS_CORE_PARAMS_H

#include "core/arbiter.h"
#include "core/illuminator.h"
#include "core/limits.h"
#include "core/sync.h"
#include "core/thermal.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PARAM_FLAG_REBOOT    1u /* in force after the next reset */
#define PARAM_FLAG_READ_ONLY 2u /* the device's own state, told but not set */

/* Who must be told of a change. */
enum param_group {
	PARAM_GROUP_LIGHT,
	PARAM_GROUP_THERMAL,
	PARAM_GROUP_SYNC,
	PARAM_GROUP_MAVLINK,
	PARAM_GROUP_ARBITER,
	PARAM_GROUP_DRONECAN,
};

/* X(id, name, group, unit, min, max, default, flags, meaning) */
#define PARAMS_TABLE(X)                                                                            \
	X(LGT_CURVE, "LGT_CURVE", LIGHT, "", 0, 1, CONFIG_PHAROS_LIGHT_CURVE, 0,                   \
	  "Brightness to light: 0 linear, 1 perceptual (CIE 1931)")                                \
	X(LGT_RESTORE, "LGT_RESTORE", LIGHT, "", 0, 1, CONFIG_PHAROS_LIGHT_RESTORE,                \
	  PARAM_FLAG_REBOOT, "After a reset: 0 off, 1 as it was last commanded")                   \
	X(LGT_FALLBACK, "LGT_FALLBACK", ARBITER, "", 0, 2, CONFIG_PHAROS_LIGHT_FALLBACK, 0,        \
	  "When every commander is silent: 0 keep, 1 off, 2 beacon")                               \
	X(LGT_LOSS_MS, "LGT_LOSS_MS", ARBITER, "ms", 0, 3600000, CONFIG_PHAROS_LIGHT_LOSS_MS, 0,   \
	  "Silence after which the fallback applies, 0 never")                                     \
	X(LGT_SRC_PRIO, "LGT_SRC_PRIO", ARBITER, "", 0, 4, CONFIG_PHAROS_SOURCE_PRIORITY, 0,       \
	  "Source that outranks the others: 0 none, 1 MAVLink, 2 DroneCAN, 3 IMC, 4 shell")        \
	X(LGT_SRC_HOLD, "LGT_SRC_HOLD", ARBITER, "ms", 0, 3600000, CONFIG_PHAROS_SOURCE_HOLD_MS,   \
	  0, "How long after its last command that source outranks the others")                    \
	X(LGT_SRC_EXCL, "LGT_SRC_EXCL", ARBITER, "", 0, 15, CONFIG_PHAROS_SOURCE_EXCLUDE, 0,       \
	  "Sources that may not command: sum of 1 MAVLink, 2 DroneCAN, 4 IMC, 8 shell")            \
	X(LGT_SRC_NOW, "LGT_SRC_NOW", ARBITER, "", 0, 5, 0, PARAM_FLAG_READ_ONLY,                  \
	  "Source in command: as LGT_SRC_PRIO, 5 the fallback")                                    \
	X(STRB_MIN_US, "STRB_MIN_US", LIGHT, "us", 1000, 60000000,                                 \
	  CONFIG_PHAROS_STROBE_PERIOD_MIN_US, 0, "Shortest strobe period")                         \
	X(STRB_MAX_US, "STRB_MAX_US", LIGHT, "us", 1000, 60000000,                                 \
	  CONFIG_PHAROS_STROBE_PERIOD_MAX_US, 0, "Longest strobe period")                          \
	X(THR_THROTTLE, "THR_THROTTLE", THERMAL, "mdegC", -40000, 150000,                          \
	  CONFIG_PHAROS_THERMAL_THROTTLE_MDEGC, 0, "Derating begins here")                         \
	X(THR_SHUTDOWN, "THR_SHUTDOWN", THERMAL, "mdegC", -40000, 150000,                          \
	  CONFIG_PHAROS_THERMAL_SHUTDOWN_MDEGC, 0, "The lamp goes off here")                       \
	X(THR_RECOVER, "THR_RECOVER", THERMAL, "mdegC", -40000, 150000,                            \
	  CONFIG_PHAROS_THERMAL_RECOVER_MDEGC, 0, "Below this a shutdown ends")                    \
	X(THR_HYST, "THR_HYST", THERMAL, "mdegC", 0, 50000,                                        \
	  CONFIG_PHAROS_THERMAL_HYSTERESIS_MDEGC, 0, "Throttling ends this far below its begin")   \
	X(THR_FLOOR, "THR_FLOOR", THERMAL, "ppm", 0, 1000000, CONFIG_PHAROS_THERMAL_FLOOR_PPM, 0,  \
	  "Limit that derating reaches just below shutdown")                                       \
	X(THR_SAFE, "THR_SAFE", THERMAL, "ppm", 0, 1000000, CONFIG_PHAROS_THERMAL_SAFE_PPM, 0,     \
	  "Limit while the sensor has failed")                                                     \
	X(THR_SLEW, "THR_SLEW", THERMAL, "ppm/s", 1, 1000000000,                                   \
	  CONFIG_PHAROS_THERMAL_SLEW_PPM_PER_S, 0, "Fastest rise of the limit")                    \
	X(THR_SENS_MIN, "THR_SENS_MIN", THERMAL, "mdegC", -273150, 1000000,                        \
	  CONFIG_PHAROS_THERMAL_SENSOR_MIN_MDEGC, 0, "Colder than this is not plausible")          \
	X(THR_SENS_MAX, "THR_SENS_MAX", THERMAL, "mdegC", -273150, 1000000,                        \
	  CONFIG_PHAROS_THERMAL_SENSOR_MAX_MDEGC, 0, "Hotter than this is not plausible")          \
	X(THR_RATE, "THR_RATE", THERMAL, "mdegC/s", 1, 10000000,                                   \
	  CONFIG_PHAROS_THERMAL_SENSOR_RATE_MDEGC_PER_S, 0, "Faster changes are not plausible")    \
	X(THR_NOISE, "THR_NOISE", THERMAL, "mdegC", 0, 100000,                                     \
	  CONFIG_PHAROS_THERMAL_SENSOR_NOISE_MDEGC, 0, "Noise allowed beyond that rate")           \
	X(THR_STUCK_MS, "THR_STUCK_MS", THERMAL, "ms", 100, 3600000,                               \
	  CONFIG_PHAROS_THERMAL_SENSOR_STUCK_MS, 0, "A lit lamp's sensor may stand still so long") \
	X(THR_MISS_MS, "THR_MISS_MS", THERMAL, "ms", 100, 60000,                                   \
	  CONFIG_PHAROS_THERMAL_SENSOR_MISSING_MS, 0, "Samples may stay away so long")             \
	X(THR_GOOD_N, "THR_GOOD_N", THERMAL, "", 1, 1000,                                          \
	  CONFIG_PHAROS_THERMAL_SENSOR_GOOD_SAMPLES, 0,                                            \
	  "Good samples in a row that heal a sensor")                                              \
	X(SYNC_MODE, "SYNC_MODE", SYNC, "", 0, 1, CONFIG_PHAROS_SYNC_MODE, 0,                      \
	  "External sync: 0 the gate follows the input, 1 each edge gives a pulse")                \
	X(SYNC_POL, "SYNC_POL", SYNC, "", 0, 1, CONFIG_PHAROS_SYNC_POLARITY, 0,                    \
	  "Input is active: 0 high, 1 low")                                                        \
	X(SYNC_RETRIG, "SYNC_RETRIG", SYNC, "", 0, 1, CONFIG_PHAROS_SYNC_RETRIGGER, 0,             \
	  "An edge during a pulse: 0 is ignored, 1 prolongs it")                                   \
	X(SYNC_LOSS, "SYNC_LOSS", SYNC, "", 0, 2, CONFIG_PHAROS_SYNC_POLICY, 0,                    \
	  "When the input is silent: 0 off, 1 on, 2 internal strobe")                              \
	X(SYNC_LOSS_MS, "SYNC_LOSS_MS", SYNC, "ms", 0, 3600000, CONFIG_PHAROS_SYNC_TIMEOUT_MS, 0,  \
	  "Silence of the input that counts as loss, 0 never")                                     \
	X(SYNC_FILT_US, "SYNC_FILT_US", SYNC, "us", 0, 1000000, CONFIG_PHAROS_SYNC_FILTER_US, 0,   \
	  "Shorter changes of the input are glitches")                                             \
	X(SYNC_PULSE_US, "SYNC_PULSE_US", SYNC, "us", 1, 60000000, CONFIG_PHAROS_SYNC_PULSE_US, 0, \
	  "Length of a pulse")                                                                     \
	X(MAV_SYSID, "MAV_SYSID", MAVLINK, "", 0, 255, CONFIG_PHAROS_MAVLINK_SYSTEM_ID,            \
	  PARAM_FLAG_REBOOT, "MAVLink system id, 0 adopts the vehicle's")                          \
	X(MAV_COMPID, "MAV_COMPID", MAVLINK, "", 1, 255, CONFIG_PHAROS_MAVLINK_COMPONENT_ID,       \
	  PARAM_FLAG_REBOOT, "MAVLink component id")                                               \
	X(CAN_NODE_ID, "CAN_NODE_ID", DRONECAN, "", 0, 125, CONFIG_PHAROS_CAN_NODE_ID,             \
	  PARAM_FLAG_REBOOT, "DroneCAN node id, 0 asks the allocator")                             \
	X(CAN_FD, "CAN_FD", DRONECAN, "", 0, 1, CONFIG_PHAROS_CAN_FD, PARAM_FLAG_REBOOT,           \
	  "CAN FD: 0 no, 1 yes")                                                                   \
	X(CAN_BITRATE, "CAN_BITRATE", DRONECAN, "bit/s", 10000, 1000000,                           \
	  CONFIG_PHAROS_CAN_BITRATE, PARAM_FLAG_REBOOT, "Bit rate of the CAN bus")                 \
	X(CAN_LIGHT_ID, "CAN_LIGHT_ID", DRONECAN, "", -1, 255, CONFIG_PHAROS_CAN_LIGHT_ID, 0,      \
	  "Light id in LightsCommand that is ours, -1 none")                                       \
	X(CAN_HARDPT_ID, "CAN_HARDPT_ID", DRONECAN, "", -1, 255, CONFIG_PHAROS_CAN_HARDPOINT_ID,   \
	  0, "Hardpoint id that switches the light, -1 none")                                      \
	X(CAN_ACT_BRT, "CAN_ACT_BRT", DRONECAN, "", 0, 255, CONFIG_PHAROS_CAN_ACTUATOR_BRIGHTNESS, \
	  0, "Actuator id of the brightness, 0 none")                                              \
	X(CAN_ACT_PAN, "CAN_ACT_PAN", DRONECAN, "", 0, 255, CONFIG_PHAROS_CAN_ACTUATOR_PAN, 0,     \
	  "Actuator id of pan, 0 none")                                                            \
	X(CAN_ACT_TILT, "CAN_ACT_TILT", DRONECAN, "", 0, 255, CONFIG_PHAROS_CAN_ACTUATOR_TILT, 0,  \
	  "Actuator id of tilt, 0 none")

#define PARAMS_ID(id, name, group, unit, min, max, fallback, flags, meaning) PARAM_##id,
enum param_id {
	PARAMS_TABLE(PARAMS_ID) PARAM_COUNT
};
#undef PARAMS_ID

_Static_assert(PARAM_COUNT <= PARAMS_MAX, "a mask has a bit for each parameter");

/* name: 1…PARAMS_NAME_MAX characters A-Z 0-9 _, terminated. unit "": a number or a choice. */
struct param_info {
	const char *name;
	const char *unit;
	const char *meaning;
	int32_t min;
	int32_t max;
	int32_t fallback; /* the default */
	uint32_t flags;
	enum param_group group;
};

/*
 * UNKNOWN: no such index or name. READ_ONLY: flagged so. OUT_OF_RANGE: outside its own range.
 * CONFLICT: within its range, but not beside another one's present value.
 */
enum params_result {
	PARAMS_OK,
	PARAMS_UNKNOWN,
	PARAMS_READ_ONLY,
	PARAMS_OUT_OF_RANGE,
	PARAMS_CONFLICT,
};

struct params {
	int32_t values[PARAM_COUNT];
};

#define PARAM_MASK(id) ((uint64_t)1 << (id))

/* All defaults. */
void params_init(struct params *self);

/* NULL: index >= PARAM_COUNT. */
const struct param_info *params_info(uint32_t index);

/* Index of a name, which need not be terminated (length: without terminator); PARAM_COUNT: none. */
uint32_t params_find(const char *name, size_t length);

/* UNKNOWN: *value is untouched. */
enum params_result params_get(const struct params *self, uint32_t index, int32_t *value);
enum params_result params_get_by_name(const struct params *self, const char *name, size_t length,
                                      int32_t *value);

/* *changed: PARAM_MASK of what changed; 0 when refused or when it was that value already. */
enum params_result params_set(struct params *self, uint32_t index, int32_t value,
                              uint64_t *changed);
enum params_result params_set_by_name(struct params *self, const char *name, size_t length,
                                      int32_t value, uint64_t *changed);

/* A read-only one (asserted) is now this, within its range (asserted). */
void params_tell(struct params *self, enum param_id id, int32_t value);

/* Back to the defaults, except read-only ones. Returns the mask of what changed. */
uint64_t params_reset(struct params *self);

/*
 * A whole stored set at once, so that no order of single sets matters. A value out of range, and
 * every member of a rule that does not hold, become the default. Read-only ones stay as they are.
 * Returns the mask of what became the default.
 */
uint64_t params_load(struct params *self, const int32_t values[PARAM_COUNT]);

/* The parameters of a group, as a mask. */
uint64_t params_group_mask(enum param_group group);

/* Those that can be set, as a mask: what is worth storing. */
uint64_t params_settable_mask(void);

/* What the modules take. */
void params_illuminator(const struct params *self, struct illuminator_config *config);
void params_thermal(const struct params *self, struct thermal_config *config);
void params_sync(const struct params *self, struct sync_config *config);
void params_arbiter(const struct params *self, struct arbiter_config *config);

/* For people, constant and never NULL: "ok", "unknown", … */
const char *params_result_name(enum params_result result);

#endif
