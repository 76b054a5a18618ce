/* SPDX-License-Identifier: Apache-2.0 */
#include "core/params.h"

#include "core/assert.h"

#include <string.h>

#ifdef CONFIG_PHAROS_PARAM_MEANINGS
#define PARAMS_MEANING(meaning_) .meaning = (meaning_),
#else
#define PARAMS_MEANING(meaning_)
#endif

#define PARAMS_INFO(name_, group_, unit_, decimals_, min_, max_, fallback_, flags_, meaning_)      \
	[PARAM_##name_] = {                                                                        \
		.name = #name_,                                                                    \
		.unit = (unit_),                                                                   \
		.decimals = (decimals_),                                                           \
		PARAMS_MEANING(meaning_).min = (min_),                                             \
		.max = (max_),                                                                     \
		.fallback = (fallback_),                                                           \
		.flags = (flags_),                                                                 \
		.group = PARAM_GROUP_##group_,                                                     \
	},
static const struct param_info table[PARAM_COUNT] = {PARAMS_TABLE(PARAMS_INFO)};
#undef PARAMS_INFO
#undef PARAMS_MEANING

#define PARAMS_CHECK(name, group, unit, decimals, min, max, fallback, flags, meaning)              \
	_Static_assert((min) <= (fallback) && (fallback) <= (max),                                 \
	               #name ": default within range");                                            \
	_Static_assert(sizeof(#name) - 1 <= PARAMS_NAME_MAX, #name ": name fits");                 \
	_Static_assert((decimals) <= 6 && (sizeof(unit) > 1 || (decimals) == 0),                   \
	               #name ": a choice has no decimals");                                        \
	_Static_assert((min) > -(1 << 24) && (max) < 1 << 24, #name ": a binary32 holds it");
PARAMS_TABLE(PARAMS_CHECK)
#undef PARAMS_CHECK

#define US_PER_MIN (60u * US_PER_S)

/* values[less] < values[more], or <= where equal is allowed. */
struct rule {
	enum param_id less;
	enum param_id more;
	bool equal;
};

static const struct rule rules[] = {
	{PARAM_STRB_MIN, PARAM_STRB_MAX, true},
	{PARAM_THR_SENS_MIN, PARAM_THR_RECOVER, false},
	{PARAM_THR_RECOVER, PARAM_THR_THROTTLE, false},
	{PARAM_THR_THROTTLE, PARAM_THR_SHUTDOWN, false},
	/* Else overheating would count as implausible, and only limit the lamp. */
	{PARAM_THR_SHUTDOWN, PARAM_THR_SENS_MAX, false},
#ifdef CONFIG_PHAROS_GIMBAL
	{PARAM_GMB_PAN_MIN, PARAM_GMB_PAN_MAX, false},
	{PARAM_GMB_TLT_MIN, PARAM_GMB_TLT_MAX, false},
#endif
};
#define RULES (sizeof(rules) / sizeof(rules[0]))

_Static_assert(CONFIG_PHAROS_STROBE_PERIOD_MIN_US <= CONFIG_PHAROS_STROBE_PERIOD_MAX_US,
               "default strobe periods");
_Static_assert(CONFIG_PHAROS_THERMAL_SENSOR_MIN_MDEGC < CONFIG_PHAROS_THERMAL_RECOVER_MDEGC &&
                       CONFIG_PHAROS_THERMAL_RECOVER_MDEGC < CONFIG_PHAROS_THERMAL_THROTTLE_MDEGC &&
                       CONFIG_PHAROS_THERMAL_THROTTLE_MDEGC <
                               CONFIG_PHAROS_THERMAL_SHUTDOWN_MDEGC &&
                       CONFIG_PHAROS_THERMAL_SHUTDOWN_MDEGC <
                               CONFIG_PHAROS_THERMAL_SENSOR_MAX_MDEGC,
               "default temperatures");

#ifdef CONFIG_PHAROS_GIMBAL
_Static_assert(CONFIG_PHAROS_GIMBAL_PAN_MIN_MDEG < CONFIG_PHAROS_GIMBAL_PAN_MAX_MDEG &&
                       CONFIG_PHAROS_GIMBAL_TILT_MIN_MDEG < CONFIG_PHAROS_GIMBAL_TILT_MAX_MDEG,
               "default limits of the gimbal");
#endif

static bool holds(const struct rule *rule, int32_t less, int32_t more)
{
	return less < more || (rule->equal && less == more);
}

static bool in_range(uint32_t index, int32_t value)
{
	return value >= table[index].min && value <= table[index].max;
}

static bool is_read_only(uint32_t index)
{
	return (table[index].flags & PARAM_FLAG_READ_ONLY) != 0;
}

void params_init(struct params *self)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		self->values[i] = table[i].fallback;
	}
}

const struct param_info *params_info(uint32_t index)
{
	return (index < PARAM_COUNT) ? &table[index] : NULL;
}

uint32_t params_find(const char *name, size_t length)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (strlen(table[i].name) == length && memcmp(table[i].name, name, length) == 0) {
			return i;
		}
	}
	return PARAM_COUNT;
}

enum params_result params_get(const struct params *self, uint32_t index, int32_t *value)
{
	if (index >= PARAM_COUNT) {
		return PARAMS_UNKNOWN;
	}
	*value = self->values[index];
	return PARAMS_OK;
}

static enum params_result decide(const struct params *self, uint32_t index, int32_t value)
{
	if (index >= PARAM_COUNT) {
		return PARAMS_UNKNOWN;
	}
	if (is_read_only(index)) {
		return PARAMS_READ_ONLY;
	}
	if (!in_range(index, value)) {
		return PARAMS_OUT_OF_RANGE;
	}
	for (uint32_t i = 0; i < RULES; i++) {
		const struct rule *const rule = &rules[i];
		const int32_t less = rule->less == index ? value : self->values[rule->less];
		const int32_t more = rule->more == index ? value : self->values[rule->more];

		if (!holds(rule, less, more)) {
			return PARAMS_CONFLICT;
		}
	}
	return PARAMS_OK;
}

enum params_result params_set(struct params *self, uint32_t index, int32_t value,
                              struct param_set *changed)
{
	const enum params_result result = decide(self, index, value);

	*changed = (struct param_set){0};
	if (result == PARAMS_OK && self->values[index] != value) {
		self->values[index] = value;
		param_set_add(changed, index);
	}
	return result;
}

static void to_default(struct params *self, uint32_t index, struct param_set *changed)
{
	if (self->values[index] != table[index].fallback) {
		self->values[index] = table[index].fallback;
		param_set_add(changed, index);
	}
}

void params_tell(struct params *self, enum param_id id, int32_t value)
{
	PHAROS_ASSERT(is_read_only(id) && in_range(id, value));
	self->values[id] = value;
}

struct param_set params_reset(struct params *self)
{
	struct param_set changed = {0};

	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (!is_read_only(i)) {
			to_default(self, i, &changed);
		}
	}
	return changed;
}

