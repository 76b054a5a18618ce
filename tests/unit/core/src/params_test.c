/* SPDX-License-Identifier: Apache-2.0 */
#include "core/params.h"

#include <string.h>

#include <zephyr/ztest.h>

static struct params params;
static struct param_set changed;

static void before(void *fixture)
{
	params_init(&params);
	memset(&changed, 0xFF, sizeof(changed));
}

ZTEST_SUITE(core_params, NULL, NULL, before, NULL, NULL);

static enum params_result set(const char *name, int32_t value)
{
	return params_set(&params, params_find(name, strlen(name)), value, &changed);
}

/* The set holds these and nothing else. */
static bool is_just(struct param_set set, const uint32_t *indices, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		if (param_set_take(&set) != indices[i]) {
			return false;
		}
	}
	return param_set_is_empty(&set);
}

static int32_t get(const char *name)
{
	int32_t value = -1;

	zassert_equal(params_get(&params, params_find(name, strlen(name)), &value), PARAMS_OK);
	return value;
}

static bool is_read_only(uint32_t index)
{
	return (params_info(index)->flags & PARAM_FLAG_READ_ONLY) != 0;
}

/* MAVLink reference: names of at most 16 characters; DroneCAN and the shell want them plain. */
ZTEST(core_params, test_every_row_is_complete_and_its_name_is_unique)
{
	static const char *const prefixes[] = {"LGT_", "STRB_", "THR_",  "SYNC_", "MAV_",
	                                       "CAN_", "IMC_",  "UART",  "GMB_",  "BCN_",
	                                       "PRG_", "ESC_",  "ZOOM_", "DOWN_"};

	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const struct param_info *info = params_info(i);
		bool prefixed = false;

		zassert_true(strlen(info->name) <= 16, "%s", info->name);
		zassert_equal(strspn(info->name, "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_"),
		              strlen(info->name), "%s", info->name);
		for (size_t p = 0; p < ARRAY_SIZE(prefixes); p++) {
			prefixed |= strncmp(info->name, prefixes[p], strlen(prefixes[p])) == 0;
		}
		zassert_true(prefixed, "%s", info->name);
		zassert_true(strlen(info->meaning) > 0, "%s", info->name);
		zassert_equal(params_find(info->name, strlen(info->name)), i, "%s", info->name);
	}
	zassert_is_null(params_info(PARAM_COUNT));
}

ZTEST(core_params, test_defaults_are_kconfig_values_and_can_all_be_set)
{
	zassert_equal(get("STRB_MIN"), CONFIG_PHAROS_STROBE_PERIOD_MIN_US);
	zassert_equal(get("THR_SHUTDOWN"), CONFIG_PHAROS_THERMAL_SHUTDOWN_MDEGC);
	zassert_equal(get("MAV_COMPID"), 243); /* MAV_COMP_ID_ILLUMINATOR */
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const enum params_result result =
			params_set(&params, i, params_info(i)->fallback, &changed);

		zassert_equal(result, is_read_only(i) ? PARAMS_READ_ONLY : PARAMS_OK);
		zassert_true(param_set_is_empty(&changed), "it was that already");
	}
}

ZTEST(core_params, test_set_tells_what_changed)
{
	zassert_equal(set("SYNC_MODE", 1), PARAMS_OK);
	zassert_true(is_just(changed, &(const uint32_t){PARAM_SYNC_MODE}, 1));
	zassert_equal(get("SYNC_MODE"), 1);
	zassert_equal(set("SYNC_MODE", 1), PARAMS_OK);
	zassert_true(param_set_is_empty(&changed));
}

