/* SPDX-License-Identifier: Apache-2.0 */
/* The light driver, seen at the lamp of the board's model. */
#include <zephyr/devicetree.h>
#include <zephyr/irq_offload.h>
#include <zephyr/ztest.h>

#include <pharos/drivers/light.h>

#include "light/pulse.h"
#include "models/board.h"

static const struct device *const light = DEVICE_DT_GET(DT_ALIAS(light0));

static uint32_t lamp_ppm(void)
{
	return board.lamp.level_ppm;
}

/* Of the PWM or the GPIO controller, whose lines the enable line is one of. */
static void set_fault(enum board_chip chip, enum board_fault_kind kind)
{
	board.faults[chip].kind = kind;
}

static bool line_is_high(void)
{
	return (board_lines_read() & BIT(BOARD_LINE_LAMP_ENABLE)) != 0;
}

static void light_up(uint32_t level_ppm)
{
	zassert_ok(light_set_limit(light, 1000000));
	zassert_ok(light_set_level(light, level_ppm));
	zassert_ok(light_set_gate(light, true));
	zassert_equal(lamp_ppm(), level_ppm);
}

static void before(void *fixture)
{
	set_fault(BOARD_CHIP_PWM, BOARD_FAULT_NONE);
	set_fault(BOARD_CHIP_GPIO, BOARD_FAULT_NONE);
	zassert_ok(light_set_gate(light, false));
	zassert_ok(light_set_level(light, 0));
	zassert_ok(light_set_limit(light, 0));
}

/* The lamp's log starts at power-on: nothing has lit it before the first test did. */
static uint64_t changes_at_boot;

static void *setup(void)
{
	changes_at_boot = board.lamp.changes;
	return NULL;
}

ZTEST(light, test_dark_at_boot)
{
	zassert_true(device_is_ready(light));
	zassert_equal(changes_at_boot, 0);
}

ZTEST(light, test_output_needs_level_limit_and_gate)
{
	zassert_ok(light_set_level(light, 600000));
	zassert_equal(lamp_ppm(), 0);
	zassert_ok(light_set_gate(light, true));
	zassert_equal(lamp_ppm(), 0, "no limit was given yet");
	zassert_ok(light_set_limit(light, 1000000));
	zassert_equal(lamp_ppm(), 600000);
	zassert_ok(light_set_gate(light, false));
	zassert_equal(lamp_ppm(), 0);
}

ZTEST(light, test_output_is_the_minimum_in_every_order)
{
	static const uint32_t values[] = {0, 1, 2, 333333, 500000, 999999, 1000000};

	zassert_ok(light_set_gate(light, true));
	for (size_t i = 0; i < ARRAY_SIZE(values); i++) {
		for (size_t j = 0; j < ARRAY_SIZE(values); j++) {
			zassert_ok(light_set_level(light, values[i]));
			zassert_ok(light_set_limit(light, values[j]));
			zassert_equal(lamp_ppm(), MIN(values[i], values[j]));
			zassert_ok(light_set_limit(light, 1000000));
			zassert_ok(light_set_limit(light, values[j]));
			zassert_ok(light_set_level(light, 1000000));
			zassert_equal(lamp_ppm(), values[j]);
		}
	}
}

ZTEST(light, test_out_of_range_changes_nothing)
{
	struct light_state state;

	zassert_ok(light_set_level(light, 400000));
	zassert_ok(light_set_limit(light, 300000));
	zassert_ok(light_set_gate(light, true));
	zassert_equal(light_set_level(light, 1000001), -EINVAL);
	zassert_equal(light_set_limit(light, UINT32_MAX), -EINVAL);
	light_get(light, &state);
	zassert_equal(state.level_ppm, 400000);
	zassert_equal(state.limit_ppm, 300000);
	zassert_equal(state.output_ppm, 300000);
	zassert_true(state.gate);
	zassert_false(state.off);
	zassert_equal(lamp_ppm(), 300000);
}