bool params_is_heat_limit(uint32_t index)
{
	return index == PARAM_THR_SHUTDOWN || index == PARAM_THR_THROTTLE ||
	       index == PARAM_THR_RECOVER || index == PARAM_THR_FLOOR || index == PARAM_THR_SAFE ||
	       index == PARAM_THR_SLEW;
}

static int32_t lower(int32_t a, int32_t b)
{
	return a < b ? a : b;
}

static int32_t higher(int32_t a, int32_t b)
{
	return a > b ? a : b;
}

static void mend(struct params *self, uint32_t index, int32_t value, struct param_set *mended)
{
	if (self->values[index] != value) {
		self->values[index] = value;
		param_set_add(mended, index);
	}
}

static void mend_range(struct params *self, uint32_t index, struct param_set *mended)
{
	const struct param_info *const info = &table[index];

	if (!in_range(index, self->values[index])) {
		mend(self, index,
		     params_is_heat_limit(index) && self->values[index] < info->min
		             ? info->min
		             : info->fallback,
		     mended);
	}
}

/* Temperatures that contradict each other: none of them higher than its default, and each of the
 * limits that a warmer one contradicts is colder than that.
 */
static void mend_temperatures(struct params *self, struct param_set *mended)
{
	const int32_t *const values = self->values;
	/* The three have the same range, and shall have room in it. */
	const int32_t coldest = table[PARAM_THR_RECOVER].min;
	const int32_t shutdown =
		lower(values[PARAM_THR_SHUTDOWN], table[PARAM_THR_SHUTDOWN].fallback);
	const int32_t throttle =
		lower(values[PARAM_THR_THROTTLE], table[PARAM_THR_THROTTLE].fallback);
	const int32_t recover = lower(values[PARAM_THR_RECOVER], table[PARAM_THR_RECOVER].fallback);

	mend(self, PARAM_THR_SENS_MAX, table[PARAM_THR_SENS_MAX].fallback, mended);
	mend(self, PARAM_THR_SHUTDOWN, higher(shutdown, coldest + 2), mended);
	mend(self, PARAM_THR_THROTTLE,
	     higher(lower(throttle, values[PARAM_THR_SHUTDOWN] - 1), coldest + 1), mended);
	mend(self, PARAM_THR_RECOVER, lower(recover, values[PARAM_THR_THROTTLE] - 1), mended);
	mend(self, PARAM_THR_SENS_MIN,
	     lower(table[PARAM_THR_SENS_MIN].fallback, values[PARAM_THR_RECOVER] - 1), mended);
}

