/* SPDX-License-Identifier: Apache-2.0 */
/* A supervisor that is sampled each 100 ms, for the two files that test it. */
#ifndef TESTS_UNIT_CORE_THERMAL_FIXTURE_H
#define TESTS_UNIT_CORE_THERMAL_FIXTURE_H

#include "core/thermal.h"

/* 70 °C throttle, 90 °C shutdown, 60 °C recover, 2 °C hysteresis; -50…150 °C; 20 °C/s + 1 °C. */
static const struct thermal_config thermal_defaults = {
	.throttle_mdegc = 70000,
	.shutdown_mdegc = 90000,
	.recover_mdegc = 60000,
	.hysteresis_mdegc = 2000,
	.min_mdegc = -50000,
	.max_mdegc = 150000,
	.noise_mdegc = 1000,
	.max_rate_mdegc_per_s = 20000,
	.floor_ppm = 200000,
	.safe_ppm = 100000,
	.slew_ppm_per_s = 500000,
	.stuck_us = 1000000,
	.missing_us = 500000,
	.good_samples = 3,
};

struct thermal_rig {
	struct thermal thermal;
	int64_t now_us;
	uint32_t raw;
	bool lit;
};

static inline void rig_start(struct thermal_rig *rig)
{
	*rig = (struct thermal_rig){.now_us = 1000000, .raw = 1};
	thermal_init(&rig->thermal, rig->now_us, &thermal_defaults);
}

static inline struct thermal_report
rig_sample(struct thermal_rig *rig, enum thermal_sample_status status, int32_t temp_mdegc)
{
	const struct thermal_sample sample = {
		.status = status, .temp_mdegc = temp_mdegc, .raw = rig->raw, .lit = rig->lit};

	rig->now_us += 100000;
	return thermal_step(&rig->thermal, rig->now_us, &sample);
}

/* A good sample: the code changes with each. */
static inline struct thermal_report rig_temp(struct thermal_rig *rig, int32_t temp_mdegc)
{
	rig->raw++;
	return rig_sample(rig, THERMAL_SAMPLE_OK, temp_mdegc);
}

/* Heats or cools by 2 °C per sample, which is plausible, until the temperature is temp_mdegc. */
static inline struct thermal_report rig_go(struct thermal_rig *rig, int32_t temp_mdegc)
{
	int32_t now_mdegc = rig->thermal.previous_mdegc;
	struct thermal_report report;

	do {
		if (now_mdegc < temp_mdegc) {
			now_mdegc = (temp_mdegc - now_mdegc > 2000) ? now_mdegc + 2000 : temp_mdegc;
		} else {
			now_mdegc = (now_mdegc - temp_mdegc > 2000) ? now_mdegc - 2000 : temp_mdegc;
		}
		report = rig_temp(rig, now_mdegc);
	} while (now_mdegc != temp_mdegc);
	return report;
}

#endif
