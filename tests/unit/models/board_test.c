/* SPDX-License-Identifier: Apache-2.0 */
/* What is wired to what, and that the defaults heat up as promised in models/board.c. */
#include <zephyr/ztest.h>

#include "models/board.h"

#define S INT64_C(1000000)

#define ENABLE (1u << BOARD_LINE_LAMP_ENABLE)
#define POWER                                                                                      \
	(1u << BOARD_LINE_POWER_LAMP | 1u << BOARD_LINE_POWER_GIMBAL |                             \
	 1u << BOARD_LINE_POWER_CAMERA | 1u << BOARD_LINE_POWER_AUX)

static int lit_changes;

static void light_changed(int64_t now_us)
{
	lit_changes++;
}

static struct board saved;
static struct board_listener saved_listener;
static void (*saved_interrupt)(uint32_t before, uint32_t after);

/* The board of this very process is put aside. */
static void before(void *fixture)
{
	saved = board;
	saved_listener = board_listener;
	saved_interrupt = board_lines_interrupt;
	board_listener = (struct board_listener){.light = light_changed};
	board_lines_interrupt = NULL;
	lit_changes = 0;
	board_init(25.0, 1);
}

static void after(void *fixture)
{
	board = saved;
	board_listener = saved_listener;
	board_lines_interrupt = saved_interrupt;
}

static void light_up(int64_t now_us, uint32_t percent)
{
	board_lines_configure(now_us, ENABLE, ENABLE, 0);
	zassert_ok(board_pwm_set(now_us, BOARD_PWM_LAMP, 1000, percent * 10u, 2000000));
}

static double steady_c(double ambient_c, bool fan_failed)
{
	thermal_mass_set_ambient(&board.housing, board.housing.time_us, ambient_c);
	thermal_mass_set_fan(&board.housing, board.housing.time_us, fan_failed);
	board_advance(board.housing.time_us + 36000 * S);
	return board.housing.temp_c;
}

ZTEST(board, test_full_power_heats_as_promised)
{
	/* heat: 0.7 * 30 W + 4 W = 25 W */
	light_up(0, 100);
	zassert_within(steady_c(25.0, false), 25.0 + 25.0 * 1.6, 0.001);
	zassert_within(steady_c(55.0, false), 95.0, 0.001);
	light_up(board.housing.time_us, 0);
	/* the electronics alone, 4 W * 12.5 K/W, pass any default shutdown temperature */
	zassert_within(steady_c(55.0, true), 105.0, 0.001);
}

ZTEST(board, test_pwm_and_enable_line_make_light)
{
	zassert_ok(board_pwm_set(0, BOARD_PWM_LAMP, 1000000, 250000, 2000000000));
	zassert_equal(board.lamp.level_ppm, 0);
	board_lines_configure(5, ENABLE, ENABLE, 0);
	zassert_equal(board.lamp.level_ppm, 250000);
	zassert_equal(board.pwm[BOARD_PWM_LAMP].period_ns, 500000);
	zassert_equal(board.pwm[BOARD_PWM_LAMP].pulse_ns, 125000);
	zassert_equal(lit_changes, 1);
	zassert_equal(lamp_change_at(&board.lamp, 0)->time_us, 5);
	zassert_ok(board_pwm_set(6, BOARD_PWM_AUX0, 1000, 500, 1000));
	zassert_equal(board.lamp.level_ppm, 250000, "another channel is not the lamp");
	zassert_equal(board_pwm_set(6, BOARD_PWM_COUNT, 1000, 500, 1000), -1);
}

ZTEST(board, test_reset_puts_the_lamp_out_at_that_instant)
{
	light_up(0, 100);
	board_line_drive(1 * S, BOARD_LINE_SYNC, true);
	board_probe(1 * S, 3, 7);
	board_mcu_reset(2 * S);
	zassert_equal(board.lamp.level_ppm, 0);
	zassert_equal(lamp_change_at(&board.lamp, board.lamp.changes - 1)->time_us, 2 * S);
	zassert_equal(board.probes[3], 0);
	zassert_equal(board_lines_read() & ~POWER, 1u << BOARD_LINE_SYNC, "the world goes on");
	zassert_within(lamp_energy_mj(&board.lamp), 60000.0, 1e-6);
}

ZTEST(board, test_lamp_needs_the_power_that_a_floating_switch_gives)
{
	const uint32_t power = 1u << BOARD_LINE_POWER_LAMP;

	light_up(0, 50);
	zassert_equal(board_lines_read() & POWER, POWER);
	zassert_equal(board.lamp.level_ppm, 500000);
	board_lines_configure(1 * S, ENABLE | power, ENABLE, 0);
	zassert_equal(board.lamp.level_ppm, 0);
	board_lines_configure(2 * S, ENABLE | power, ENABLE | power, 0);
	zassert_equal(board.lamp.level_ppm, 500000);
}

ZTEST(board, test_focus_motor_follows_its_lines)
{
	const uint32_t in = 1u << BOARD_LINE_FOCUS_IN;
	const uint32_t out = 1u << BOARD_LINE_FOCUS_OUT;

	board_lines_configure(0, in | out, in, 0);
	board_lines_configure(3 * S, in | out, out, 0);
	board_advance(4 * S);
	/* 3 of 4 s in, 1 out */
	zassert_equal(focus_motor_ppm(&board.focus), 500000);
	board_mcu_reset(4 * S);
	board_advance(60 * S);
	zassert_equal(focus_motor_ppm(&board.focus), 500000, "nobody drives it");
}

static int probed;

static void probe_seen(int64_t now_us, unsigned int channel, int64_t value)
{
	probed++;
}

ZTEST(board, test_same_command_is_news_the_same_setting_is_not)
{
	board_listener.probe = probe_seen;
	probed = 0;
	board_probe(1, 5, 300000);
	board_probe(2, 5, 300000);
	zassert_equal(probed, 1);
	board_probe(3, BOARD_PROBE_COMMAND, 405);
	board_probe(4, BOARD_PROBE_COMMAND, 405);
	zassert_equal(probed, 3);
	board_probe(5, BOARD_PROBE_COUNT, 1);
	zassert_equal(probed, 3);
	zassert_is_null(board_probe_name(BOARD_PROBE_COUNT));
}

ZTEST(board, test_world_cannot_light_the_lamp_against_the_mcu)
{
	light_up(0, 50);
	board_lines_configure(1, ENABLE, 0, 0);
	board_line_drive(2, BOARD_LINE_LAMP_ENABLE, true);
	zassert_equal(board.lamp.level_ppm, 0);
	board_line_release(3, BOARD_LINE_LAMP_ENABLE);
	zassert_equal(board.lamp.level_ppm, 0);
}

ZTEST_SUITE(board, NULL, NULL, before, after, NULL);
