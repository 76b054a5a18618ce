/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When storage writes, and how often: each write wears the flash. Time is virtual; the store is the
 * native one, in memory, which counts the records that it was given.
 */
#include "threads/storage.h"

#include <errno.h>
#include <string.h>

#include <zephyr/settings/settings.h>
#include <zephyr/ztest.h>

#include "subsys/settings/settings_medium.h"
#include "subsys/settings/settings_store.h"

static struct params params;

void pharos_assert_failed(const char *file, int line)
{
	printk("assertion failed: %s:%d\n", file, line);
	k_oops();
	CODE_UNREACHABLE;
}

static uint32_t records(void)
{
	struct settings_store_status status;

	settings_store_status(&status);
	return status.stats.writes;
}

static void set(enum param_id id, int32_t value)
{
	struct param_set changed;

	zassert_equal(params_set(&params, id, value, &changed), PARAMS_OK);
	storage_save_params(&params, &changed);
}

static void set_brightness(uint32_t brightness_ppm)
{
	const struct illuminator_settings light = {
		.enable = true,
		.mode = ILLUMINATOR_MODE_INTERNAL,
		.brightness_ppm = brightness_ppm,
		.duty_ppm = PPM_ONE,
	};

	storage_save_light(&light);
}

/* As after a reset. */
static struct illuminator_settings stored_light(void)
{
	struct illuminator_settings light;
	struct params loaded;
	bool has_light;

	params_init(&loaded);
	zassert_equal(storage_load(&loaded, &light, &has_light), 0);
	zassert_true(has_light);
	return light;
}

static int32_t stored(enum param_id id)
{
	struct illuminator_settings light;
	struct params loaded;
	bool has_light;

	params_init(&loaded);
	zassert_equal(storage_load(&loaded, &light, &has_light), 0);
	return loaded.values[id];
}

static void *setup(void)
{
	struct illuminator_settings light;
	bool has_light;

	params_init(&params);
	zassert_equal(storage_load(&params, &light, &has_light), 0);
	storage_start();
	return NULL;
}

/* What earlier tests have written, and how often, is past. */
static void before(void *fixture)
{
	struct illuminator_settings light;
	bool has_light;

	k_sleep(K_HOURS(1));
	zassert_equal(settings_delete("pharos/0"), 0);
	zassert_equal(settings_delete("pharos/1"), 0);
	params_init(&params);
	zassert_equal(storage_load(&params, &light, &has_light), 0);
}

ZTEST_SUITE(storage, NULL, setup, before, NULL, NULL);

ZTEST(storage, test_light_is_stored_once_it_has_stood_for_a_second)
{
	const uint32_t first = records();

	set_brightness(100000);
	k_sleep(K_MSEC(400));
	set_brightness(200000);
	k_sleep(K_MSEC(990));
	zassert_equal(records(), first);
	k_sleep(K_MSEC(20));
	zassert_equal(records(), first + 1);
	zassert_equal(stored_light().brightness_ppm, 200000);
}

ZTEST(storage, test_light_that_never_stands_still_is_stored_twice_a_minute)
{
	const uint32_t first = records();

	for (uint32_t i = 0; i < 9000; i++) { /* an hour */
		set_brightness(i);
		k_sleep(K_MSEC(400));
	}
	zassert_within(records() - first, 119, 1);
}

ZTEST(storage, test_light_that_stands_still_at_times_is_stored_120_times_an_hour)
{
	const uint32_t first = records();

	for (uint32_t i = 0; i < 3000; i++) { /* an hour */
		set_brightness(i);
		k_sleep(K_MSEC(1200));
	}
	zassert_within(records() - first, 119, 1);
}

ZTEST(storage, test_parameter_does_not_wait_for_the_light)
{
	set_brightness(300000);
	k_sleep(K_MSEC(100));
	set(PARAM_STRB_MIN, 20000);
	k_sleep(K_MSEC(1));
	zassert_equal(stored(PARAM_STRB_MIN), 20000);
}

static int64_t ran_at_ms;

static void run(struct k_work *work)
{
	ran_at_ms = k_uptime_get();
}

