/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Expected directions are Rx(roll)' Ry(pitch)' v, worked out with Python's 64-bit floats, or by
 * hand where the comment shows how.
 */
#include "core/angle.h"

#include <zephyr/ztest.h>

ZTEST_SUITE(core_angle, NULL, NULL, NULL, NULL, NULL);

ZTEST(core_angle, test_wrap_is_within_half_a_turn)
{
	static const int32_t pairs[][2] = {
		{0, 0},
		{180000, 180000},
		{180001, -179999},
		{-180000, 180000},
		{-179999, -179999},
		{270000, -90000},
		{720001, 1},
		{-540000, 180000},
		{INT32_MAX, 83647}, /* 2147483647 - 5965 * 360000 */
	};

	for (size_t i = 0; i < ARRAY_SIZE(pairs); i++) {
		zassert_equal(angle_wrap_mdeg(pairs[i][0]), pairs[i][1], "%d", pairs[i][0]);
	}
}

/* sin(30) = 1/2, cos(60) = 1/2, and each quarter turn. */
ZTEST(core_angle, test_rotation)
{
	static const struct {
		int32_t mdeg, x, y;
	} cases[] = {
		{0, ANGLE_ONE, 0},
		{30000, 232471924, ANGLE_ONE / 2}, /* 2^28 * sqrt(3) / 2 */
		{60000, ANGLE_ONE / 2, 232471924},
		{90000, 0, ANGLE_ONE},
		{120000, -ANGLE_ONE / 2, 232471924},
		{180000, -ANGLE_ONE, 0},
		{-90000, 0, -ANGLE_ONE},
		{-150000, -232471924, -ANGLE_ONE / 2},
		{390000, 232471924, ANGLE_ONE / 2},
	};

	for (size_t i = 0; i < ARRAY_SIZE(cases); i++) {
		int32_t x = ANGLE_ONE;
		int32_t y = 0;

		angle_rotate(&x, &y, cases[i].mdeg);
		zassert_within(x, cases[i].x, 64, "%d: x %d", cases[i].mdeg, x);
		zassert_within(y, cases[i].y, 64, "%d: y %d", cases[i].mdeg, y);
	}
}

ZTEST(core_angle, test_angle_and_length_of_a_point)
{
	static const struct {
		int32_t x, y, mdeg, length;
	} cases[] = {
		{ANGLE_ONE, 0, 0, ANGLE_ONE},
		{300000000, 400000000, 53130, 500000000}, /* 3-4-5: atan(4/3) = 53.1301 */
		{-300000000, 400000000, 126870, 500000000},
		{-300000000, -400000000, -126870, 500000000},
		{300000000, -400000000, -53130, 500000000},
		{0, ANGLE_ONE / 2, 90000, ANGLE_ONE / 2},
		{0, -ANGLE_ONE, -90000, ANGLE_ONE},
		{-ANGLE_ONE, 0, 180000, ANGLE_ONE},
		{0, 0, 0, 0},
	};

	for (size_t i = 0; i < ARRAY_SIZE(cases); i++) {
		int32_t length;

		zassert_equal(angle_of_mdeg(cases[i].x, cases[i].y, &length), cases[i].mdeg,
		              "case %u", (unsigned int)i);
		zassert_within(length, cases[i].length, 64);
	}
}

static void assert_direction(struct direction direction, int32_t yaw_mdeg, int32_t pitch_mdeg)
{
	zassert_within(direction.yaw_mdeg, yaw_mdeg, 1, "yaw %d, not %d", direction.yaw_mdeg,
	               yaw_mdeg);
	zassert_within(direction.pitch_mdeg, pitch_mdeg, 1, "pitch %d, not %d",
	               direction.pitch_mdeg, pitch_mdeg);
}

ZTEST(core_angle, test_directions_from_level_to_a_body_and_back)
{
	static const struct {
		struct direction level;
		struct attitude body;
		int32_t yaw_mdeg, pitch_mdeg;
	} cases[] = {
		{{12000, -34000}, {0, 0, 77000}, 12000, -34000}, /* a level body, any heading */
		{{0, 0}, {0, 20000, 0}, 0, -20000},              /* nose up: look down */
		{{90000, 0}, {30000, 0, 0}, 90000, 30000},       /* right wing down: up there */
		{{-90000, 0}, {30000, 0, 0}, -90000, -30000},
		{{0, -60000}, {0, -30000, 0}, 0, -30000},
		{{45000, 0}, {0, 30000, 0}, 49107, -20705}, /* atan(2 / sqrt 3), asin(sqrt 2 / 4) */
		{{30000, -40000}, {25000, -15000, 0}, 33634, -14195},
		{{-60000, 10000}, {-10000, 5000, 0}, -58256, 16033},
	};

	for (size_t i = 0; i < ARRAY_SIZE(cases); i++) {
		const struct direction own = direction_to_body(cases[i].level, &cases[i].body, 0);

		assert_direction(own, cases[i].yaw_mdeg, cases[i].pitch_mdeg);
		assert_direction(direction_from_body(own, &cases[i].body, 0),
		                 cases[i].level.yaw_mdeg, cases[i].level.pitch_mdeg);
	}
}

ZTEST(core_angle, test_straight_down_has_no_yaw_of_its_own)
{
	static const struct attitude level = {.yaw_mdeg = 5000};

	assert_direction(direction_to_body((struct direction){.pitch_mdeg = -90000}, &level, 42000),
	                 42000, -90000);
	assert_direction(
		direction_from_body((struct direction){.pitch_mdeg = 90000}, &level, -7000), -7000,
		90000);
}