struct param_set params_load(struct params *self, const int32_t values[PARAM_COUNT])
{
	struct param_set mended = {0};

	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (!is_read_only(i)) {
			self->values[i] = values[i];
			mend_range(self, i, &mended);
		}
	}
	for (uint32_t i = 0; i < RULES; i++) {
		const struct rule *const rule = &rules[i];

		if (holds(rule, self->values[rule->less], self->values[rule->more])) {
			continue;
		}
		if (table[rule->less].group == PARAM_GROUP_THERMAL) {
			mend_temperatures(self, &mended);
		} else {
			mend(self, rule->less, table[rule->less].fallback, &mended);
			mend(self, rule->more, table[rule->more].fallback, &mended);
		}
	}
	return mended;
}

struct param_set params_settable(void)
{
	struct param_set set = {0};

	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (!is_read_only(i)) {
			param_set_add(&set, i);
		}
	}
	return set;
}

void param_set_add(struct param_set *self, uint32_t index)
{
	PHAROS_ASSERT(index < PARAM_COUNT);
	self->words[index / PARAMS_SET_BITS] |= 1u << index % PARAMS_SET_BITS;
}

void param_set_remove(struct param_set *self, uint32_t index)
{
	PHAROS_ASSERT(index < PARAM_COUNT);
	self->words[index / PARAMS_SET_BITS] &= ~(1u << index % PARAMS_SET_BITS);
}

bool param_set_has(const struct param_set *self, uint32_t index)
{
	PHAROS_ASSERT(index < PARAM_COUNT);
	return (self->words[index / PARAMS_SET_BITS] & 1u << index % PARAMS_SET_BITS) != 0;
}

bool param_set_is_empty(const struct param_set *self)
{
	for (uint32_t i = 0; i < PARAMS_SET_WORDS; i++) {
		if (self->words[i] != 0) {
			return false;
		}
	}
	return true;
}

void param_set_merge(struct param_set *self, const struct param_set *more)
{
	for (uint32_t i = 0; i < PARAMS_SET_WORDS; i++) {
		self->words[i] |= more->words[i];
	}
}

uint32_t param_set_take(struct param_set *self)
{
	for (uint32_t word = 0; word < PARAMS_SET_WORDS; word++) {
		if (self->words[word] != 0) {
			uint32_t index = word * PARAMS_SET_BITS;

			while (!param_set_has(self, index)) {
				index++;
			}
			param_set_remove(self, index);
			return index;
		}
	}
	return PARAM_COUNT;
}

bool param_set_touches(const struct param_set *self, enum param_group group)
{
	struct param_set rest = *self;
	uint32_t index;

	while ((index = param_set_take(&rest)) < PARAM_COUNT) {
		if (table[index].group == group) {
			return true;
		}
	}
	return false;
}

static uint32_t unsigned_value(const struct params *self, enum param_id id)
{
	PHAROS_ASSERT(self->values[id] >= 0);
	return (uint32_t)self->values[id];
}

static uint32_t ms_as_us(const struct params *self, enum param_id id)
{
	return unsigned_value(self, id) * US_PER_MS;
}

