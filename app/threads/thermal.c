/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/thermal.h"

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/reboot.h>

#include <pharos/drivers/light.h>
#include <pharos/drivers/thermistor.h>

#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/inbox.h"
#include "threads/startup.h"
#include "threads/strobe.h"
#include "threads/supervisor.h"

LOG_MODULE_REGISTER(thermal);

static struct thermal thermal;
static K_MUTEX_DEFINE(thermal_lock); /* held for microseconds, never over a sample */
static atomic_t sampled;

static const enum thermal_sample_status status_of[] = {
	[THERMISTOR_OK] = THERMAL_SAMPLE_OK,
	[THERMISTOR_OPEN] = THERMAL_SAMPLE_OPEN,
	[THERMISTOR_SHORT] = THERMAL_SAMPLE_SHORT,
};

void thermal_thread_init(const struct thermal_config *config)
{
	thermal_init(&thermal, clock_now_us(), config);
}

void thermal_thread_configure(const struct thermal_config *config)
{
	k_mutex_lock(&thermal_lock, K_FOREVER); /* see there */
	thermal_configure(&thermal, config);
	k_mutex_unlock(&thermal_lock);
}

void thermal_thread_get(struct thermal *copy)
{
	k_mutex_lock(&thermal_lock, K_FOREVER); /* see there */
	*copy = thermal;
	k_mutex_unlock(&thermal_lock);
}

bool thermal_thread_has_sampled(void)
{
	return atomic_get(&sampled) != 0;
}

/* A lamp that cannot be switched off: in a reset its pins float, and then its driver will fail. */
static void reset_if_stuck(const struct light_state *light)
{
	if (light->stuck) {
		LOG_ERR("the lamp cannot be made dark: error %d; reset", light->error);
		light_off_now(devices.light);
		sys_reboot(SYS_REBOOT_COLD);
	}
}

/* Puts the limit in force. Nothing may light the lamp without watchdog or what drives it. */
static void enforce(struct thermal_report *report)
{
	struct light_state light;

	if (!startup_allows_light()) {
		report->limit_ppm = 0;
		report->dark = true;
	}
	/* tries again what has failed */
	(void)light_set_limit(devices.light, report->limit_ppm);
	light_get(devices.light, &light);
	report->dark = report->dark || light.error != 0;
	reset_if_stuck(&light);
}

/* One period: a converter that cannot be read gives no sample, and soon a MISSING fault. */
static struct thermal_report sample_and_step(void)
{
	struct thermistor_sample reading;
	struct thermal_sample sample = {.lit = strobe_timer_was_lit()};
	const bool read = startup_result(STARTUP_SENSOR) == 0 &&
	                  thermistor_sample(devices.thermistor, &reading) == 0;

	if (read) {
		sample.status = status_of[reading.status];
		sample.temp_mdegc = reading.temp_mdegc;
		sample.raw = reading.raw;
	}
	k_mutex_lock(&thermal_lock, K_FOREVER); /* see there */
	struct thermal_report report =
		thermal_step(&thermal, clock_now_us(), read ? &sample : NULL);

	enforce(&report);
	k_mutex_unlock(&thermal_lock);
	if (report.sensor == THERMAL_SENSOR_OK) {
		atomic_set(&sampled, 1);
	}
	return report;
}

void thermal_thread_run(void *p1, void *p2, void *p3)
{
	int64_t next_us = clock_now_us();

	for (;;) {
		const struct thermal_report report = sample_and_step();

		inbox_post_thermal(&report);
		supervisor_report(SUPERVISOR_THERMAL);
		next_us += THERMAL_PERIOD_US;
		k_sleep(clock_timeout(next_us));
	}
}
