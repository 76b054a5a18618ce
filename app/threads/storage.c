/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/storage.h"

#include <errno.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/settings/settings.h>
#include <zephyr/sys/printk.h>

#include "core/settle.h"
#include "threads/clock.h"

LOG_MODULE_REGISTER(storage);

#define SUBTREE         "pharos"
#define LIGHT_NAME      SUBTREE "/light"
#define POWER_NAME      SUBTREE "/power"
#define SIGNING_NAME    SUBTREE "/signing"
#define PARAM_PREFIX    SUBTREE "/param/"
#define STORED_NAME_MAX (sizeof(PARAM_PREFIX) + PARAMS_NAME_MAX)

/* Below all that must be in time: a page of flash takes tens of milliseconds to erase. */
#define STORAGE_PRIORITY 10

/* How the settings lie in the store: little endian on every target, versioned by its length. */
struct stored_light {
	uint32_t brightness_ppm;
	uint32_t strobe_period_us;
	uint32_t duty_ppm;
	uint8_t mode;
	uint8_t enable;
	uint8_t reserved[2];
};

/* What is to be written; read and changed under the lock. */
static K_MUTEX_DEFINE(lock);
static struct {
	struct param_set params;
	int32_t values[PARAM_COUNT];
	struct settle light;
	struct stored_light settings;
#ifdef CONFIG_PHAROS_IMC
	bool power;
	uint8_t power_mask;
#endif
#ifdef CONFIG_PHAROS_SIGNING
	bool signing;
	struct mavlink_signing_record record;
#endif
} pending;
static struct storage_stats stats;
static int64_t writing_until_ms; /* when the write under way is one that hangs; 0: there is none */

static K_THREAD_STACK_DEFINE(stack, CONFIG_PHAROS_STORAGE_STACK_SIZE);
static struct k_work_q queue;
static void save(struct k_work *work);
static K_WORK_DELAYABLE_DEFINE(save_work, save);

/* --- load ------------------------------------------------------------------------------------- */

struct loading {
	int32_t values[PARAM_COUNT];
	struct stored_light light;
	bool has_light;
};

static int load_param(struct loading *loading, const char *name, size_t length,
                      settings_read_cb read, void *arg)
{
	const uint32_t index = params_find(name, strlen(name));
	int32_t value;

	if (index == PARAM_COUNT || length != sizeof(value) ||
	    read(arg, &value, sizeof(value)) != (ssize_t)sizeof(value)) {
		stats.refused++;
		return 0;
	}
	loading->values[index] = value;
	return 0;
}

static int load_one(const char *key, size_t length, settings_read_cb read, void *arg, void *param)
{
	struct loading *const loading = param;
	const char *rest;

	if (settings_name_steq(key, "param", &rest) && rest != NULL) {
		return load_param(loading, rest, length, read, arg);
	}
	if (settings_name_steq(key, "light", &rest) && rest == NULL &&
	    length == sizeof(loading->light)) {
		loading->has_light = read(arg, &loading->light, length) == (ssize_t)length;
	}
	return 0;
}

int storage_load(struct params *params, struct illuminator_settings *light, bool *has_light)
{
	struct loading loading = {.has_light = false};
	int error = settings_subsys_init();

	memcpy(loading.values, params->values, sizeof(loading.values));
	if (error == 0) {
		error = settings_load_subtree_direct(SUBTREE, load_one, &loading);
	}
	if (error != 0) {
		LOG_ERR("cannot load: error %d; defaults apply", error);
		stats.last_error = error;
		stats.failures++;
		*has_light = false;
		return error;
	}
	const struct param_set refused = params_load(params, loading.values);

	for (uint32_t index = 0; index < PARAM_COUNT; index++) {
		if (param_set_has(&refused, index)) {
			LOG_WRN("stored %s does not fit; default applies",
			        params_info(index)->name);
			stats.refused++;
		}
	}
	*has_light = loading.has_light;
	*light = (struct illuminator_settings){
		.enable = loading.light.enable != 0,
		.mode = (enum illuminator_mode)loading.light.mode,
		.brightness_ppm = loading.light.brightness_ppm,
		.strobe_period_us = loading.light.strobe_period_us,
		.duty_ppm = loading.light.duty_ppm,
	};
	return 0;
}

#ifdef CONFIG_PHAROS_IMC
static int load_power(const char *key, size_t length, settings_read_cb read, void *arg, void *param)
{
	uint8_t mask;

	if (key == NULL && length == sizeof(mask) && read(arg, &mask, length) == (ssize_t)length) {
		*(int *)param = mask;
	}
	return 0;
}

int storage_load_power(void)
{
	int mask = -1;
	const int error = settings_load_subtree_direct(POWER_NAME, load_power, &mask);

	if (error != 0) {
		LOG_ERR("cannot load the power channels: error %d; defaults apply", error);
		stats.last_error = error;
		stats.failures++;
	}
	return mask;
}
#endif

#ifdef CONFIG_PHAROS_SIGNING
/* As it lies in the store: little endian on every target, without gaps. */
_Static_assert(sizeof(struct mavlink_signing_record) == 40, "timestamp and key");

