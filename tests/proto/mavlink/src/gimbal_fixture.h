/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gimbal component, 1/154 beside the light, on links 0 and 1. Its axes have ±90 degrees and 100
 * degrees per second. The vehicle is 1/1, and speaks on link 1.
 */
#ifndef PHAROS_TESTS_MAVLINK_GIMBAL_FIXTURE_H
#define PHAROS_TESTS_MAVLINK_GIMBAL_FIXTURE_H

#include "fixture.h"

#include "proto/mavlink/gimbal_service.h"

#define H 0.70710678f /* sqrt(1/2) */
#define C 0.92387953f /* cos(22.5) */
#define S 0.38268343f /* sin(22.5) */

extern struct gimbal *const gimbal; /* the device's */
extern struct arbiter *const gimbal_arbiter;
extern struct mavlink_gimbal its;

/* As fixture_before, and the gimbal. Suits ZTEST_SUITE. */
void gimbal_fixture_before(void *unused);

/* Someone speaks on link 1. */
void say(uint8_t system, uint8_t component, const struct mavlink_kind *kind, const void *payload);
void vehicle_beats(void);
void vehicle_attitude(float roll, float pitch, float yaw);

/* GIMBAL_DEVICE_SET_ATTITUDE from the vehicle, which must not be answered. */
struct setpoint {
	uint16_t flags;
	float q[4];
	float rates[3];
};
void set_attitude(struct setpoint setpoint);
#define NO_Q                                                                                       \
	{                                                                                          \
		NAN, NAN, NAN, NAN                                                                 \
	}
#define NO_RATES                                                                                   \
	{                                                                                          \
		NAN, NAN, NAN                                                                      \
	}

/* Time passes, the servos move. */
void pass(int64_t duration_us);
void assert_at(int32_t pan_mdeg, int32_t tilt_mdeg);

/* Time passes; what the gimbal sends by itself, on each link. */
struct sums {
	uint32_t heartbeats[2];
	uint32_t attitudes[2];
};
struct sums idle(int64_t duration_us);

/* A COMMAND_LONG to the gimbal; the result of its one answer. */
uint8_t order(uint16_t id, struct command_params with);
#define ORDER(id, ...) order((id), (struct command_params){{__VA_ARGS__}})

/* A message on request. */
void asked(uint32_t id, void *payload, size_t size);
mavlink_gimbal_device_attitude_status_t status(void);

/* The quaternion that it tells, within 1e-4. */
void assert_q(const mavlink_gimbal_device_attitude_status_t *wire, const float q[4]);

#endif