/* A block of a firmware image is one. */
ZTEST(storage, test_work_of_others_does_not_wait_for_the_light)
{
	static K_WORK_DEFINE(work, run);
	const int64_t now_ms = k_uptime_get();

	set_brightness(400000);
	storage_submit(&work);
	k_sleep(K_MSEC(100));
	zassert_within(ran_at_ms, now_ms, 1);
}

/* --- what version 0.1 has stored: a value of its own for each --------------------------------- */

static const struct {
	const char *name;
	enum param_id id;
	int32_t value;
} old_params[] = {
	{"pharos/param/THR_RECOVER", PARAM_THR_RECOVER, 30000},
	{"pharos/param/THR_THROTTLE", PARAM_THR_THROTTLE, 40000},
	{"pharos/param/THR_SHUTDOWN", PARAM_THR_SHUTDOWN, 50000},
	{"pharos/param/CAN_LIGHT_ID", PARAM_CAN_LIGHT_ID, -1},
	{"pharos/param/LGT_LOSS_MS", PARAM_LGT_LOSS, 2500}, /* whose name has changed since */
};
/* 40 %, 0.5 s, 10 %, internal, on */
static const uint8_t old_light[16] = {0x80, 0x1a, 0x06, 0x00, 0x20, 0xa1, 0x07, 0x00,
                                      0xa0, 0x86, 0x01, 0x00, 1,    1,    0,    0};
static const uint8_t old_power = 0x0b;
static const struct mavlink_signing_record old_signing = {.timestamp = 1, .key = {2, 3, 4}};

static void put_old(void)
{
	zassert_equal(settings_delete("pharos/0"), 0);
	zassert_equal(settings_delete("pharos/1"), 0);
	for (size_t i = 0; i < ARRAY_SIZE(old_params); i++) {
		zassert_equal(settings_save_one(old_params[i].name, &old_params[i].value, 4), 0);
	}
	zassert_equal(settings_save_one("pharos/light", old_light, sizeof(old_light)), 0);
	zassert_equal(settings_save_one("pharos/power", &old_power, 1), 0);
	zassert_equal(settings_save_one("pharos/signing", &old_signing, sizeof(old_signing)), 0);
}

/* As after a reset. */
static void reset(void)
{
	settings_host_heal();
	settings_store_close();
	zassert_equal(settings_subsys_init(), 0);
}

static bool is_taken_over(void)
{
	struct mavlink_signing_record signing;
	struct illuminator_settings light;
	bool has_light;
	bool same = true;

	zassert_equal(storage_load(&params, &light, &has_light), 0);
	for (size_t i = 0; i < ARRAY_SIZE(old_params); i++) {
		same = same && params.values[old_params[i].id] == old_params[i].value;
	}
	storage_load_signing(&signing);
	return same && has_light && light.brightness_ppm == 400000 &&
	       light.strobe_period_us == 500000 && light.duty_ppm == 100000 && light.enable &&
	       storage_load_power(7) == old_power &&
	       memcmp(&signing, &old_signing, sizeof(signing)) == 0;
}

/* Nothing has changed, but what waits is looked after. */
static void let_it_write(void)
{
	const struct param_set nothing = {0};

	storage_save_params(&params, &nothing);
	k_sleep(K_MSEC(10));
}

static int count_names(const char *key, size_t length, settings_read_cb read, void *arg,
                       void *param)
{
	*(int *)param += key[1] == '\0' ? 0 : 1;
	return 0;
}

/* Of the earlier version. */
static int names_stored(void)
{
	int count = 0;

	zassert_equal(settings_load_subtree_direct("pharos", count_names, &count), 0);
	return count;
}

ZTEST(storage, test_values_of_an_earlier_version_become_a_record)
{
	put_old();
	zassert_true(is_taken_over());
	let_it_write();
	zassert_equal(names_stored(), 0);
	reset();
	zassert_true(is_taken_over());
}