ZTEST(core_params, test_unknown_names_and_indices)
{
	int32_t value = 77;

	zassert_equal(params_get(&params, PARAM_COUNT, &value), PARAMS_UNKNOWN);
	zassert_equal(value, 77);
	zassert_equal(params_set(&params, UINT32_MAX, 0, &changed), PARAMS_UNKNOWN);
	zassert_true(param_set_is_empty(&changed));
	zassert_equal(set("SYNC_MOD", 1), PARAMS_UNKNOWN);
	zassert_equal(set("SYNC_MODE_", 1), PARAMS_UNKNOWN);
	zassert_equal(set("", 1), PARAMS_UNKNOWN);
	/* PARAM_SET carries 16 bytes without a terminator. */
	zassert_equal(params_find("SYNC_MODExxxxxxx", 9), PARAM_SYNC_MODE);
}

ZTEST(core_params, test_each_range_is_closed)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const struct param_info *info = params_info(i);
		const struct params kept = params;

		if (is_read_only(i)) {
			continue;
		}
		if (info->min > INT32_MIN) {
			zassert_equal(params_set(&params, i, info->min - 1, &changed),
			              PARAMS_OUT_OF_RANGE, "%s", info->name);
		}
		if (info->max < INT32_MAX) {
			zassert_equal(params_set(&params, i, info->max + 1, &changed),
			              PARAMS_OUT_OF_RANGE, "%s", info->name);
		}
		zassert_true(param_set_is_empty(&changed));
		zassert_mem_equal(&params, &kept, sizeof(kept));
	}
	zassert_equal(set("SYNC_FILT", 0), PARAMS_OK);
	zassert_equal(set("SYNC_FILT", 1000000), PARAMS_OK);
}

ZTEST(core_params, test_temperatures_stay_in_order)
{
	const int32_t recover = get("THR_RECOVER");
	const int32_t throttle = get("THR_THROTTLE");
	const int32_t shutdown = get("THR_SHUTDOWN");
	const int32_t top = get("THR_SENS_MAX");

	zassert_equal(set("THR_RECOVER", throttle), PARAMS_CONFLICT);
	zassert_true(param_set_is_empty(&changed));
	zassert_equal(set("THR_RECOVER", throttle - 1), PARAMS_OK);
	zassert_equal(set("THR_RECOVER", recover), PARAMS_OK);
	zassert_equal(set("THR_THROTTLE", shutdown), PARAMS_CONFLICT);
	zassert_equal(set("THR_THROTTLE", recover), PARAMS_CONFLICT);
	zassert_equal(set("THR_SHUTDOWN", throttle), PARAMS_CONFLICT);
	zassert_equal(set("THR_SHUTDOWN", top), PARAMS_CONFLICT);
	zassert_equal(set("THR_SENS_MAX", shutdown), PARAMS_CONFLICT);
	zassert_equal(set("THR_SENS_MIN", recover), PARAMS_CONFLICT);
	zassert_equal(get("THR_THROTTLE"), throttle);
	zassert_equal(get("THR_SHUTDOWN"), shutdown);
}

ZTEST(core_params, test_strobe_periods_stay_in_order_and_may_be_equal)
{
	const int32_t max = get("STRB_MAX");

	zassert_equal(set("STRB_MIN", max), PARAMS_OK);
	zassert_equal(set("STRB_MIN", max + 1), PARAMS_CONFLICT);
	zassert_equal(set("STRB_MAX", max - 1), PARAMS_CONFLICT);
}

ZTEST(core_params, test_reset_tells_what_changed)
{
	static const uint32_t both[] = {PARAM_LGT_CURVE, PARAM_SYNC_MODE};

	zassert_true(is_just(params_reset(&params), NULL, 0));
	set("SYNC_MODE", 1);
	set("LGT_CURVE", 0);
	zassert_true(is_just(params_reset(&params), both, 2));
	zassert_equal(get("SYNC_MODE"), 0);
}

