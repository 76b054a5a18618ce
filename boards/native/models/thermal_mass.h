/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lamp's housing: one heat capacity, cooled to ambient through a thermal resistance that
 * depends on the fan. Solved exactly between changes: T(t) = T_end + (T - T_end) exp(-t / RC), so
 * that the step's size does not matter. Plain data. Times in microseconds, never going back.
 */
#ifndef NATIVE_MODELS_THERMAL_MASS_H_
#define NATIVE_MODELS_THERMAL_MASS_H_

#include <stdbool.h>
#include <stdint.h>

struct thermal_mass_params {
	double capacity_j_per_k;
	double fan_k_per_w;    /* resistance to ambient with the fan running */
	double no_fan_k_per_w; /* and with it stopped */
};

struct thermal_mass {
	struct thermal_mass_params params;
	double temp_c; /* at time_us */
	double ambient_c;
	double heat_w;
	bool fan_failed;
	int64_t time_us;
};

void thermal_mass_init(struct thermal_mass *self, const struct thermal_mass_params *params,
                       double ambient_c);

/* Moves on to now_us with what was set before; returns the temperature. */
double thermal_mass_advance(struct thermal_mass *self, int64_t now_us);

/* From now_us on. */
void thermal_mass_set_heat(struct thermal_mass *self, int64_t now_us, double heat_w);
void thermal_mass_set_ambient(struct thermal_mass *self, int64_t now_us, double ambient_c);
void thermal_mass_set_fan(struct thermal_mass *self, int64_t now_us, bool failed);
void thermal_mass_set_temp(struct thermal_mass *self, int64_t now_us, double temp_c);

#endif