ZTEST(storage, test_power_cut_at_any_byte_while_they_do)
{
	static const size_t words[] = {1, 8, 32};

	for (size_t i = 0; i < ARRAY_SIZE(words); i++) {
		int names = 0;
		int done = 0;

		for (uint64_t cut = 0; done < 40; cut++) {
			put_old();
			zassert_true(is_taken_over());
			settings_host_tear(cut, words[i]);
			let_it_write();
			reset();
			zassert_true(is_taken_over(), "cut after %d bytes", (int)cut);
			names = names_stored();
			/* And what was cut is taken up again, with the next write. */
			set(PARAM_SYNC_PULSE, params.values[PARAM_SYNC_PULSE] + 1);
			k_sleep(K_MSEC(10));
			zassert_equal(names_stored(), 0, "cut after %d bytes", (int)cut);
			done += names == 0 ? 1 : 0;
		}
	}
}

/* --- a store that is damaged ------------------------------------------------------------------ */

static void damage(const char *name)
{
	static const uint8_t garbage[] = "not a record";

	zassert_equal(settings_save_one(name, garbage, sizeof(garbage)), 0);
}

ZTEST(storage, test_of_two_records_the_one_that_reads_counts_and_the_other_is_replaced)
{
	set(PARAM_STRB_MIN, 20000);
	k_sleep(K_MSEC(10));
	set(PARAM_STRB_MIN, 30000);
	k_sleep(K_MSEC(10));
	damage("pharos/0");
	reset();

	const int32_t left = stored(PARAM_STRB_MIN);

	zassert_true(left == 20000 || left == 30000);
	let_it_write();
	damage("pharos/1");
	reset();
	zassert_equal(stored(PARAM_STRB_MIN), left);
	zassert_true(storage_stats_get().refused > 0);
}

ZTEST(storage, test_with_no_record_that_reads_the_defaults_apply)
{
	set(PARAM_STRB_MIN, 20000);
	k_sleep(K_MSEC(10));
	damage("pharos/0");
	damage("pharos/1");
	zassert_equal(stored(PARAM_STRB_MIN), CONFIG_PHAROS_STROBE_PERIOD_MIN_US);
	let_it_write();
	reset();
	zassert_equal(stored(PARAM_STRB_MIN), CONFIG_PHAROS_STROBE_PERIOD_MIN_US);
}

ZTEST(storage, test_a_write_that_fails_is_told_and_tried_again)
{
	const struct storage_stats first = storage_stats_get();

	settings_host_tear(0, 1);
	set(PARAM_STRB_MIN, 40000);
	k_sleep(K_MSEC(10));
	zassert_equal(storage_stats_get().failures, first.failures + 1);
	zassert_equal(storage_stats_get().last_error, -5); /* EIO */
	settings_host_heal();
	k_sleep(K_SECONDS(31));
	zassert_equal(storage_stats_get().failures, first.failures + 1);
	reset();
	zassert_equal(stored(PARAM_STRB_MIN), 40000);
}

static struct k_sem flash_answers;

static void wait_for_flash(struct k_work *work)
{
	(void)k_sem_take(&flash_answers, K_FOREVER);
}

/* The thread is the update's too: what waits behind a flash that never answers is told, once. */
ZTEST(storage, test_what_waits_behind_an_update_that_hangs_is_told)
{
	static struct k_work update = Z_WORK_INITIALIZER(wait_for_flash);
	const uint32_t failures = storage_stats_get().failures;

	k_sem_init(&flash_answers, 0, 1);
	storage_submit(&update);
	k_sleep(K_MSEC(1));
	set(PARAM_LGT_CURVE, params.values[PARAM_LGT_CURVE] == 0 ? 1 : 0);
	k_sleep(K_MSEC(STORAGE_WAIT_MS - 1));
	zassert_equal(storage_stats_get().failures, failures);
	k_sleep(K_MSEC(2));
	zassert_equal(storage_stats_get().failures, failures + 1);
	zassert_equal(storage_stats_get().last_error, -ETIMEDOUT);
	k_sleep(K_MSEC(STORAGE_WAIT_MS));
	zassert_equal(storage_stats_get().failures, failures + 1);

	k_sem_give(&flash_answers);
	k_sleep(K_MSEC(100));
	zassert_equal(stored(PARAM_LGT_CURVE), params.values[PARAM_LGT_CURVE]);
}
