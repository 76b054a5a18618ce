/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A hobby servo: a pulse of 1500 us is its middle, 500 us more or less are 90 degrees, and it turns
 * at its own speed towards what the last pulse said. Without pulses it stays where it is. Plain
 * data. Times in microseconds, never going back; angles in thousandths of a degree.
 */
#ifndef NATIVE_MODELS_SERVO_H_
#define NATIVE_MODELS_SERVO_H_

#include <stdint.h>

#define SERVO_MIDDLE_NS        1500000
#define SERVO_NS_PER_DEGREE    (500000.0 / 90.0)
#define SERVO_END_MDEG         125000 /* of its mechanics: pulses of 806 us and 2194 us */
#define SERVO_SPEED_MDEG_PER_S 500000 /* 0.12 s for 60 degrees */

struct servo {
	uint32_t pulse_ns; /* 0: none */
	double angle_mdeg;
	double target_mdeg;
	int64_t time_us;
};

/* Brings the angle to now_us. */
void servo_advance(struct servo *self, int64_t now_us);

/* pulse_ns 0: none. */
void servo_set_pulse_ns(struct servo *self, int64_t now_us, uint32_t pulse_ns);

#endif