static struct program program_of(const struct params *self)
{
	const enum program_kind kind = (enum program_kind)self->values[PARAM_LGT_PROGRAM];
	struct program program = {.kind = kind};

	switch (kind) {
	case PROGRAM_NONE:
		break;
	case PROGRAM_ANTI_COLLISION:
	case PROGRAM_DOUBLE_FLASH:
		program.period_us = US_PER_MIN / unsigned_value(self, PARAM_PRG_RATE);
		program.unit_us = ms_as_us(self, PARAM_PRG_FLASH);
		break;
	case PROGRAM_FADE:
		program.period_us = ms_as_us(self, PARAM_PRG_FADE);
		break;
	case PROGRAM_SOS:
		program.unit_us = ms_as_us(self, PARAM_PRG_DOT);
		break;
	}
	return program;
}

void params_illuminator(const struct params *self, struct illuminator_config *config)
{
	*config = (struct illuminator_config){
		.min_period_us = unsigned_value(self, PARAM_STRB_MIN),
		.max_period_us = unsigned_value(self, PARAM_STRB_MAX),
		.curve = (enum illuminator_curve)self->values[PARAM_LGT_CURVE],
		.beacon =
			{
				.period_us = unsigned_value(self, PARAM_BCN_PERIOD),
				.duty_ppm = unsigned_value(self, PARAM_BCN_DUTY),
				.brightness_ppm = unsigned_value(self, PARAM_BCN_BRIGHT),
			},
		.program = program_of(self),
	};
}

void params_thermal(const struct params *self, struct thermal_config *config)
{
	*config = (struct thermal_config){
		.throttle_mdegc = self->values[PARAM_THR_THROTTLE],
		.shutdown_mdegc = self->values[PARAM_THR_SHUTDOWN],
		.recover_mdegc = self->values[PARAM_THR_RECOVER],
		.hysteresis_mdegc = self->values[PARAM_THR_HYST],
		.min_mdegc = self->values[PARAM_THR_SENS_MIN],
		.max_mdegc = self->values[PARAM_THR_SENS_MAX],
		.noise_mdegc = self->values[PARAM_THR_NOISE],
		.max_rate_mdegc_per_s = unsigned_value(self, PARAM_THR_RATE),
		.floor_ppm = unsigned_value(self, PARAM_THR_FLOOR),
		.safe_ppm = unsigned_value(self, PARAM_THR_SAFE),
		.hot_ppm = unsigned_value(self, PARAM_THR_HOT),
		.slew_ppm_per_s = unsigned_value(self, PARAM_THR_SLEW),
		.first_us = ms_as_us(self, PARAM_THR_FIRST),
		.stuck_us = ms_as_us(self, PARAM_THR_STUCK),
		.missing_us = ms_as_us(self, PARAM_THR_MISS),
		.good_samples = unsigned_value(self, PARAM_THR_GOOD_N),
	};
}

void params_sync(const struct params *self, struct sync_config *config)
{
	*config = (struct sync_config){
		.mode = (enum sync_mode)self->values[PARAM_SYNC_MODE],
		.polarity = (enum sync_polarity)self->values[PARAM_SYNC_POL],
		.retrigger = (enum sync_retrigger)self->values[PARAM_SYNC_RETRIG],
		.policy = (enum sync_policy)self->values[PARAM_SYNC_LOSS],
		.filter_us = unsigned_value(self, PARAM_SYNC_FILT),
		.pulse_us = unsigned_value(self, PARAM_SYNC_PULSE),
		.timeout_us = ms_as_us(self, PARAM_SYNC_TMO),
	};
}

#ifdef CONFIG_PHAROS_IMC
void params_thruster(const struct params *self, struct thruster_config *config)
{
	*config = (struct thruster_config){
		.min_us = unsigned_value(self, PARAM_ESC_MIN),
		.max_us = unsigned_value(self, PARAM_ESC_MAX),
		.arm_us = ms_as_us(self, PARAM_ESC_ARM),
		.loss_us = ms_as_us(self, PARAM_ESC_LOSS),
	};
}
#endif

