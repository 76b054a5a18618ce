/* SPDX-License-Identifier: Apache-2.0 */
/* The light driver, seen at the lamp of the board's model. */
#include <zephyr/devicetree.h>
#include <zephyr/irq_offload.h>
#include <zephyr/ztest.h>

#include <pharos/drivers/light.h>

#include "models/board.h"

static const struct device *const light = DEVICE_DT_GET(DT_ALIAS(light0));

static uint32_t lamp_ppm(void)
{
	return board.lamp.level_ppm;
}

static void before(void *fixture)
{
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
