/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Zephyr's settings hold two records of core/store, "pharos/0" and "pharos/1":
 *
 *   command thread          storage's thread
 *   storage_save_…  ──lock──▶ struct store ──lock──▶ record ──▶ settings_save_one()
 *                                  deadline ──▶ save_work
 *
 * The lock is held while a record is put together, never while it is written. Up to version 0.1
 * each value was one of its own ("pharos/param/NAME", "pharos/light", …). Where there is no record
 * yet they are read; once there is one they are deleted.
 */
#include "threads/storage.h"

#include <errno.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/settings/settings.h>
#include <zephyr/sys/printk.h>

#include "core/param_units.h"
#include "core/store.h"
#include "threads/clock.h"

LOG_MODULE_REGISTER(storage);

#ifdef CONFIG_PHAROS_SIGNING
/* As it lies in the store: little endian on every target, without gaps. */
_Static_assert(sizeof(struct mavlink_signing_record) == STORE_SIGNING_BYTES, "timestamp and key");
#endif

#define SUBTREE      "pharos"
#define OLD_LIGHT    "light"
#define OLD_POWER    "power"
#define OLD_SIGNING  "signing"
#define OLD_PARAM    "param"
#define NAME_MAX_OLD (sizeof(SUBTREE "/" OLD_PARAM "/") + PARAMS_NAME_MAX)

/* Below all that must be in time: a page of flash takes tens of milliseconds to erase. */
#define STORAGE_PRIORITY 10

static K_MUTEX_DEFINE(lock);
static struct store store;         /* under the lock */
static struct storage_stats stats; /* under the lock */
/* When the write under way is one that hangs; 0: there is none. Under the lock. */
static int64_t writing_until_ms;
static bool told_waiting; /* under the lock */
static uint8_t record[STORE_RECORD_MAX];

static K_THREAD_STACK_DEFINE(storage_stack, CONFIG_PHAROS_STORAGE_STACK_SIZE);
static struct k_work_q queue;
static void save(struct k_work *work);
static K_WORK_DELAYABLE_DEFINE(save_work, save);

/* Values of the old layout that there are. */
static struct {
	struct param_set params;
	bool light;
	bool power;
	bool signing;
} old;

/* --- load ------------------------------------------------------------------------------------- */

struct loading {
	bool salvage;  /* what reads of the records, since none reads whole */
	uint8_t found; /* records */
	uint8_t whole;
};

static void load_record(struct loading *loading, uint8_t slot, settings_read_cb read, void *arg)
{
	const ssize_t count = read(arg, record, sizeof(record));
	const size_t length = count > 0 ? (size_t)count : 0;

	if (loading->salvage) {
		store_salvage(&store, record, length);
		return;
	}
	loading->found++;
	loading->whole += store_offer(&store, slot, record, length) ? 1 : 0;
}

/* "0" or "1". */
static int load_one(const char *key, size_t length, settings_read_cb read, void *arg, void *param)
{
	if (key != NULL && key[0] >= '0' && key[0] < '0' + (char)STORE_SLOTS && key[1] == '\0') {
		load_record(param, (uint8_t)(key[0] - '0'), read, arg);
	}
	return 0;
}

static bool read_exactly(settings_read_cb read, void *arg, size_t length, void *value, size_t size)
{
	if (length == size && read(arg, value, size) == (ssize_t)size) {
		return true;
	}
	stats.refused++;
	return false;
}

static void load_old_param(const char *name, size_t length, settings_read_cb read, void *arg)
{
	const uint32_t index = store_find(name);
	int32_t value;

	if (index == PARAM_COUNT) {
		stats.refused++;
		return;
	}
	param_set_add(&old.params, index);
	if (read_exactly(read, arg, length, &value, sizeof(value))) {
		store_put(&store, index, value);
	}
}

/* As it lies in the old store, little endian on every target. */
struct old_light {
	uint32_t brightness_ppm;
	uint32_t strobe_period_us;
	uint32_t duty_ppm;
	uint8_t mode;
	uint8_t enable;
	uint8_t reserved[2];
};

static void load_old_light(size_t length, settings_read_cb read, void *arg)
{
	struct old_light light;

	old.light = true;
	store.state.has_light = read_exactly(read, arg, length, &light, sizeof(light));
	if (store.state.has_light) {
		store.state.light = (struct illuminator_settings){
			.enable = light.enable != 0,
			.mode = (enum illuminator_mode)light.mode,
			.brightness_ppm = light.brightness_ppm,
			.strobe_period_us = light.strobe_period_us,
			.duty_ppm = light.duty_ppm,
		};
	}
}