/* Steady light is never written: the limit, which comes ten times a second, finds it out. */
ZTEST(light, test_pwm_that_goes_is_found_by_the_next_limit_and_lit_again_once_back)
{
	struct light_state state;

	light_up(700000);
	light_get(light, &state);
	const uint32_t errors = state.errors;

	board_pwm_away = BIT(BOARD_PWM_SERVO_PAN);
	zassert_ok(light_set_limit(light, 1000000), "another channel's");
	board_pwm_away = BIT(BOARD_PWM_LAMP);
	zassert_equal(light_set_limit(light, 1000000), -ENODEV);
	zassert_equal(lamp_ppm(), 0);
	light_get(light, &state);
	zassert_equal(state.error, -ENODEV);
	zassert_equal(state.errors, errors + 1);
	zassert_equal(state.output_ppm, 0);
	zassert_false(state.stuck, "the enable line is low");
	board_pwm_away = 0;
	zassert_ok(light_set_limit(light, 1000000));
	zassert_equal(lamp_ppm(), 700000);
	light_get(light, &state);
	zassert_equal(state.error, 0);
}

ZTEST(light, test_one_change_of_the_lamp_for_each_edge)
{
	uint64_t changes;

	zassert_ok(light_set_level(light, 400000));
	zassert_ok(light_set_limit(light, 1000000));
	changes = board.lamp.changes;
	zassert_ok(light_set_gate(light, true));
	zassert_equal(board.lamp.changes, changes + 1);
	zassert_ok(light_set_gate(light, true));
	zassert_equal(board.lamp.changes, changes + 1);
	zassert_ok(light_set_gate(light, false));
	zassert_equal(board.lamp.changes, changes + 2);
}

ZTEST(light, test_pwm_has_no_flicker)
{
	zassert_ok(light_set_level(light, 250000));
	zassert_ok(light_set_limit(light, 1000000));
	zassert_ok(light_set_gate(light, true));
	/* 2 kHz or faster */
	zassert_true(board.pwm[BOARD_PWM_LAMP].period_ns <= 500000);
	zassert_equal(board.pwm[BOARD_PWM_LAMP].pulse_ns * 4, board.pwm[BOARD_PWM_LAMP].period_ns);
}

static void in_interrupt(const void *arg)
{
	zassert_ok(light_set_gate(light, true));
	zassert_ok(light_set_level(light, 123456));
}

ZTEST(light, test_interrupt_context)
{
	zassert_ok(light_set_limit(light, 1000000));
	irq_offload(in_interrupt, NULL);
	zassert_equal(lamp_ppm(), 123456);
}

/* A sixteenth of full on a PWM of 10 cycles is none; of 17 cycles it is one. */
ZTEST(light, test_pulse_is_never_longer_than_the_output)
{
	static const uint32_t periods[] = {1, 2, 3, 7, 10, 17, 85000, 1000000, UINT32_MAX};
	static const uint32_t outputs[] = {0, 1, 62500, 100001, 333333, 999999, 1000000};

	zassert_equal(light_pulse(62500, 10), 0);
	zassert_equal(light_pulse(62500, 17), 1);
	zassert_equal(light_pulse(1000000, 85000), 85000);
	zassert_equal(light_pulse(999999, 85000), 84999);
	for (size_t i = 0; i < ARRAY_SIZE(periods); i++) {
		for (size_t j = 0; j < ARRAY_SIZE(outputs); j++) {
			const uint64_t pulse = light_pulse(outputs[j], periods[i]);

			zassert_true(pulse * 1000000 <= (uint64_t)outputs[j] * periods[i]);
			zassert_true((pulse + 1) * 1000000 > (uint64_t)outputs[j] * periods[i]);
		}
	}
}

