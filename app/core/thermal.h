/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Thermal supervisor: from temperature samples to the highest level the lamp may have.
 *
 * Two machines side by side. Heat: NORMAL → THROTTLING at throttle_mdegc and above; back below
 * throttle_mdegc - hysteresis_mdegc. Any → SHUTDOWN at shutdown_mdegc and above, latched until a
 * good sample is below recover_mdegc. Sensor: WAITING (no sample yet) → OK; any → FAILED on the
 * first bad sample or when samples stay away; FAILED → OK after good_samples good ones in a row.
 *
 * Limit: PPM_ONE up to throttle_mdegc, then falling linearly to floor_ppm just below
 * shutdown_mdegc, 0 in shutdown. Until the first sample in range: 0, whatever else; with first_us
 * > 0 what a failed sensor allows, from that long (and missing_us) after the start. Sensor FAILED:
 * safe_ppm, or what was allowed before if that is less; so a failing sensor never makes the lamp
 * brighter. The limit falls at once, with the very sample; it rises by at most slew_ppm_per_s,
 * except that the first good sample after start sets it outright.
 *
 * A sample is bad when it is OPEN or SHORT; out of [min_mdegc, max_mdegc]; further from the sample
 * before it than max_rate_mdegc_per_s and noise_mdegc explain; or STUCK: the lamp was lit for
 * stuck_us while the raw code never changed (an oversampled converter always shows some noise).
 * STUCK lasts until the code changes, lit or not.
 *
 * A failure may be heat: an NTC's code falls towards a short as it heats. SHORT, a temperature
 * above max_mdegc or an implausible one of shutdown_mdegc and above is heat; and so is any failure
 * of a sensor whose trend would have brought it to shutdown_mdegc within THERMAL_TREND_US. Heat is
 * a shutdown, or, with hot_ppm > 0, the limit hot_ppm until the sensor is OK again.
 *
 * Context: one thread (or interrupts locked); nothing here blocks. Spec: docs/architecture.md,
 * promise 1; MAVLink ILLUMINATOR_ERROR_FLAGS.
 */
#ifndef PHAROS_CORE_THERMAL_H
#define PHAROS_CORE_THERMAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* How far a failed sensor's trend is followed. */
#define THERMAL_TREND_US 10000000

/* Wire values of MAVLink ILLUMINATOR_ERROR_FLAGS. */
#define THERMAL_FLAG_THROTTLING 1u
#define THERMAL_FLAG_SHUTDOWN   2u
#define THERMAL_FLAG_THERMISTOR 4u

enum thermal_state {
	THERMAL_STATE_NORMAL,
	THERMAL_STATE_THROTTLING,
	THERMAL_STATE_SHUTDOWN,
};

enum thermal_sensor {
	THERMAL_SENSOR_WAITING,
	THERMAL_SENSOR_OK,
	THERMAL_SENSOR_FAILED,
};

enum thermal_fault {
	THERMAL_FAULT_NONE,
	THERMAL_FAULT_OPEN,
	THERMAL_FAULT_SHORT,
	THERMAL_FAULT_RANGE,
	THERMAL_FAULT_RATE,
	THERMAL_FAULT_STUCK,
	THERMAL_FAULT_MISSING,
};

enum thermal_sample_status {
	THERMAL_SAMPLE_OK,
	THERMAL_SAMPLE_OPEN,
	THERMAL_SAMPLE_SHORT,
};

/*
 * Ranges: recover < throttle < shutdown; min < max; ratios 0…PPM_ONE; times > 0 but first_us;
 * good_samples >= 1.
 * params.c keeps these among the parameters; thermal_init and thermal_configure assert them.
 */
struct thermal_config {
	int32_t throttle_mdegc;
	int32_t shutdown_mdegc;
	int32_t recover_mdegc;
	int32_t hysteresis_mdegc;
	int32_t min_mdegc;
	int32_t max_mdegc;
	int32_t noise_mdegc;
	uint32_t max_rate_mdegc_per_s;
	uint32_t floor_ppm;
	uint32_t safe_ppm;
	uint32_t hot_ppm; /* 0: heat is a shutdown */
	uint32_t slew_ppm_per_s;
	uint32_t first_us; /* 0: no light before the first sample in range */
	uint32_t stuck_us;
	uint32_t missing_us;
	uint32_t good_samples;
};

/* temp_mdegc and raw: any value; ignored unless status is OK. lit: the lamp gave light meanwhile.
 */
struct thermal_sample {
	enum thermal_sample_status status;
	int32_t temp_mdegc;
	uint32_t raw;
	bool lit;
};

/*
 * temp_mdegc: of the last good sample; 0 while temp_valid is false (sensor not OK). dark: not
 * even a failed sensor's light, until something is mended; a limit of 0 that waits for the first
 * sample is not.
 */
struct thermal_report {
	enum thermal_state state;
	enum thermal_sensor sensor;
	enum thermal_fault fault;
	uint32_t flags;
	uint32_t limit_ppm;
	int32_t temp_mdegc;
	bool temp_valid;
	bool dark;
};

/* Whether the lamp may be switched on; dark until the first sample it may. */
static inline bool thermal_allows_light(const struct thermal_report *report)
{
	return report->state != THERMAL_STATE_SHUTDOWN && !report->dark;
}

struct thermal_stats {
	uint32_t samples;
	uint32_t bad_samples;
	uint32_t sensor_failures;
	uint32_t shutdowns;
};

struct thermal {
	struct thermal_config config;
	struct thermal_report report;
	struct thermal_stats stats;
	int64_t start_us;
	int64_t sample_us;    /* of the last sample; of the start before the first */
	int64_t now_us;       /* of the last step */
	int64_t slewed_us;    /* up to when the limit's rise has been credited */
	int64_t plausible_us; /* of the sample that previous_mdegc is from */
	int64_t unchanged_us; /* since when the code is unchanged while lit */
	int64_t followed_us;  /* of slow_mdegc */
	int32_t previous_mdegc;
	int32_t slow_mdegc; /* lags behind the good samples: the difference is their trend */
	uint32_t previous_raw;
	uint32_t good_in_a_row;
	uint32_t rise_carry; /* remainder of the slew division, so slow rises are exact */
	bool has_previous;   /* a sample in range has been seen */
	bool stuck;
	bool hot; /* the sensor that has failed says heat */
};

/* now_us 0…TIME_MAX_US. The limit is 0 until the first sample in range. */
void thermal_init(struct thermal *self, int64_t now_us, const struct thermal_config *config);

/* New parameters, in force with the next step. */
void thermal_configure(struct thermal *self, const struct thermal_config *config);

/*
 * sample: one sample taken at now_us; NULL: none has come by now. now_us never goes back
 * (asserted). Returns what is in force from now on.
 */
struct thermal_report thermal_step(struct thermal *self, int64_t now_us,
                                   const struct thermal_sample *sample);

/* Short words for people, constant and never NULL: "open", "over temperature", … */
const char *thermal_fault_name(enum thermal_fault fault);
const char *thermal_state_name(enum thermal_state state);

#endif
