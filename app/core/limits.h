/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Every bound of the core, and how the bounds relate. Values that a user may tune are parameters
 * (params.h); what stands here holds for any tuning.
 */
#ifndef PHAROS_CORE_LIMITS_H
#define PHAROS_CORE_LIMITS_H

#include <stdint.h>

/* Lamps of a device. */
#define DEVICE_LAMPS_MAX 1

/* Ratios are parts per million: a perceptual curve needs that fineness at its dark end. */
#define PPM_ONE 1000000u

#define US_PER_MS 1000
#define US_PER_S  1000000

/* Strobe periods that any build or parameter may allow. One hour keeps all products in 64 bits. */
#define STROBE_PERIOD_FLOOR_US   100u
#define STROBE_PERIOD_CEILING_US 3600000000u

/* Clocks count microseconds since boot and stay within a quarter of int64_t: 73 000 years. */
#define TIME_MAX_US   (INT64_MAX / 4)
#define TIME_NEVER_US INT64_MAX

/* Temperatures that any parameter may name. */
#define TEMP_FLOOR_MDEGC   (-273150)
#define TEMP_CEILING_MDEGC 1000000

/* Gimbal: angles of an axis, its fastest rate, pulses that any servo takes, and how often the
 * servos are told.
 */
#define GIMBAL_ANGLE_MAX_MDEG 180000
#define GIMBAL_RATE_MAX       2000000 /* mdeg/s */
#define GIMBAL_PULSE_MIN_US   500
#define GIMBAL_PULSE_MAX_US   2500
#define GIMBAL_FRAME_US       20000

/* MAVLink PARAM_VALUE.param_id is 16 bytes and DroneCAN allows more: 16 without the terminator. */
#define PARAMS_NAME_MAX 16

/* Self-test: brightness goes up and down again in equal steps. */
#define SELF_TEST_STEP_US 50000
#define SELF_TEST_STEPS   40

/* Power channels; a mask of them is stored as one byte. */
#define POWER_CHANNELS_MAX    8u
/* A year of 365 days, from which on a relative time is taken for an absolute one and refused. */
#define POWER_SCHEDULE_MAX_US (INT64_C(31536000) * US_PER_S)
#define POWER_RESTART_US      (2 * (int64_t)US_PER_S)
#define SHUTDOWN_GRACE_MAX_US (INT64_C(3600) * US_PER_S)

/* Pulses that servos and speed controllers take. */
#define SERVO_PULSE_MIN_US  500u
#define SERVO_PULSE_MAX_US  2500u
#define FOCUS_TRAVEL_MAX_US (INT64_C(600) * US_PER_S)
/* Updates of a remote hold so long. */
#define REMOTE_HOLD_US      ((int64_t)US_PER_S)
#define REMOTE_RENEW_US     (40 * (int64_t)US_PER_MS)

/* Of each kind, on any board. */
#define ACTUATORS_PWMS_MAX         4u
#define ACTUATORS_LEDS_MAX         4u
#define ACTUATORS_GPIOS_MAX        4u
/* Zephyr's PWM drivers count nanoseconds in 32 bits. */
#define ACTUATORS_PERIOD_MAX_US    2000000u
#define ACTUATORS_SERVO_RANGE_MDEG 90000

#define DISPLAY_LINES   2u
#define DISPLAY_COLUMNS 16u

_Static_assert(POWER_SCHEDULE_MAX_US < TIME_MAX_US, "a scheduled time fits");
_Static_assert((uint64_t)STROBE_PERIOD_CEILING_US *PPM_ONE < (uint64_t)INT64_MAX,
               "period times ratio fits 64 bits");
_Static_assert(SELF_TEST_STEPS % 2 == 0, "a self-test reaches its peak");
_Static_assert(GIMBAL_PULSE_MAX_US < GIMBAL_FRAME_US, "a pulse fits its frame");
_Static_assert(STROBE_PERIOD_CEILING_US <= UINT32_MAX, "a period fits 32 bits");
_Static_assert(STROBE_PERIOD_FLOOR_US > 1, "a strobe has room for a lit and a dark microsecond");

#endif
