/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When storage writes, and how often: each write wears the flash. Time is virtual; the store is the
 * native one, in memory, which counts the records that it was given.
 */
#include "threads/storage.h"

#include <string.h>

#include <zephyr/settings/settings.h>
#include <zephyr/ztest.h>

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
	k_sleep(K_HOURS(1));
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
	set(PARAM_STRB_MIN_US, 20000);
	k_sleep(K_MSEC(1));
	zassert_equal(stored(PARAM_STRB_MIN_US), 20000);
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