static int load_old(const char *key, size_t length, settings_read_cb read, void *arg, void *param)
{
	struct store_state *const state = &store.state;
	const char *rest;

	if (settings_name_steq(key, OLD_PARAM, &rest) && rest != NULL) {
		load_old_param(rest, length, read, arg);
	} else if (settings_name_steq(key, OLD_LIGHT, NULL)) {
		load_old_light(length, read, arg);
	} else if (settings_name_steq(key, OLD_POWER, NULL)) {
		old.power = true;
		state->has_power = read_exactly(read, arg, length, &state->power, 1);
	} else if (settings_name_steq(key, OLD_SIGNING, NULL)) {
		old.signing = true;
		state->has_signing =
			read_exactly(read, arg, length, state->signing, sizeof(state->signing));
	}
	return 0;
}

static bool old_is_there(void)
{
	return !param_set_is_empty(&old.params) || old.light || old.power || old.signing;
}

static bool old_key_is_lost(void)
{
	return old.signing && !store.state.has_signing;
}

/* There may have been a key: a light must not open because its store cannot be read. */
static void lock_signing(void)
{
#ifdef CONFIG_PHAROS_SIGNING
	const struct mavlink_signing_record lost = {.timestamp = MAVLINK_SIGNING_LOST};

	LOG_ERR("a key may be lost: locked until the console says `signing key` or `signing off`");
	memcpy(store.state.signing, &lost, sizeof(lost));
	store.state.has_signing = true;
#endif
}

/* First what is old: a whole record takes its place, and what still reads of a broken one lowers
 * it.
 */
static int load_all(void)
{
	struct loading loading = {.salvage = false};
	int error = settings_subsys_init();

	if (error == 0) {
		error = settings_load_subtree_direct(SUBTREE, load_old, NULL);
	}
	if (error == 0) {
		error = settings_load_subtree_direct(SUBTREE, load_one, &loading);
	}
	if (error == 0 && loading.whole == 0 && loading.found > 0) {
		loading.salvage = true;
		error = settings_load_subtree_direct(SUBTREE, load_one, &loading);
	}
	if (loading.found > loading.whole) {
		LOG_ERR("%u of %u records cannot be read", loading.found - loading.whole,
		        loading.found);
		stats.refused += loading.found - loading.whole;
	}
	if (error != 0 || (loading.whole == 0 && (loading.found > 0 || old_key_is_lost()))) {
		lock_signing();
	}
	if (loading.found > loading.whole || (loading.whole == 0 && old_is_there())) {
		store_touch(&store, 0);
	}
	return error;
}

int storage_load(struct params *params, struct illuminator_settings *light, bool *has_light)
{
	store_init(&store);
	memset(&old, 0, sizeof(old));

	const int error = load_all();
	const struct param_set mended = store_check(&store);
	char text[DECIMAL_TEXT_MAX];

	if (error != 0) {
		LOG_ERR("cannot load: error %d; defaults apply", error);
		stats.last_error = error;
		stats.failures++;
	}
	for (uint32_t index = 0; index < PARAM_COUNT; index++) {
		if (param_set_has(&mended, index)) {
			param_print(params_info(index), store.state.params.values[index], text);
			LOG_WRN("stored %s does not fit; it is %s now", params_info(index)->name,
			        text);
			stats.refused++;
		}
	}
	*params = store.state.params;
	*has_light = store.state.has_light;
	*light = store.state.light;
	return error;
}

#ifdef CONFIG_PHAROS_IMC
uint8_t storage_load_power(uint8_t fallback)
{
	if (!store.state.has_power) {
		store.state.power = fallback;
	}
	return store.state.power;
}
#endif

#ifdef CONFIG_PHAROS_SIGNING
void storage_load_signing(struct mavlink_signing_record *signing)
{
	memset(signing, 0, sizeof(*signing));
	if (store.state.has_signing) {
		memcpy(signing, store.state.signing, sizeof(*signing));
	}
}
#endif

/* --- save ------------------------------------------------------------------------------------- */

static void begin(void)
{
	(void)k_mutex_lock(&lock, K_FOREVER); /* held for microseconds, never over a write */
}

