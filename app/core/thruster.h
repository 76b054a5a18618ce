/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A thruster on a speed controller (ESC) that takes servo pulses: min_us is full reverse, max_us
 * full ahead, the middle neutral. After power-up it sees neutral for arm_us, as ESCs want it.
 * Without a new setpoint for loss_us it goes back to neutral.
 *
 * Context: the thread that owns it, no locks inside. Spec: IMC 301 SetThrusterActuation.
 */
#ifndef PHAROS_CORE_THRUSTER_H
#define PHAROS_CORE_THRUSTER_H

#include "core/limits.h"

#include <stdbool.h>
#include <stdint.h>

/* SERVO_PULSE_MIN_US <= min_us < max_us <= SERVO_PULSE_MAX_US; arm_us >= 0; loss_us > 0. */
struct thruster_config {
	uint32_t min_us;
	uint32_t max_us;
	int64_t arm_us;
	int64_t loss_us;
};

struct thruster {
	struct thruster_config config;
	int32_t value_ppm;  /* -PPM_ONE…PPM_ONE */
	int64_t armed_us;   /* when it takes setpoints */
	int64_t neutral_us; /* when a setpoint loses its force; TIME_NEVER_US: it is neutral */
};

/* Neutral; arming begins now. config asserted. */
void thruster_init(struct thruster *self, int64_t now_us, const struct thruster_config *config);

/* New parameters: in force at once, neutral until the next setpoint; not armed anew. */
void thruster_configure(struct thruster *self, const struct thruster_config *config);

/* value_ppm -PPM_ONE…PPM_ONE (asserted). False: not armed yet, nothing changed. */
bool thruster_set(struct thruster *self, int64_t now_us, int32_t value_ppm);

/* Neutral at once, and armed anew: its power has been off. */
void thruster_restart(struct thruster *self, int64_t now_us);

/* Neutral when the last setpoint is too old. */
void thruster_advance(struct thruster *self, int64_t now_us);
int64_t thruster_deadline_us(const struct thruster *self);

/* The pulse now, rounded to the nearest. */
uint32_t thruster_pulse_us(const struct thruster *self);

#endif
