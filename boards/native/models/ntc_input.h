/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A thermistor with its pull-up on an ADC input, and the converter's noise: R(T) = r25 exp(beta
 * (1/T - 1/298.15 K)), code = full R / (R + pull-up). Plain data.
 */
#ifndef NATIVE_MODELS_NTC_INPUT_H_
#define NATIVE_MODELS_NTC_INPUT_H_

#include <stdint.h>

#include "models/noise.h"

enum ntc_fault {
	NTC_FAULT_NONE,
	NTC_FAULT_OPEN,  /* the wire to it is broken: the pull-up wins */
	NTC_FAULT_SHORT, /* the input is at ground */
	NTC_FAULT_STUCK, /* each conversion gives the code of the fault's first one */
	NTC_FAULT_NOISY, /* noise_lsb of the fault instead of the usual one */
	NTC_FAULT_COUNT,
};

struct ntc_input_params {
	double pullup_ohms;
	double r25_ohms;
	double beta_k;
	double noise_lsb;       /* standard deviation of one conversion, in codes of 12 bits */
	double noisy_noise_lsb; /* with NTC_FAULT_NOISY */
};

struct ntc_input {
	struct ntc_input_params params;
	struct noise noise;
	enum ntc_fault fault;
	int32_t stuck_code; /* -1: none yet */
};

void ntc_input_init(struct ntc_input *self, const struct ntc_input_params *params, uint64_t seed);

void ntc_input_set_fault(struct ntc_input *self, enum ntc_fault fault);

/* The voltage as a part of the reference, 0…1, for a thermistor at that temperature; faults
 * included. */
double ntc_input_ratio(const struct ntc_input *self, double temp_c);

/* One conversion of that voltage, to `bits` bits (1…16). */
uint16_t ntc_input_convert(struct ntc_input *self, double ratio, unsigned int bits);

#endif