/* And whatever waits now is written in time. */
static void end(void)
{
	const int64_t due_us = store_deadline_us(&store);

	(void)k_mutex_unlock(&lock);
	if (due_us != TIME_NEVER_US) {
		(void)k_work_reschedule_for_queue(&queue, &save_work,
		                                  due_us <= clock_now_us() ? K_NO_WAIT
		                                                           : clock_timeout(due_us));
	}
}

void storage_save_params(const struct params *params, const struct param_set *changed)
{
	begin();
	store_params(&store, clock_now_us(), params, changed);
	end();
}

void storage_save_light(const struct illuminator_settings *light)
{
	begin();
	store_light(&store, clock_now_us(), light);
	end();
}

#ifdef CONFIG_PHAROS_IMC
void storage_save_power(uint8_t mask)
{
	begin();
	store_power(&store, clock_now_us(), mask);
	end();
}
#endif

#ifdef CONFIG_PHAROS_SIGNING
void storage_save_signing(const struct mavlink_signing_record *signing)
{
	begin();
	store_signing(&store, clock_now_us(), (const uint8_t *)signing);
	end();
}
#endif

/* Something is due, and the thread still busy with a flash that does not answer. */
static bool waits_too_long(void)
{
	const int64_t due_us = store_deadline_us(&store);

	return !told_waiting && due_us != TIME_NEVER_US &&
	       clock_now_us() - due_us >= STORAGE_WAIT_MS * 1000LL;
}

struct storage_stats storage_stats_get(void)
{
	begin();
	const bool waits = waits_too_long();

	if (waits || (writing_until_ms != 0 && k_uptime_get() >= writing_until_ms)) {
		told_waiting |= waits;
		writing_until_ms = 0;
		stats.failures++;
		stats.last_error = -ETIMEDOUT;
	}
	const struct storage_stats copy = stats;

	(void)k_mutex_unlock(&lock);
	return copy;
}

/* --- storage's thread ------------------------------------------------------------------------- */

/* An error is counted and logged; people are told of it by who looks at the counters. */
static int write_record(uint8_t slot, size_t length)
{
	const char name[] = {'p', 'h', 'a', 'r', 'o', 's', '/', (char)('0' + slot), '\0'};
	const int error = settings_save_one(name, record, length);

	begin();
	writing_until_ms = 0;
	store_done(&store, clock_now_us(), error == 0);
	stats.writes++;
	if (error != 0) {
		stats.failures++;
		stats.last_error = error;
	}
	end();
	if (error != 0) {
		LOG_ERR("cannot write %s: error %d", name, error);
	}
	return error;
}

/* What was converted, now that the record of it is there. */
static void delete_old(void)
{
	char name[NAME_MAX_OLD];

	for (uint32_t i = param_set_take(&old.params); i < PARAM_COUNT;
	     i = param_set_take(&old.params)) {
		const char *const former = store_former_name(i);

		snprintk(name, sizeof(name), SUBTREE "/" OLD_PARAM "/%s",
		         former != NULL ? former : params_info(i)->name);
		(void)settings_delete(name);
	}
	if (old.light) {
		(void)settings_delete(SUBTREE "/" OLD_LIGHT);
	}
	if (old.power) {
		(void)settings_delete(SUBTREE "/" OLD_POWER);
	}
	if (old.signing) {
		(void)settings_delete(SUBTREE "/" OLD_SIGNING);
	}
	memset(&old, 0, sizeof(old));
}

static void save(struct k_work *work)
{
	uint8_t slot;
	int error = 0;

	begin();
	const size_t length = store_begin(&store, clock_now_us(), record, &slot);
	const bool is_stored = store.sequence != 0;

	told_waiting = false;
	writing_until_ms = length > 0 ? k_uptime_get() + STORAGE_WRITE_MS : 0;
	end();
	if (length > 0) {
		error = write_record(slot, length);
	}
	if (old_is_there() && error == 0 && (is_stored || length > 0)) {
		delete_old();
	}
}

void storage_submit(struct k_work *work)
{
	(void)k_work_submit_to_queue(&queue, work);
}

void storage_start(void)
{
	static const struct k_work_queue_config config = {.name = "storage"};

	k_work_queue_start(&queue, storage_stack, K_THREAD_STACK_SIZEOF(storage_stack),
	                   STORAGE_PRIORITY, &config);
	(void)k_work_reschedule_for_queue(&queue, &save_work, K_NO_WAIT); /* what came before */
}