ZTEST(light, test_level_that_the_pwm_does_not_take_is_dark_by_the_enable_line)
{
	struct light_state state;

	light_up(500000);
	set_fault(BOARD_CHIP_PWM, BOARD_FAULT_ERROR);
	zassert_equal(light_set_level(light, 600000), -EIO);
	zassert_equal(lamp_ppm(), 0);
	zassert_false(line_is_high());
	light_get(light, &state);
	zassert_equal(state.output_ppm, 0);
	zassert_equal(state.error, -EIO);
	zassert_false(state.stuck);
	const uint32_t errors = state.errors;

	/* again with each call, dark meanwhile */
	zassert_equal(light_set_limit(light, 900000), -EIO);
	zassert_equal(lamp_ppm(), 0);
	light_get(light, &state);
	zassert_equal(state.errors, errors + 1);
	set_fault(BOARD_CHIP_PWM, BOARD_FAULT_NONE);
	zassert_ok(light_set_limit(light, 900000));
	zassert_equal(lamp_ppm(), 600000);
	light_get(light, &state);
	zassert_equal(state.error, 0);
	zassert_equal(state.errors, errors + 1, "counted, not forgotten");
}

ZTEST(light, test_enable_line_that_cannot_be_taken_back_is_dark_by_the_pwm)
{
	struct light_state state;

	light_up(500000);
	set_fault(BOARD_CHIP_GPIO, BOARD_FAULT_ERROR);
	zassert_equal(light_set_gate(light, false), -EIO);
	zassert_equal(lamp_ppm(), 0);
	zassert_true(line_is_high());
	light_get(light, &state);
	zassert_false(state.stuck);
	/* not even for an instant, while the line does as it likes */
	const uint64_t changes = board.lamp.changes;

	zassert_equal(light_set_gate(light, true), -EIO);
	zassert_equal(board.lamp.changes, changes);
	set_fault(BOARD_CHIP_GPIO, BOARD_FAULT_NONE);
	zassert_ok(light_set_gate(light, true));
	zassert_equal(lamp_ppm(), 500000);
}

ZTEST(light, test_enable_line_that_cannot_be_set_is_dark_by_the_pwm)
{
	zassert_ok(light_set_limit(light, 1000000));
	zassert_ok(light_set_level(light, 500000));
	set_fault(BOARD_CHIP_GPIO, BOARD_FAULT_ERROR);
	zassert_equal(light_set_gate(light, true), -EIO);
	zassert_equal(lamp_ppm(), 0);
	zassert_equal(board.pwm[BOARD_PWM_LAMP].pulse_ns, 0);
}

ZTEST(light, test_lamp_on_which_nothing_has_effect_is_stuck)
{
	struct light_state state;

	light_up(500000);
	set_fault(BOARD_CHIP_PWM, BOARD_FAULT_ERROR);
	set_fault(BOARD_CHIP_GPIO, BOARD_FAULT_ERROR);
	zassert_equal(light_set_limit(light, 0), -EIO);
	light_get(light, &state);
	zassert_true(state.stuck);
	zassert_equal(lamp_ppm(), 500000);
	set_fault(BOARD_CHIP_GPIO, BOARD_FAULT_NONE);
	zassert_equal(light_set_limit(light, 0), -EIO);
	light_get(light, &state);
	zassert_false(state.stuck);
	zassert_equal(lamp_ppm(), 0);
}

/* Runs after all others: nothing lights the lamp again before a reset. */
ZTEST(light_off, test_off_now_is_dark_until_reset)
{
	struct light_state state;

	zassert_ok(light_set_level(light, 1000000));
	zassert_ok(light_set_limit(light, 1000000));
	zassert_ok(light_set_gate(light, true));
	zassert_equal(lamp_ppm(), 1000000);
	zassert_ok(light_off_now(light));
	zassert_equal(lamp_ppm(), 0);
	zassert_ok(light_set_gate(light, false));
	zassert_ok(light_set_gate(light, true));
	zassert_ok(light_set_level(light, 500000));
	zassert_equal(lamp_ppm(), 0);
	light_get(light, &state);
	zassert_true(state.off);
	zassert_equal(state.output_ppm, 0);
}

ZTEST_SUITE(light, NULL, setup, before, NULL, NULL);
ZTEST_SUITE(light_off, NULL, NULL, NULL, NULL, NULL);