/* Issue "CAN and GPIO" 4: who is in command shows in a parameter. */
ZTEST(core_params, test_read_only_one_is_told_not_set_reset_or_loaded)
{
	const struct param_set settable = params_settable();
	struct params stored = params;

	params_tell(&params, PARAM_LGT_SRC_NOW, ARBITER_SOURCE_DRONECAN);
	zassert_equal(get("LGT_SRC_NOW"), 2);
	zassert_equal(set("LGT_SRC_NOW", 1), PARAMS_READ_ONLY);
	zassert_true(is_just(params_reset(&params), NULL, 0));
	stored.values[PARAM_LGT_SRC_NOW] = 4;
	zassert_true(is_just(params_load(&params, stored.values), NULL, 0));
	zassert_equal(get("LGT_SRC_NOW"), 2);
	zassert_false(param_set_has(&settable, PARAM_LGT_SRC_NOW));
	zassert_true(param_set_has(&settable, PARAM_LGT_SRC_PRIO));
}

ZTEST(core_params, test_load_takes_a_set_that_no_order_of_single_sets_would)
{
	struct params stored = params;

	stored.values[PARAM_THR_RECOVER] = 110000;
	stored.values[PARAM_THR_THROTTLE] = 120000;
	stored.values[PARAM_THR_SHUTDOWN] = 130000;
	zassert_true(is_just(params_load(&params, stored.values), NULL, 0));
	zassert_equal(get("THR_RECOVER"), 110000);
}

ZTEST(core_params, test_load_mends_what_is_out_of_range_or_at_odds)
{
	static const uint32_t bad[] = {PARAM_THR_RECOVER, PARAM_SYNC_MODE};
	struct params stored = params;

	stored.values[PARAM_SYNC_MODE] = 2;
	stored.values[PARAM_LGT_CURVE] = 0;
	stored.values[PARAM_THR_RECOVER] = 100000; /* above the default throttle */
	zassert_true(is_just(params_load(&params, stored.values), bad, 2));
	zassert_equal(get("LGT_CURVE"), 0, "the good ones are kept");
	zassert_equal(get("THR_RECOVER"), CONFIG_PHAROS_THERMAL_RECOVER_MDEGC);
}

/* What is mended is never mended towards more heat. */
ZTEST(core_params, test_load_mends_temperatures_downwards)
{
	static const struct {
		int32_t stored[5]; /* sensor min, recover, throttle, shutdown, sensor max */
		int32_t loaded[5];
	} rows[] = {
		/* stored by the firmware before records: the cut left half of 30/40/50 -> 55/60/65
	         */
		{{-55000, 55000, 40000, 50000, 150000}, {-55000, 39999, 40000, 50000, 150000}},
		{{-55000, 30000, 60000, 50000, 150000}, {-55000, 30000, 49999, 50000, 150000}},
		{{-55000, 30000, 40000, 35000, 150000}, {-55000, 30000, 34999, 35000, 150000}},
		/* higher than the defaults, 70/80/100 */
		{{-55000, 90000, 120000, 110000, 150000}, {-55000, 70000, 80000, 100000, 150000}},
		/* out of range: below is the lowest, above the default */
		{{-55000, 30000, 40000, -50000, 150000}, {-55000, -40000, -39999, -39998, 150000}},
		{{-55000, 30000, 40000, 200000, 150000}, {-55000, 30000, 40000, 100000, 150000}},
		/* a sensor that could show none of them */
		{{50000, 30000, 40000, 50000, 150000}, {-55000, 30000, 40000, 50000, 150000}},
		{{-55000, 30000, 40000, 50000, 45000}, {-55000, 30000, 40000, 50000, 150000}},
	};
	static const enum param_id ids[] = {PARAM_THR_SENS_MIN, PARAM_THR_RECOVER,
	                                    PARAM_THR_THROTTLE, PARAM_THR_SHUTDOWN,
	                                    PARAM_THR_SENS_MAX};

	for (size_t row = 0; row < ARRAY_SIZE(rows); row++) {
		struct params stored = params;

		for (size_t i = 0; i < ARRAY_SIZE(ids); i++) {
			stored.values[ids[i]] = rows[row].stored[i];
		}
		(void)params_load(&params, stored.values);
		for (size_t i = 0; i < ARRAY_SIZE(ids); i++) {
			zassert_equal(params.values[ids[i]], rows[row].loaded[i], "row %zu, %s: %d",
			              row, params_info(ids[i])->name, params.values[ids[i]]);
		}
	}
}

