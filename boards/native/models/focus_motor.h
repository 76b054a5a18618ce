/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The motor that zooms the beam, between flood (0) and spot (1 000 000 ppm): it runs while one of
 * its two lines is high, and slips in its gear at the ends. With both high or none it stands.
 * Plain data. Times in microseconds, never going back.
 */
#ifndef NATIVE_MODELS_FOCUS_MOTOR_H_
#define NATIVE_MODELS_FOCUS_MOTOR_H_

#include <stdbool.h>
#include <stdint.h>

struct focus_motor {
	int64_t travel_us; /* from end to end */
	int64_t at_us;     /* where it is: how long from flood */
	int64_t time_us;   /* as of then */
	int direction;     /* 1 in, -1 out, 0 standing */
};

/* At flood. */
void focus_motor_init(struct focus_motor *self, int64_t travel_us);

void focus_motor_run(struct focus_motor *self, int64_t now_us, bool in, bool out);

void focus_motor_advance(struct focus_motor *self, int64_t now_us);

/* As of the last advance. */
int64_t focus_motor_ppm(const struct focus_motor *self);

#endif
