/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The device's parameters: one table, from which MAVLink, DroneCAN, IMC, the shell, the storage and
 * the documents take names, units, ranges and defaults. The set and its order are fixed.
 *
 * A value is an int32_t, in the steps of its unit that the core counts in. A set is checked against
 * its own range and against its neighbours (recover < throttle < shutdown, …); a refused set
 * changed nothing. Results tell which parameters changed, so that the caller can tell those
 * concerned.
 *
 * Context: the thread that owns it. Defaults come from Kconfig (CONFIG_PHAROS_…).
 */
#ifndef PHAROS_CORE_PARAMS_H
#define PHAROS_CORE_PARAMS_H

#include "core/arbiter.h"
#include "core/gimbal.h"
#include "core/illuminator.h"
#include "core/limits.h"
#include "core/params_table.h"
#include "core/security.h"
#include "core/sync.h"
#include "core/thermal.h"
#include "core/thruster.h"

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
	PARAM_GROUP_IMC,
	PARAM_GROUP_GIMBAL,
	PARAM_GROUP_OUTPUTS,
	PARAM_GROUP_COUNT
};

#define PARAMS_ID(name, group, unit, decimals, min, max, fallback, flags, meaning) PARAM_##name,
enum param_id {
	PARAMS_TABLE(PARAMS_ID) PARAM_COUNT
};
#undef PARAMS_ID

/*
 * name: 1…PARAMS_NAME_MAX characters A-Z 0-9 _, terminated. unit: what people read, value /
 * 10^decimals of it (param_units.h); "": a number or a choice, without decimals.
 */
struct param_info {
	const char *name;
	const char *unit;
#ifdef CONFIG_PHAROS_PARAM_MEANINGS
	const char *meaning;
#endif
	int32_t min;
	int32_t max;
	int32_t fallback; /* the default */
	uint8_t flags;
	uint8_t decimals; /* 0…6 */
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
	PARAMS_FORBIDDEN, /* to that source: security.h */
};

struct params {
	int32_t values[PARAM_COUNT];
};

#define PARAMS_SET_BITS  32u
#define PARAMS_SET_WORDS ((PARAM_COUNT + PARAMS_SET_BITS - 1) / PARAMS_SET_BITS)

/* A set of parameters, by index (asserted to be one). */
struct param_set {
	uint32_t words[PARAMS_SET_WORDS];
};

void param_set_add(struct param_set *self, uint32_t index);
void param_set_remove(struct param_set *self, uint32_t index);
bool param_set_has(const struct param_set *self, uint32_t index);
bool param_set_is_empty(const struct param_set *self);

/* All of *more too. */
void param_set_merge(struct param_set *self, const struct param_set *more);

/* Removes the first and returns its index; PARAM_COUNT: the set is empty. */
uint32_t param_set_take(struct param_set *self);

/* Is one of the group's in it? */
bool param_set_touches(const struct param_set *self, enum param_group group);

/* All defaults. */
void params_init(struct params *self);

/* NULL: index >= PARAM_COUNT. */
const struct param_info *params_info(uint32_t index);

/* Index of a name, which need not be terminated (length: without terminator); PARAM_COUNT: none. */
uint32_t params_find(const char *name, size_t length);

/* UNKNOWN: *value is untouched. */
enum params_result params_get(const struct params *self, uint32_t index, int32_t *value);

/* *changed: what changed; nothing when refused or when it was that value already. */
enum params_result params_set(struct params *self, uint32_t index, int32_t value,
                              struct param_set *changed);

/* A read-only one (asserted) is now this, within its range (asserted). */
void params_tell(struct params *self, enum param_id id, int32_t value);

/* Back to the defaults, except read-only ones. Returns what changed. */
struct param_set params_reset(struct params *self);

/* Is a lower value of it less heat? So of temperatures, levels and slew of the supervisor. */
bool params_is_heat_limit(uint32_t index);

/*
 * A whole stored set at once, so that no order of single sets matters; values may be self's own. A
 * set that was stored by this firmware is taken as it is. One of another firmware's table, or what
 * could be read of a damaged one, may have values that are out of range or at odds; then they are
 * mended, never towards more heat:
 *
 * - a limit of heat below its range becomes the lowest that there is; else what is out of range
 *   becomes its default;
 * - temperatures at odds: each limit becomes the lower of itself and its default, and colder than
 *   the limit above it (at the very end of the range by 2 mdegC warmer than itself); what the
 *   sensor may show becomes the default, or begins colder than the limits;
 * - others at odds with each other become their defaults.
 *
 * Read-only ones stay as they are. Returns what was mended.
 */
struct param_set params_load(struct params *self, const int32_t values[PARAM_COUNT]);

/* Those that can be set: what is worth storing. */
struct param_set params_settable(void);

/* What the modules take. */
void params_illuminator(const struct params *self, struct illuminator_config *config);
void params_thermal(const struct params *self, struct thermal_config *config);
void params_sync(const struct params *self, struct sync_config *config);
#ifdef CONFIG_PHAROS_IMC
void params_thruster(const struct params *self, struct thruster_config *config);
#endif
/* A source that is excluded has no priority. */
void params_arbiter(const struct params *self, struct arbiter_config *config);

/* What the security table takes of the parameters; has_key stays. */
void params_security(const struct params *self, struct security *security);

/* The right to change a parameter (asserted to be one): LOCK, SUPERVISION or PARAMS. */
enum security_right params_right(uint32_t index);
#ifdef CONFIG_PHAROS_GIMBAL
void params_gimbal(const struct params *self, struct gimbal_config *config);
#endif

#endif
