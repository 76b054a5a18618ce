/* SPDX-License-Identifier: Apache-2.0 */
#include "core/actuators.h"

#include <zephyr/ztest.h>

#include "assert_hook.h"

#define S INT64_C(1000000)

static struct actuators actuators;
static struct actuators_outputs outputs;

static const struct actuators_config config = {
	.power = 0x0F,
	.power_on = 0x03,
	.pwms = 0x05,
	.leds = 0x02,
	.gpio_outputs = 0x03,
	.thruster = true,
	.focus = true,
	.display = true,
	.grace_us = 2 * S,
	.focus_travel_us = 4 * S,
	.thruster_config = {.min_us = 1000, .max_us = 2000, .arm_us = S, .loss_us = S},
};

static void before(void *fixture)
{
	actuators_init(&actuators, 0, &config);
}

ZTEST_SUITE(core_actuators, NULL, NULL, before, NULL, NULL);

/* Returns how many notices there were. */
static int advance(int64_t now_us)
{
	struct shutdown_notice notice;
	int count = 0;

	while (actuators_advance(&actuators, now_us, &notice)) {
		count++;
	}
	actuators_outputs(&actuators, &outputs);
	return count;
}

ZTEST(core_actuators, test_starts_idle_but_for_its_power)
{
	zassert_equal(advance(0), 0);
	zassert_equal(outputs.power, 0x03);
	zassert_equal(outputs.thruster_pulse_us, 1500);
	zassert_equal(outputs.focus, FOCUS_MOTOR_STOPPED);
	zassert_equal(outputs.pwms[0].period_us, 0);
	zassert_equal(outputs.leds[1], 0);
	zassert_false(outputs.display.on);
	zassert_equal(actuators_deadline_us(&actuators), TIME_NEVER_US);
}

ZTEST(core_actuators, test_pwm_takes_periods_that_drivers_can_count)
{
	zassert_true(actuators_set_pwm(&actuators, 2, 20000, 1500));
	zassert_true(actuators_set_pwm(&actuators, 0, 2000000, 2000000));
	zassert_false(actuators_set_pwm(&actuators, 0, 2000001, 1));
	zassert_false(actuators_set_pwm(&actuators, 0, 0, 0));
	zassert_false(actuators_set_pwm(&actuators, 0, 1000, 1001));
	zassert_false(actuators_set_pwm(&actuators, 1, 1000, 1), "not on this board");
	zassert_false(actuators_set_pwm(&actuators, 32, 1000, 1));
	advance(1);
	zassert_equal(outputs.pwms[2].period_us, 20000);
	zassert_equal(outputs.pwms[2].duty_us, 1500);
	zassert_equal(outputs.pwms[0].period_us, 2000000);
}

ZTEST(core_actuators, test_servo_pulses)
{
	/* angle in mdeg, pulse in us: 1500 + 500 * angle / 90 degrees */
	static const int32_t rows[][2] = {
		{-90000, 1000}, {-45000, 1250}, {0, 1500}, {30000, 1666}, {90000, 2000}};

	for (size_t i = 0; i < ARRAY_SIZE(rows); i++) {
		zassert_true(actuators_set_servo(&actuators, 0, rows[i][0]));
		zassert_equal(actuators.pwms[0].period_us, 20000);
		zassert_equal(actuators.pwms[0].duty_us, (uint32_t)rows[i][1], "row %zu", i);
	}
	zassert_false(actuators_set_servo(&actuators, 0, 90001));
	zassert_false(actuators_set_servo(&actuators, 0, -90001));
	zassert_false(actuators_set_servo(&actuators, 1, 0), "not on this board");
}

ZTEST(core_actuators, test_leds_and_lines)
{
	zassert_true(actuators_set_led(&actuators, 1, 255));
	zassert_false(actuators_set_led(&actuators, 0, 255));
	zassert_true(actuators_set_gpio(&actuators, 0, true));
	zassert_true(actuators_set_gpio(&actuators, 1, true));
	zassert_true(actuators_set_gpio(&actuators, 0, false));
	zassert_false(actuators_set_gpio(&actuators, 2, true));
	advance(1);
	zassert_equal(outputs.leds[1], 255);
	zassert_equal(outputs.gpio_outputs, 0x02);
}

ZTEST(core_actuators, test_down_everything_rests_and_up_it_comes_back)
{
	zassert_true(actuators_set_led(&actuators, 1, 7));
	zassert_true(actuators_set_pwm(&actuators, 0, 100, 50));
	zassert_true(actuators_set_gpio(&actuators, 1, true));
	zassert_true(focus_command(&actuators.focus, 5 * S, FOCUS_ACTION_IN));
	zassert_true(display_command(&actuators.display, DISPLAY_OP_ON, NULL, 0));
	zassert_true(thruster_set(&actuators.thruster, 5 * S, 1000000));
	zassert_true(shutdown_command(&actuators.shutdown, 5 * S, SHUTDOWN_OP_DOWN, 0));
	zassert_equal(advance(5 * S), 1);
	zassert_equal(outputs.power, 0x03, "not yet");
	zassert_equal(outputs.thruster_pulse_us, 2000);
	zassert_equal(advance(6 * S), 1);
	zassert_equal(advance(7 * S), 1);
	zassert_false(actuators_is_up(&actuators));
	zassert_equal(outputs.power, 0);
	zassert_equal(outputs.thruster_pulse_us, 0);
	zassert_equal(outputs.focus, FOCUS_MOTOR_STOPPED);
	zassert_equal(outputs.pwms[0].period_us, 0);
	zassert_equal(outputs.leds[1], 0);
	zassert_equal(outputs.gpio_outputs, 0);
	zassert_false(outputs.display.on);
	zassert_true(shutdown_command(&actuators.shutdown, 9 * S, SHUTDOWN_OP_UP, 0));
	zassert_equal(advance(9 * S), 1);
	zassert_equal(outputs.power, 0x03);
	zassert_equal(outputs.thruster_pulse_us, 1500);
	zassert_false(thruster_set(&actuators.thruster, 9 * S, 1), "its controller arms anew");
	zassert_equal(outputs.focus, FOCUS_MOTOR_STOPPED, "it stays where it is");
	zassert_equal(outputs.leds[1], 7);
	zassert_true(outputs.display.on);
}

ZTEST(core_actuators, test_deadline_is_the_first_of_all)
{
	zassert_true(power_command(&actuators.power, 0, 0, POWER_OP_SCHEDULE_OFF, 9 * S));
	zassert_equal(actuators_deadline_us(&actuators), 9 * S);
	zassert_true(shutdown_command(&actuators.shutdown, 0, SHUTDOWN_OP_SCHEDULE_DOWN, 8 * S));
	zassert_equal(actuators_deadline_us(&actuators), 8 * S);
	zassert_true(focus_command(&actuators.focus, 0, FOCUS_ACTION_IN));
	zassert_equal(actuators_deadline_us(&actuators), 4400000);
	zassert_true(thruster_set(&actuators.thruster, 1 * S, 1));
	zassert_equal(actuators_deadline_us(&actuators), 2 * S);
}

ZTEST(core_actuators, test_more_outputs_than_fit_are_a_bug)
{
	struct actuators_config wrong = config;

	wrong.pwms = 0x10;
	expect_assert();
	actuators_init(&actuators, 0, &wrong);
	zassert_unreachable("no assertion");
}
