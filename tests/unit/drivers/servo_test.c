/* SPDX-License-Identifier: Apache-2.0 */
/* The servo driver, seen at the pins of the board's model. */
#include <errno.h>

#include <zephyr/devicetree.h>
#include <zephyr/ztest.h>

#include <pharos/drivers/servo.h>

#include "models/board.h"

static const struct device *const pan = DEVICE_DT_GET(DT_ALIAS(servo_pan));
static const struct device *const tilt = DEVICE_DT_GET(DT_ALIAS(servo_tilt));

static void before(void *fixture)
{
	zassert_ok(servo_set_pulse(pan, 0));
	zassert_ok(servo_set_pulse(tilt, 0));
}

ZTEST_SUITE(servo, NULL, NULL, before, NULL, NULL);

ZTEST(servo, test_pulses_at_50_hz_on_its_own_pin)
{
	zassert_ok(servo_set_pulse(pan, 1234567));
	zassert_equal(board.pwm[BOARD_PWM_SERVO_PAN].period_ns, 20000000);
	zassert_equal(board.pwm[BOARD_PWM_SERVO_PAN].pulse_ns, 1234567);
	zassert_equal(board.pwm[BOARD_PWM_SERVO_TILT].pulse_ns, 0);
}

ZTEST(servo, test_pulses_beyond_its_limits_are_refused)
{
	zassert_ok(servo_set_pulse(tilt, 500000));
	zassert_equal(servo_set_pulse(tilt, 499999), -EINVAL);
	zassert_equal(board.pwm[BOARD_PWM_SERVO_TILT].pulse_ns, 500000);
	zassert_ok(servo_set_pulse(tilt, 2500000));
	zassert_equal(servo_set_pulse(tilt, 2500001), -EINVAL);
	zassert_equal(board.pwm[BOARD_PWM_SERVO_TILT].pulse_ns, 2500000);
}

ZTEST(servo, test_no_pulse_lets_go)
{
	zassert_ok(servo_set_pulse(pan, 1500000));
	zassert_ok(servo_set_pulse(pan, 0));
	zassert_equal(board.pwm[BOARD_PWM_SERVO_PAN].pulse_ns, 0);
}