static int load_signing(const char *key, size_t length, settings_read_cb read, void *arg,
                        void *param)
{
	struct mavlink_signing_record record;

	if (key != NULL) {
		return 0;
	}
	if (length == sizeof(record) && read(arg, &record, length) == (ssize_t)length) {
		*(struct mavlink_signing_record *)param = record;
	} else {
		stats.refused++;
	}
	return 0;
}

void storage_load_signing(struct mavlink_signing_record *record)
{
	memset(record, 0, sizeof(*record));

	const int error = settings_load_subtree_direct(SIGNING_NAME, load_signing, record);

	if (error != 0) {
		LOG_ERR("cannot load the signing key: error %d; there is none", error);
		stats.last_error = error;
		stats.failures++;
	}
}
#endif

/* --- save ------------------------------------------------------------------------------------- */

/* Under the lock. The light settles; nothing else waits for it. */
static int64_t deadline_us(void)
{
	bool now = !param_set_is_empty(&pending.params);

#ifdef CONFIG_PHAROS_IMC
	now = now || pending.power;
#endif
#ifdef CONFIG_PHAROS_SIGNING
	now = now || pending.signing;
#endif
	return now ? 0 : settle_deadline_us(&pending.light);
}

static void begin(void)
{
	(void)k_mutex_lock(&lock, K_FOREVER); /* held for microseconds, never over a write */
}

static void end(void)
{
	const int64_t due_us = deadline_us();

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
	param_set_merge(&pending.params, changed);
	memcpy(pending.values, params->values, sizeof(pending.values));
	end();
}

void storage_save_light(const struct illuminator_settings *light)
{
	begin();
	settle_change(&pending.light, clock_now_us());
	pending.settings = (struct stored_light){
		.brightness_ppm = light->brightness_ppm,
		.strobe_period_us = light->strobe_period_us,
		.duty_ppm = light->duty_ppm,
		.mode = (uint8_t)light->mode,
		.enable = light->enable,
	};
	end();
}

#ifdef CONFIG_PHAROS_IMC
void storage_save_power(uint8_t mask)
{
	begin();
	pending.power = true;
	pending.power_mask = mask;
	end();
}
#endif

#ifdef CONFIG_PHAROS_SIGNING
void storage_save_signing(const struct mavlink_signing_record *record)
{
	begin();
	pending.signing = true;
	pending.record = *record;
	end();
}
#endif

struct storage_stats storage_stats_get(void)
{
	(void)k_mutex_lock(&lock, K_FOREVER); /* held for microseconds, never over a write */
	if (writing_until_ms != 0 && k_uptime_get() >= writing_until_ms) {
		writing_until_ms = 0;
		stats.failures++;
		stats.last_error = -ETIMEDOUT;
	}
	const struct storage_stats copy = stats;

	(void)k_mutex_unlock(&lock);
	return copy;
}

/* --- storage's thread ------------------------------------------------------------------------- */

static void write_value(const char *name, const void *value, size_t length)
{
	begin();
	writing_until_ms = k_uptime_get() + STORAGE_WRITE_MS;
	end();

	const int error = settings_save_one(name, value, length);

	begin();
	writing_until_ms = 0;
	stats.writes++;
	if (error != 0) {
		stats.failures++;
		stats.last_error = error;
	}
	end();
	if (error != 0) {
		LOG_ERR("cannot write %s: error %d", name, error);
	}
}

/* Writes one pending parameter; false: there is none. */
static bool write_param(void)
{
	begin();
	const uint32_t index = param_set_take(&pending.params);
	const int32_t value = index < PARAM_COUNT ? pending.values[index] : 0;

	end();
	if (index == PARAM_COUNT) {
		return false;
	}
	char name[STORED_NAME_MAX];

	snprintk(name, sizeof(name), PARAM_PREFIX "%s", params_info(index)->name);
	write_value(name, &value, sizeof(value));
	return true;
}

static void write_signing(void)
{
#ifdef CONFIG_PHAROS_SIGNING
	begin();
	const bool wanted = pending.signing;
	const struct mavlink_signing_record record = pending.record;

	pending.signing = false;
	end();
	if (wanted) {
		write_value(SIGNING_NAME, &record, sizeof(record));
	}
#endif
}

static void write_power(void)
{
#ifdef CONFIG_PHAROS_IMC
	begin();
	const bool wanted = pending.power;
	const uint8_t mask = pending.power_mask;

	pending.power = false;
	end();
	if (wanted) {
		write_value(POWER_NAME, &mask, sizeof(mask));
	}
#endif
}

static void write_light(void)
{
	begin();
	const bool wanted = settle_deadline_us(&pending.light) <= clock_now_us();
	const struct stored_light light = pending.settings;

	if (wanted) {
		settle_write(&pending.light, clock_now_us());
	}
	end();
	if (wanted) {
		write_value(LIGHT_NAME, &light, sizeof(light));
	}
}

static void save(struct k_work *work)
{
	write_signing();
	write_power();
	while (write_param()) {
	}
	write_light();
}

void storage_submit(struct k_work *work)
{
	(void)k_work_submit_to_queue(&queue, work);
}

void storage_start(void)
{
	static const struct k_work_queue_config config = {.name = "storage"};

	k_work_queue_start(&queue, stack, K_THREAD_STACK_SIZEOF(stack), STORAGE_PRIORITY, &config);
	begin();
	end(); /* what came before */
}
