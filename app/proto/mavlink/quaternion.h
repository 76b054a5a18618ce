/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rotations as MAVLink has them: unit quaternions w, x, y, z (Hamilton) from the vehicle's or the
 * earth's frame (x ahead or north, y right or east, z down) to the body's. The core has angles.
 * Any context, no state.
 */
#ifndef PHAROS_PROTO_MAVLINK_QUATERNION_H
#define PHAROS_PROTO_MAVLINK_QUATERNION_H

#include "core/angle.h"

#include <stdbool.h>

/* Within one per cent of length 1; NaN and infinite ones are not. */
bool quaternion_is_unit(const float q[4]);

/* All four not a number: how MAVLink says that there is none. */
bool quaternion_is_absent(const float q[4]);

/*
 * Where the body's x axis points. When that is straight up or down, its yaw is that of a body
 * without roll. q is a unit quaternion.
 */
struct direction quaternion_direction(const float q[4]);

/* The body's attitude. q is a unit quaternion. */
struct attitude quaternion_attitude(const float q[4]);

/* Of a body without roll that points there. */
void quaternion_of_direction(struct direction direction, float q[4]);

#endif
