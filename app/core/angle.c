/* SPDX-License-Identifier: Apache-2.0 */
#include "core/angle.h"

/* A turn is 2^32 units, so that they wrap by themselves. */
#define TURN         (INT64_C(1) << 32)
#define QUARTER_TURN (INT32_C(1) << 30)

#define STEPS 26

/* atan(2^-i) */
static const int32_t arcs[STEPS] = {
	536870912, 316933406, 167458907, 85004756, 42667331, 21354465, 10679838, 5340245, 2670163,
	1335087,   667544,    333772,    166886,   83443,    41722,    20861,    10430,   5215,
	2608,      1304,      652,       326,      163,      81,       41,       20,
};

/* Product of cos(atan(2^-i)), which undoes what the steps lengthen, in 2^-30. */
#define SHORTEN INT64_C(652032874)

/* Within 0.06 degrees of straight up or down, a direction has no yaw. */
#define UPRIGHT_MAX (ANGLE_ONE / 1024)

static int32_t shortened(int32_t value)
{
	return (int32_t)((value * SHORTEN) / (INT64_C(1) << 30));
}

/* value / 2^step, rounded down: gcc and clang shift negative numbers arithmetically. */
static int32_t part(int32_t value, int step)
{
	return value >> step;
}

int32_t angle_wrap_mdeg(int64_t mdeg)
{
	const int32_t rest = (int32_t)(mdeg % ANGLE_FULL_MDEG);

	if (rest > ANGLE_HALF_MDEG) {
		return rest - ANGLE_FULL_MDEG;
	}
	return rest <= -ANGLE_HALF_MDEG ? rest + ANGLE_FULL_MDEG : rest;
}

void angle_rotate(int32_t *x, int32_t *y, int32_t mdeg)
{
	int64_t turn = angle_wrap_mdeg(mdeg) * TURN / ANGLE_FULL_MDEG;
	int32_t along = *x;
	int32_t across = *y;

	if (turn > QUARTER_TURN || turn < -QUARTER_TURN) {
		along = -along;
		across = -across;
		turn += turn > 0 ? -TURN / 2 : TURN / 2;
	}

	int32_t left = (int32_t)turn;

	for (int i = 0; i < STEPS; i++) {
		const int32_t before = along;

		if (left >= 0) {
			along -= part(across, i);
			across += part(before, i);
			left -= arcs[i];
		} else {
			along += part(across, i);
			across -= part(before, i);
			left += arcs[i];
		}
	}
	*x = shortened(along);
	*y = shortened(across);
}

int32_t angle_of_mdeg(int32_t x, int32_t y, int32_t *length)
{
	int64_t turned = x < 0 ? TURN / 2 : 0;
	int32_t along = x < 0 ? -x : x;
	int32_t across = x < 0 ? -y : y;

	for (int i = 0; i < STEPS; i++) {
		const int32_t before = along;

		if (across > 0) {
			along += part(across, i);
			across -= part(before, i);
			turned += arcs[i];
		} else {
			along -= part(across, i);
			across += part(before, i);
			turned -= arcs[i];
		}
	}
	*length = shortened(along);
	if (x == 0 && y == 0) {
		return 0;
	}
	/* to the nearest */
	turned = 2 * turned * ANGLE_FULL_MDEG / TURN;
	return angle_wrap_mdeg((turned + (turned < 0 ? -1 : 1)) / 2);
}

struct axes {
	int32_t ahead;
	int32_t right;
	int32_t up;
};

static struct axes axes_of(struct direction direction)
{
	struct axes axes = {.ahead = ANGLE_ONE};

	angle_rotate(&axes.ahead, &axes.up, direction.pitch_mdeg);
	angle_rotate(&axes.ahead, &axes.right, direction.yaw_mdeg);
	return axes;
}

static struct direction direction_of(const struct axes *axes, int32_t upright_mdeg)
{
	struct direction direction;
	int32_t level;
	int32_t whole;

	direction.yaw_mdeg = angle_of_mdeg(axes->ahead, axes->right, &level);
	direction.pitch_mdeg = angle_of_mdeg(level, axes->up, &whole);
	if (level < UPRIGHT_MAX) {
		direction.yaw_mdeg = upright_mdeg;
	}
	return direction;
}

struct direction direction_to_body(struct direction level, const struct attitude *body,
                                   int32_t upright_mdeg)
{
	struct axes axes = axes_of(level);

	angle_rotate(&axes.ahead, &axes.up, -body->pitch_mdeg);
	angle_rotate(&axes.right, &axes.up, body->roll_mdeg);
	return direction_of(&axes, upright_mdeg);
}

struct direction direction_from_body(struct direction own, const struct attitude *body,
                                     int32_t upright_mdeg)
{
	struct axes axes = axes_of(own);

	angle_rotate(&axes.right, &axes.up, -body->roll_mdeg);
	angle_rotate(&axes.ahead, &axes.up, body->pitch_mdeg);
	return direction_of(&axes, upright_mdeg);
}
