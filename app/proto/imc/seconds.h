/* SPDX-License-Identifier: Apache-2.0 */
/*
 * IMC's f64 seconds and our int64 microseconds, without arithmetic in double precision, which small
 * processors lack. Any context; no state.
 */
#ifndef PHAROS_PROTO_IMC_SECONDS_H
#define PHAROS_PROTO_IMC_SECONDS_H

#include "core/limits.h"

#include <stdbool.h>
#include <stdint.h>

/* The nearest microsecond, halves away from zero. false: no number, or beyond +-TIME_MAX_US. */
bool imc_seconds_to_us(double seconds, int64_t *us);

/* time_us 0…TIME_MAX_US. Exact to a microsecond, as far as an f64 is. */
double imc_seconds_from_us(int64_t time_us);

#endif
