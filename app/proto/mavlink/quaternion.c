/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/quaternion.h"

#include "proto/mavlink/real.h"

#define W 0
#define X 1
#define Y 2
#define Z 3

/* Length 0.99 and 1.01, squared. */
#define UNIT_MIN 0.98f
#define UNIT_MAX 1.02f

/* The core's limit as well: nearer to straight up or down a direction has no yaw. */
#define UPRIGHT_MAX (ANGLE_ONE / 1024)

bool quaternion_is_unit(const float q[4])
{
	const float square = q[W] * q[W] + q[X] * q[X] + q[Y] * q[Y] + q[Z] * q[Z];

	return square >= UNIT_MIN && square <= UNIT_MAX;
}

bool quaternion_is_absent(const float q[4])
{
	return isnan(q[W]) && isnan(q[X]) && isnan(q[Y]) && isnan(q[Z]);
}

static int32_t fixed(float value)
{
	return (int32_t)(value * (float)ANGLE_ONE);
}

static float real(int32_t value)
{
	return (float)value / (float)ANGLE_ONE;
}

struct direction quaternion_direction(const float q[4])
{
	const float ahead = q[W] * q[W] + q[X] * q[X] - q[Y] * q[Y] - q[Z] * q[Z];
	const float right = 2.0f * (q[X] * q[Y] + q[W] * q[Z]);
	const float up = 2.0f * (q[W] * q[Y] - q[X] * q[Z]);
	struct direction direction;
	int32_t level;
	int32_t whole;

	direction.yaw_mdeg = angle_of_mdeg(fixed(ahead), fixed(right), &level);
	direction.pitch_mdeg = angle_of_mdeg(level, fixed(up), &whole);
	if (level < UPRIGHT_MAX) {
		direction.yaw_mdeg = angle_wrap_mdeg(
			2 * (int64_t)angle_of_mdeg(fixed(q[W]), fixed(q[Z]), &whole));
	}
	return direction;
}

struct attitude quaternion_attitude(const float q[4])
{
	const struct direction nose = quaternion_direction(q);
	const float upright = q[W] * q[W] - q[X] * q[X] - q[Y] * q[Y] + q[Z] * q[Z];
	const float aside = 2.0f * (q[W] * q[X] + q[Y] * q[Z]);
	int32_t length;

	return (struct attitude){
		.roll_mdeg = angle_of_mdeg(fixed(upright), fixed(aside), &length),
		.pitch_mdeg = nose.pitch_mdeg,
		.yaw_mdeg = nose.yaw_mdeg,
	};
}

/* Cosine and sine of half an angle; half a thousandth of a degree is lost. */
static void half(int32_t mdeg, float *cosine, float *sine)
{
	int32_t x = ANGLE_ONE;
	int32_t y = 0;

	angle_rotate(&x, &y, mdeg / 2);
	*cosine = real(x);
	*sine = real(y);
}

void quaternion_of_direction(struct direction direction, float q[4])
{
	float cos_yaw;
	float sin_yaw;
	float cos_pitch;
	float sin_pitch;

	half(direction.yaw_mdeg, &cos_yaw, &sin_yaw);
	half(direction.pitch_mdeg, &cos_pitch, &sin_pitch);
	q[W] = cos_yaw * cos_pitch;
	q[X] = -sin_yaw * sin_pitch;
	q[Y] = cos_yaw * sin_pitch;
	q[Z] = sin_yaw * cos_pitch;
}
