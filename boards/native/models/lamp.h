/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lamp and its driver: light and power are linear in the duty cycle, and 0 while the driver
 * is not enabled. Keeps what it did: energy, light, and each change of its level with its time.
 * Plain data. Times in microseconds, never going back; levels and duty in ppm.
 *
 * Changes are numbered from 0 since power-on; the last LAMP_LOG_SIZE are kept. A change between
 * dark and lit is also counted as an edge.
 */
#ifndef NATIVE_MODELS_LAMP_H_
#define NATIVE_MODELS_LAMP_H_

#include <stdbool.h>
#include <stdint.h>

#define LAMP_LOG_SIZE 16384u

struct lamp_change {
	int64_t time_us;
	uint32_t level_ppm; /* from then on */
};

struct lamp {
	uint32_t full_mw; /* electrical power at 100 % */
	uint32_t duty_ppm;
	bool enabled;
	uint32_t level_ppm;
	uint32_t peak_ppm; /* highest level since lamp_reset_totals() */
	int64_t time_us;   /* totals are up to here */
	uint64_t light_us; /* integral of the level: microseconds of full light */
	uint32_t light_rest_ppm_us;
	uint64_t lit_us; /* time with any light */
	uint64_t edges;
	uint64_t changes;
	struct lamp_change log[LAMP_LOG_SIZE]; /* change n is at n % LAMP_LOG_SIZE */
};

void lamp_init(struct lamp *self, uint32_t full_mw);

/* True: the level changed. */
bool lamp_set_duty(struct lamp *self, int64_t now_us, uint32_t duty_ppm);
bool lamp_set_enable(struct lamp *self, int64_t now_us, bool enabled);

/* Brings the totals to now_us. */
void lamp_advance(struct lamp *self, int64_t now_us);

double lamp_power_w(const struct lamp *self);

/* As of the last advance. */
double lamp_energy_mj(const struct lamp *self);

/* Energy, light, lit time and peak start again from now_us; edges and changes go on. */
void lamp_reset_totals(struct lamp *self, int64_t now_us);

/* Change number n; NULL: not yet, or no longer kept. */
const struct lamp_change *lamp_change_at(const struct lamp *self, uint64_t n);

/* The oldest change that is kept; equal to changes when there is none. */
uint64_t lamp_oldest_change(const struct lamp *self);

#endif
