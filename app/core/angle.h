/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Angles and directions without floats: thousandths of a degree, and components as fractions of
 * ANGLE_ONE. CORDIC; results are within a thousandth of a degree. Any context.
 *
 * Axes as in aviation: x ahead, y right, and up against z down. Yaw to the right, pitch up and roll
 * to the right are positive.
 */
#ifndef PHAROS_CORE_ANGLE_H
#define PHAROS_CORE_ANGLE_H

#include <stdint.h>

#define ANGLE_ONE       (INT32_C(1) << 28)
#define ANGLE_HALF_MDEG 180000
#define ANGLE_FULL_MDEG 360000

/* Of a body against the horizon and north: yaw first, then pitch, then roll. */
struct attitude {
	int32_t roll_mdeg;
	int32_t pitch_mdeg;
	int32_t yaw_mdeg;
};

/* yaw_mdeg -179999…180000, pitch_mdeg -90000…90000. */
struct direction {
	int32_t yaw_mdeg;
	int32_t pitch_mdeg;
};

/* The same angle as -179999…180000. */
int32_t angle_wrap_mdeg(int64_t mdeg);

/* Rotates (*x, *y), both within ±2 * ANGLE_ONE, from x to y. */
void angle_rotate(int32_t *x, int32_t *y, int32_t mdeg);

/*
 * Angle of (x, y), both within ±2 * ANGLE_ONE, from the x axis, -179999…180000, and its length. A
 * short one has a coarse angle, (0, 0) the angle 0.
 */
int32_t angle_of_mdeg(int32_t x, int32_t y, int32_t *length);

/*
 * A direction from the body's heading and the horizon, as seen along the body's own axes, and back.
 * upright: the yaw to give when the result points straight up or down, which has none.
 */
struct direction direction_to_body(struct direction level, const struct attitude *body,
                                   int32_t upright_mdeg);
struct direction direction_from_body(struct direction own, const struct attitude *body,
                                     int32_t upright_mdeg);

#endif
