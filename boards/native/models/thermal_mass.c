/* SPDX-License-Identifier: Apache-2.0 */
#include "models/thermal_mass.h"

#include <math.h>

void thermal_mass_init(struct thermal_mass *self, const struct thermal_mass_params *params,
                       double ambient_c)
{
	*self = (struct thermal_mass){
		.params = *params,
		.temp_c = ambient_c,
		.ambient_c = ambient_c,
	};
}

double thermal_mass_advance(struct thermal_mass *self, int64_t now_us)
{
	const double resistance =
		self->fan_failed ? self->params.no_fan_k_per_w : self->params.fan_k_per_w;
	const double end_c = self->ambient_c + self->heat_w * resistance;
	const double step_s = (double)(now_us - self->time_us) * 1e-6;

	if (now_us > self->time_us) {
		self->temp_c =
			end_c + (self->temp_c - end_c) *
					exp(-step_s / (resistance * self->params.capacity_j_per_k));
		self->time_us = now_us;
	}
	return self->temp_c;
}

void thermal_mass_set_heat(struct thermal_mass *self, int64_t now_us, double heat_w)
{
	thermal_mass_advance(self, now_us);
	self->heat_w = heat_w;
}

void thermal_mass_set_ambient(struct thermal_mass *self, int64_t now_us, double ambient_c)
{
	thermal_mass_advance(self, now_us);
	self->ambient_c = ambient_c;
}

void thermal_mass_set_fan(struct thermal_mass *self, int64_t now_us, bool failed)
{
	thermal_mass_advance(self, now_us);
	self->fan_failed = failed;
}

void thermal_mass_set_temp(struct thermal_mass *self, int64_t now_us, double temp_c)
{
	thermal_mass_advance(self, now_us);
	self->temp_c = temp_c;
}
