/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The temperature of an NTC thermistor in integers: 1/T = 1/298.15 K + ln(R/r25) / beta.
 */
#ifndef PHAROS_THERMISTOR_NTC_MATH_H_
#define PHAROS_THERMISTOR_NTC_MATH_H_

#include <stdint.h>

struct ntc_divider {
	uint32_t pullup_ohms;
	uint32_t r25_ohms;
	uint32_t beta_k; /* 1000…10 000 */
};

/*
 * The thermistor lies between the ADC input and ground, the pull-up between the input and the
 * reference: code of full. 0 < code < full. Milli degrees Celsius, to 10 mK of the formula. Any
 * context, about 100 multiplications.
 */
int32_t ntc_temp_mdegc(const struct ntc_divider *divider, uint32_t code, uint32_t full);

#endif