void params_arbiter(const struct params *self, struct arbiter_config *config)
{
	const enum arbiter_source priority = (enum arbiter_source)self->values[PARAM_LGT_SRC_PRIO];
	const bool is_excluded =
		priority != ARBITER_SOURCE_NONE &&
		(unsigned_value(self, PARAM_LGT_SRC_EXCL) & ARBITER_SOURCE_BIT(priority)) != 0;

	*config = (struct arbiter_config){
		.priority = is_excluded ? ARBITER_SOURCE_NONE : priority,
		.fallback = (enum illuminator_fallback)self->values[PARAM_LGT_FALLBACK],
		.hold_us = ms_as_us(self, PARAM_LGT_SRC_HOLD),
		.loss_us = ms_as_us(self, PARAM_LGT_LOSS),
	};
}

void params_security(const struct params *self, struct security *security)
{
	security->excluded = unsigned_value(self, PARAM_LGT_SRC_EXCL);
#ifdef CONFIG_PHAROS_SIGNING
	security->dronecan = (enum security_grant)self->values[PARAM_MAV_KEY_CAN];
#ifdef CONFIG_PHAROS_IMC
	security->imc = (enum security_grant)self->values[PARAM_MAV_KEY_IMC];
#endif
#endif
}

static bool is_lock(uint32_t index)
{
#ifdef CONFIG_PHAROS_SIGNING
	if (index == PARAM_MAV_SECURE || index == PARAM_MAV_KEY_CAN) {
		return true;
	}
#ifdef CONFIG_PHAROS_IMC
	if (index == PARAM_MAV_KEY_IMC) {
		return true;
	}
#endif
#endif
	return index == PARAM_LGT_SRC_EXCL;
}

enum security_right params_right(uint32_t index)
{
	PHAROS_ASSERT(index < PARAM_COUNT);
	if (is_lock(index)) {
		return SECURITY_LOCK;
	}
	switch (table[index].group) {
	case PARAM_GROUP_LIGHT:
	case PARAM_GROUP_SYNC:
	case PARAM_GROUP_GIMBAL:
	case PARAM_GROUP_OUTPUTS:
		return SECURITY_PARAMS;
	case PARAM_GROUP_THERMAL:
	case PARAM_GROUP_ARBITER:
	case PARAM_GROUP_MAVLINK:
	case PARAM_GROUP_DRONECAN:
	case PARAM_GROUP_IMC:
	case PARAM_GROUP_COUNT:
		break;
	}
	return SECURITY_SUPERVISION;
}

#ifdef CONFIG_PHAROS_GIMBAL
void params_gimbal(const struct params *self, struct gimbal_config *config)
{
	const int32_t *const values = self->values;

	*config = (struct gimbal_config){
		.axes =
			{
				[GIMBAL_PAN] =
					{
						.min_mdeg = values[PARAM_GMB_PAN_MIN],
						.max_mdeg = values[PARAM_GMB_PAN_MAX],
						.neutral_mdeg = values[PARAM_GMB_PAN_NEUT],
						.retract_mdeg = values[PARAM_GMB_PAN_RETR],
						.rate_mdeg_per_s = values[PARAM_GMB_PAN_RATE],
						.pulse_min_us = values[PARAM_GMB_PAN_PW_MIN],
						.pulse_max_us = values[PARAM_GMB_PAN_PW_MAX],
						.trim_us = values[PARAM_GMB_PAN_TRIM],
					},
				[GIMBAL_TILT] =
					{
						.min_mdeg = values[PARAM_GMB_TLT_MIN],
						.max_mdeg = values[PARAM_GMB_TLT_MAX],
						.neutral_mdeg = values[PARAM_GMB_TLT_NEUT],
						.retract_mdeg = values[PARAM_GMB_TLT_RETR],
						.rate_mdeg_per_s = values[PARAM_GMB_TLT_RATE],
						.pulse_min_us = values[PARAM_GMB_TLT_PW_MIN],
						.pulse_max_us = values[PARAM_GMB_TLT_PW_MAX],
						.trim_us = values[PARAM_GMB_TLT_TRIM],
					},
			},
		.rate_timeout_us = ms_as_us(self, PARAM_GMB_RATE_TMO),
		.attitude_timeout_us = ms_as_us(self, PARAM_GMB_ATT_TMO),
	};
}
#endif
