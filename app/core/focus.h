/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The zoom of the beam: a motor between flood (0) and spot (PPM_ONE) that needs travel_us from end
 * to end and tells nothing. Its position is reckoned from how long it has run. It is run a tenth
 * longer than needed into an end, so that it surely is there and the reckoning is exact again.
 *
 * Context: the thread that owns it, no locks inside. Spec: IMC 300 CameraZoom.
 */
#ifndef PHAROS_CORE_FOCUS_H
#define PHAROS_CORE_FOCUS_H

#include "core/limits.h"

#include <stdbool.h>
#include <stdint.h>

/* Wire values of IMC. */
enum focus_action {
	FOCUS_ACTION_RESET, /* to the end at flood, wherever it is thought to be */
	FOCUS_ACTION_IN,    /* towards spot */
	FOCUS_ACTION_OUT,   /* towards flood */
	FOCUS_ACTION_STOP,
};
#define FOCUS_ACTIONS 4u

enum focus_motor {
	FOCUS_MOTOR_STOPPED,
	FOCUS_MOTOR_IN,
	FOCUS_MOTOR_OUT,
};

struct focus {
	int64_t travel_us;
	enum focus_motor motor;
	uint32_t start_ppm; /* where it was when it last changed */
	uint32_t end_ppm;   /* where the movement ends */
	int64_t start_us;
	int64_t end_us; /* when; TIME_NEVER_US: stopped */
};

/* At flood, as far as known. travel_us 1…FOCUS_TRAVEL_MAX_US (asserted). */
void focus_init(struct focus *self, int64_t travel_us);

/* False: no such action; nothing changed. */
bool focus_command(struct focus *self, int64_t now_us, uint32_t action);

/* To a position, 0…PPM_ONE (asserted). */
void focus_move(struct focus *self, int64_t now_us, uint32_t position_ppm);

/* Stops where it ought to. */
void focus_advance(struct focus *self, int64_t now_us);
int64_t focus_deadline_us(const struct focus *self);

/* 0…PPM_ONE, reckoned. */
uint32_t focus_position_ppm(const struct focus *self, int64_t now_us);

#endif
