/* SPDX-License-Identifier: Apache-2.0 */
#ifndef PHAROS_LIGHT_PULSE_H_
#define PHAROS_LIGHT_PULSE_H_

#include <stdint.h>

#include <pharos/drivers/light.h>

/* The pulse of an output of 0…LIGHT_LEVEL_MAX_PPM: rounded down, so never above the limit. */
static inline uint32_t light_pulse(uint32_t output_ppm, uint32_t period_cycles)
{
	return (uint32_t)(((uint64_t)output_ppm * period_cycles) / LIGHT_LEVEL_MAX_PPM);
}

#endif
