/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rotations against quaternions worked out by hand: a turn of a about an axis is cos(a/2) and
 * sin(a/2) along it; yaw then pitch is their product.
 */
#include "proto/mavlink/quaternion.h"

#include "proto/mavlink/real.h"

#include <zephyr/ztest.h>

#define H 0.70710678f /* sqrt(1/2) */
#define C 0.92387953f /* cos(22.5) */
#define S 0.38268343f /* sin(22.5) */

ZTEST_SUITE(mavlink_quaternion, NULL, NULL, NULL, NULL, NULL);

/* Near straight up or down, 24 bits of a float are no more than this. */
static int32_t tolerance_mdeg(struct direction direction)
{
	return direction.pitch_mdeg == 90000 || direction.pitch_mdeg == -90000 ? 40 : 1;
}

static const struct {
	float q[4];
	struct direction direction;
} directions[] = {
	{{1, 0, 0, 0}, {0, 0}},
	{{H, 0, 0, H}, {90000, 0}},
	{{H, 0, 0, -H}, {-90000, 0}},
	{{C, 0, 0, S}, {45000, 0}},
	{{C, 0, S, 0}, {0, 45000}},
	{{C, 0, -S, 0}, {0, -45000}},
	{{0, 0, 0, 1}, {180000, 0}},
	{{H * C, H *S, -H *S, H *C}, {90000, -45000}}, /* right, then down */
	{{0.86602540f * C, -0.5f * S, 0.86602540f * S, 0.5f * C}, {60000, 45000}},
	/* straight down after a turn of 90, and of -45 */
	{{0.5f, 0.5f, -0.5f, 0.5f}, {90000, -90000}},
	{{C * H, -S *H, -C *H, -S *H}, {-45000, -90000}},
	/* straight up after a turn of 45 */
	{{C * H, -S *H, C *H, S *H}, {45000, 90000}},
};

ZTEST(mavlink_quaternion, test_direction)
{
	for (size_t i = 0; i < ARRAY_SIZE(directions); i++) {
		const struct direction is = quaternion_direction(directions[i].q);

		zassert_within(is.yaw_mdeg, directions[i].direction.yaw_mdeg, 1, "%u: yaw %d",
		               (unsigned int)i, is.yaw_mdeg);
		zassert_within(is.pitch_mdeg, directions[i].direction.pitch_mdeg,
		               tolerance_mdeg(directions[i].direction), "%u: pitch %d",
		               (unsigned int)i, is.pitch_mdeg);
	}
}

ZTEST(mavlink_quaternion, test_of_direction)
{
	for (size_t i = 0; i < ARRAY_SIZE(directions); i++) {
		float q[4];

		quaternion_of_direction(directions[i].direction, q);
		for (size_t j = 0; j < 4; j++) {
			zassert_within(q[j], directions[i].q[j], 2e-6f, "%u: %u is %d ppm",
			               (unsigned int)i, (unsigned int)j, (int)(q[j] * 1e6f));
		}
	}
}

/* As the negative is the same rotation. */
ZTEST(mavlink_quaternion, test_both_signs_are_one_rotation)
{
	for (size_t i = 0; i < ARRAY_SIZE(directions); i++) {
		float q[4];

		for (size_t j = 0; j < 4; j++) {
			q[j] = -directions[i].q[j];
		}
		const struct direction is = quaternion_direction(q);

		zassert_within(angle_wrap_mdeg(is.yaw_mdeg - directions[i].direction.yaw_mdeg), 0,
		               1, "%u: yaw %d", (unsigned int)i, is.yaw_mdeg);
		zassert_within(is.pitch_mdeg, directions[i].direction.pitch_mdeg,
		               tolerance_mdeg(directions[i].direction));
	}
}

ZTEST(mavlink_quaternion, test_attitude)
{
	static const struct {
		float q[4];
		struct attitude attitude;
	} cases[] = {
		{{C, S, 0, 0}, {45000, 0, 0}},
		{{H, -H, 0, 0}, {-90000, 0, 0}},
		{{C, 0, -S, 0}, {0, -45000, 0}},
		{{H, 0, 0, H}, {0, 0, 90000}},
		/* yaw 90, pitch 0, roll 45: (H, 0, 0, H)(C, S, 0, 0) */
		{{H * C, H * S, H * S, H * C}, {45000, 0, 90000}},
		/* yaw 0, pitch 45, roll 90: (C, 0, S, 0)(H, H, 0, 0) */
		{{C * H, C * H, S * H, -S * H}, {90000, 45000, 0}},
	};

	for (size_t i = 0; i < ARRAY_SIZE(cases); i++) {
		const struct attitude is = quaternion_attitude(cases[i].q);

		zassert_within(is.roll_mdeg, cases[i].attitude.roll_mdeg, 1, "%u: roll %d",
		               (unsigned int)i, is.roll_mdeg);
		zassert_within(is.pitch_mdeg, cases[i].attitude.pitch_mdeg, 1, "%u: pitch %d",
		               (unsigned int)i, is.pitch_mdeg);
		zassert_within(is.yaw_mdeg, cases[i].attitude.yaw_mdeg, 1, "%u: yaw %d",
		               (unsigned int)i, is.yaw_mdeg);
	}
}

ZTEST(mavlink_quaternion, test_what_is_a_unit_quaternion)
{
	static const float good[][4] = {
		{1, 0, 0, 0}, {0.5f, -0.5f, 0.5f, -0.5f}, {1.005f, 0, 0, 0}};
	static const float bad[][4] = {
		{0, 0, 0, 0},   {0.9f, 0, 0, 0},     {1.1f, 0, 0, 0},      {NAN, 0, 0, 0},
		{1, 0, 0, NAN}, {INFINITY, 0, 0, 0}, {1e30f, 1e30f, 0, 0},
	};

	for (size_t i = 0; i < ARRAY_SIZE(good); i++) {
		zassert_true(quaternion_is_unit(good[i]));
	}
	for (size_t i = 0; i < ARRAY_SIZE(bad); i++) {
		zassert_false(quaternion_is_unit(bad[i]), "%u", (unsigned int)i);
		zassert_false(quaternion_is_absent(bad[i]));
	}
	zassert_true(quaternion_is_absent((const float[4]){NAN, NAN, NAN, NAN}));
}