/* Than what was stored, or the default where that is lower; the coldest that there is stays. */
static bool is_no_warmer(const struct params *stored)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		const struct param_info *const info = params_info(i);
		const int32_t value = params.values[i];

		if (params_is_heat_limit(i) && value > info->min + 2 && value > stored->values[i]) {
			return false;
		}
	}
	return true;
}

ZTEST(core_params, test_any_garbage_loads_as_something_that_works)
{
	uint32_t random = 12345;

	for (int round = 0; round < 2000; round++) {
		struct params stored;
		struct thermal_config thermal;
		struct illuminator_config light;
		static struct thermal machine;
		static struct illuminator illuminator;
		static struct gimbal gimbal;
		struct gimbal_config axes;

		for (uint32_t i = 0; i < PARAM_COUNT; i++) {
			const struct param_info *info = params_info(i);
			const int64_t span = (int64_t)info->max - info->min + 1;

			random = random * 1664525u + 1013904223u; /* Numerical Recipes */
			stored.values[i] = (random & 0xF00) ? (int32_t)(info->min + random % span)
			                                    : (int32_t)random;
		}
		params_load(&params, stored.values);
		zassert_true(is_no_warmer(&stored), "round %d", round);
		params_thermal(&params, &thermal);
		params_illuminator(&params, &light);
		params_gimbal(&params, &axes);
		thermal_init(&machine, 0, &thermal); /* these assert their ranges */
		illuminator_init(&illuminator, &light);
		gimbal_init(&gimbal, 0, &axes);
		for (uint32_t i = 0; i < PARAM_COUNT; i++) {
			zassert_equal(params_set(&params, i, params.values[i], &changed),
			              is_read_only(i) ? PARAMS_READ_ONLY : PARAMS_OK,
			              "round %d, %s", round, params_info(i)->name);
		}
	}
}

ZTEST(core_params, test_each_touches_its_group_only)
{
	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		struct param_set set = {0};

		param_set_add(&set, i);
		for (int group = 0; group < PARAM_GROUP_COUNT; group++) {
			zassert_equal(param_set_touches(&set, group),
			              group == (int)params_info(i)->group);
		}
	}
	zassert_equal(params_info(PARAM_SYNC_POL)->group, PARAM_GROUP_SYNC);
}

ZTEST(core_params, test_a_set_gives_back_what_was_added)
{
	struct param_set set = {0};
	struct param_set more = {0};

	zassert_equal(param_set_take(&set), PARAM_COUNT);
	param_set_add(&set, 0);
	param_set_add(&more, 31);
	param_set_add(&more, 32); /* the next word */
	param_set_add(&more, PARAM_COUNT - 1);
	param_set_merge(&set, &more);
	zassert_true(is_just(set, (const uint32_t[]){0, 31, 32, PARAM_COUNT - 1}, 4));
}

ZTEST(core_params, test_modules_get_their_units)
{
	struct sync_config sync;
	struct arbiter_config arbiter;

	set("SYNC_TMO", 3600000);
	set("SYNC_LOSS", 2);
	set("LGT_SRC_PRIO", 4);
	set("LGT_SRC_HOLD", 1500);
	params_sync(&params, &sync);
	params_arbiter(&params, &arbiter);
	zassert_equal(sync.timeout_us, 3600000000u);
	zassert_equal(sync.policy, SYNC_POLICY_INTERNAL);
	zassert_equal(arbiter.priority, ARBITER_SOURCE_SHELL);
	zassert_equal(arbiter.hold_us, 1500000);
	set("LGT_SRC_EXCL", 7); /* all but the shell */
	params_arbiter(&params, &arbiter);
	zassert_equal(arbiter.priority, ARBITER_SOURCE_SHELL);
	set("LGT_SRC_EXCL", 8);
	params_arbiter(&params, &arbiter);
	zassert_equal(arbiter.priority, ARBITER_SOURCE_NONE, "who is excluded holds no one off");
}
