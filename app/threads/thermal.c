/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/thermal.h"

#include <zephyr/kernel.h>

#include <pharos/drivers/light.h>
#include <pharos/drivers/thermistor.h>

#include "threads/clock.h"
#include "threads/command.h"
#include "threads/devices.h"
#include "threads/strobe.h"
#include "threads/supervisor.h"

static struct thermal thermal;
static K_MUTEX_DEFINE(thermal_lock);

static const enum thermal_sample_status status_of[] = {
	[THERMISTOR_OK] = THERMAL_SAMPLE_OK,
	[THERMISTOR_OPEN] = THERMAL_SAMPLE_OPEN,
	[THERMISTOR_SHORT] = THERMAL_SAMPLE_SHORT,
};

void thermal_thread_init(const struct thermal_config *config)
{
	thermal_init(&thermal, clock_now_us(), config);
	light_set_limit(devices.light, thermal.report.limit_ppm);
}

void thermal_thread_configure(const struct thermal_config *config)
{
	k_mutex_lock(&thermal_lock, K_FOREVER);
	thermal_configure(&thermal, config);
	k_mutex_unlock(&thermal_lock);
}

void thermal_thread_get(struct thermal *copy)
{
	k_mutex_lock(&thermal_lock, K_FOREVER);
	*copy = thermal;
	k_mutex_unlock(&thermal_lock);
}

/* One period: a converter that cannot be read gives no sample, and soon a MISSING fault. */
static struct thermal_report sample_and_step(void)
{
	struct thermistor_sample reading;
	struct thermal_sample sample = {.lit = strobe_timer_was_lit()};
	const bool read = thermistor_sample(devices.thermistor, &reading) == 0;

	if (read) {
		sample.status = status_of[reading.status];
		sample.temp_mdegc = reading.temp_mdegc;
		sample.raw = reading.raw;
	}
	k_mutex_lock(&thermal_lock, K_FOREVER);
	const struct thermal_report report =
		thermal_step(&thermal, clock_now_us(), read ? &sample : NULL);

	light_set_limit(devices.light, report.limit_ppm);
	k_mutex_unlock(&thermal_lock);
	return report;
}

void thermal_thread_run(void *p1, void *p2, void *p3)
{
	int64_t next_us = clock_now_us();

	for (;;) {
		const struct thermal_report report = sample_and_step();

		command_post_thermal(&report);
		supervisor_report(SUPERVISOR_THERMAL);
		next_us += THERMAL_PERIOD_US;
		k_sleep(clock_timeout(next_us));
	}
}
