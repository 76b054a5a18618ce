/* SPDX-License-Identifier: Apache-2.0 */
#include "models/ntc_input.h"

#include <math.h>

#define ZERO_C_K 273.15
#define T25_K    298.15

/* noise is given for a converter of this width */
#define NOISE_FULL 4095.0

void ntc_input_init(struct ntc_input *self, const struct ntc_input_params *params, uint64_t seed)
{
	*self = (struct ntc_input){
		.params = *params,
		.noise = {.state = seed},
		.stuck_code = -1,
	};
}

void ntc_input_set_fault(struct ntc_input *self, enum ntc_fault fault)
{
	self->fault = fault;
	self->stuck_code = -1;
}

double ntc_input_ratio(const struct ntc_input *self, double temp_c)
{
	const struct ntc_input_params *params = &self->params;
	double ohms;

	switch (self->fault) {
	case NTC_FAULT_OPEN:
		return 1.0;
	case NTC_FAULT_SHORT:
		return 0.0;
	case NTC_FAULT_NONE:
	case NTC_FAULT_STUCK:
	case NTC_FAULT_NOISY:
	case NTC_FAULT_COUNT:
		break;
	}
	ohms = params->r25_ohms * exp(params->beta_k * (1.0 / (temp_c + ZERO_C_K) - 1.0 / T25_K));
	return ohms / (ohms + params->pullup_ohms);
}

uint16_t ntc_input_convert(struct ntc_input *self, double ratio, unsigned int bits)
{
	const double full = (double)((1u << bits) - 1u);
	const double noise_lsb = self->fault == NTC_FAULT_NOISY ? self->params.noisy_noise_lsb
	                                                        : self->params.noise_lsb;
	double code;

	if (self->fault == NTC_FAULT_STUCK && self->stuck_code >= 0) {
		return (uint16_t)self->stuck_code;
	}
	code = floor(ratio * full + noise_next(&self->noise) * noise_lsb * (full / NOISE_FULL) +
	             0.5);
	code = fmin(fmax(code, 0.0), full);
	if (self->fault == NTC_FAULT_STUCK) {
		self->stuck_code = (int32_t)code;
	}
	return (uint16_t)code;
}
