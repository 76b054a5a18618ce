/* SPDX-License-Identifier: Apache-2.0 */
#include "models/board.h"

#include <stddef.h>
#include <string.h>

/*
 * A 30 W lamp, of which 30 % becomes light, in a housing that also holds electronics of 4 W. Steady
 * at 100 %: 65 degC in 25 degC ambient; 95 degC in 55 degC ambient (so it throttles). With the fan
 * failed, the electronics alone bring it to 50 K above ambient: 105 degC in 55 degC ambient (so it
 * shuts down).
 */
#define LAMP_FULL_MW  30000u
#define LAMP_HEAT     0.7
#define ELECTRONICS_W 4.0

/* From flood to spot. */
#define FOCUS_TRAVEL_US 4000000

/* Pulled up on the board: a switch is closed until the device opens it. */
#define POWER_LINES                                                                                \
	(1u << BOARD_LINE_POWER_LAMP | 1u << BOARD_LINE_POWER_GIMBAL |                             \
	 1u << BOARD_LINE_POWER_CAMERA | 1u << BOARD_LINE_POWER_AUX)

static const struct thermal_mass_params housing_params = {
	.capacity_j_per_k = 60.0,
	.fan_k_per_w = 1.6,
	.no_fan_k_per_w = 12.5,
};

/* As in native.dts. */
static const struct ntc_input_params thermistor_params = {
	.pullup_ohms = 10000.0,
	.r25_ohms = 10000.0,
	.beta_k = 3435.0,
	.noise_lsb = 0.5,
	.noisy_noise_lsb = 400.0,
};

static const char *const line_names[BOARD_LINE_COUNT] = {
	[BOARD_LINE_LAMP_ENABLE] = "lamp_enable",
	[BOARD_LINE_SYNC] = "sync",
	[BOARD_LINE_BUTTON] = "button",
	[BOARD_LINE_DRIVER_FAULT] = "driver_fault",
	[BOARD_LINE_OUT0] = "out0",
	[BOARD_LINE_OUT1] = "out1",
	[BOARD_LINE_IN0] = "in0",
	[BOARD_LINE_IN1] = "in1",
	[BOARD_LINE_POWER_LAMP] = "power_lamp",
	[BOARD_LINE_POWER_GIMBAL] = "power_gimbal",
	[BOARD_LINE_POWER_CAMERA] = "power_camera",
	[BOARD_LINE_POWER_AUX] = "power_aux",
	[BOARD_LINE_FOCUS_IN] = "focus_in",
	[BOARD_LINE_FOCUS_OUT] = "focus_out",
};

/* In the order of <pharos/drivers/probe.h>. */
static const char *const probe_names[BOARD_PROBE_COUNT] = {
	"light_level_ppm",
	"limit_ppm",
	"gate",
	"enable",
	"mode",
	"brightness_ppm",
	"strobe_period_us",
	"strobe_duty_ppm",
	"thermal_state",
	"measured_mdegc",
	"command",
};

static const char *const chip_names[BOARD_CHIP_COUNT] = {
	[BOARD_CHIP_ADC] = "adc",           [BOARD_CHIP_PWM] = "pwm",
	[BOARD_CHIP_GPIO] = "gpio",         [BOARD_CHIP_COUNTER] = "counter",
	[BOARD_CHIP_WATCHDOG] = "watchdog", [BOARD_CHIP_UART0] = "uart0",
	[BOARD_CHIP_UART1] = "uart1",       [BOARD_CHIP_UART2] = "uart2",
	[BOARD_CHIP_UART3] = "uart3",       [BOARD_CHIP_CAN] = "can0",
	[BOARD_CHIP_IMC] = "imc",           [BOARD_CHIP_STORAGE] = "storage",
	[BOARD_CHIP_FLASH] = "flash",
};

static const char *const servo_names[BOARD_SERVO_COUNT] = {
	[BOARD_SERVO_PAN] = "pan",
	[BOARD_SERVO_TILT] = "tilt",
};

struct board board;
struct board_listener board_listener;
void (*board_outside)(void);
void (*board_pwm_outside)(uint32_t channel);
uint32_t board_pwm_away;
void (*board_lines_interrupt)(uint32_t before, uint32_t after);

void board_init(double ambient_c, uint64_t seed)
{
	memset(&board, 0, sizeof(board));
	lamp_init(&board.lamp, LAMP_FULL_MW);
	thermal_mass_init(&board.housing, &housing_params, ambient_c);
	thermal_mass_set_heat(&board.housing, 0, ELECTRONICS_W);
	ntc_input_init(&board.thermistor, &thermistor_params, seed);
	board.lines.driven = POWER_LINES;
	board.lines.driven_level = POWER_LINES;
	focus_motor_init(&board.focus, FOCUS_TRAVEL_US);
	lcd_reset(&board.lcd);
}

static void outside_changed(void)
{
	if (board_outside != NULL) {
		board_outside();
	}
}

static void pwm_outside_changed(uint32_t channel)
{
	if (board_pwm_outside != NULL) {
		board_pwm_outside(channel);
	}
}

static void light_changed(int64_t now_us)
{
	outside_changed();
	pwm_outside_changed(BOARD_PWM_LAMP);
	thermal_mass_set_heat(&board.housing, now_us,
	                      ELECTRONICS_W + LAMP_HEAT * lamp_power_w(&board.lamp));
	if (board_listener.light != NULL) {
		board_listener.light(now_us);
	}
}

static void pulse_changed(int64_t now_us, uint32_t servo, uint32_t pulse_ns)
{
	servo_set_pulse_ns(&board.servos[servo], now_us, pulse_ns);
	if (board_listener.servo != NULL) {
		board_listener.servo(now_us, servo);
	}
}

int board_pwm_set(int64_t now_us, uint32_t channel, uint32_t period, uint32_t pulse, uint64_t hz)
{
	struct board_pwm *pwm;

	if (channel >= BOARD_PWM_COUNT || period == 0 || hz == 0) {
		return -1;
	}
	pwm = &board.pwm[channel];
	pwm->period_ns = (uint32_t)((period * UINT64_C(1000000000)) / hz);
	pwm->pulse_ns = (uint32_t)((pulse * UINT64_C(1000000000)) / hz);
	pwm->duty_ppm = (uint32_t)((pulse * UINT64_C(1000000)) / period);
	if (channel != BOARD_PWM_LAMP) {
		pwm_outside_changed(channel);
	} else if (lamp_set_duty(&board.lamp, now_us, pwm->duty_ppm)) {
		light_changed(now_us);
	}
	if (channel == BOARD_PWM_SERVO_PAN) {
		pulse_changed(now_us, BOARD_SERVO_PAN, pwm->pulse_ns);
	} else if (channel == BOARD_PWM_SERVO_TILT) {
		pulse_changed(now_us, BOARD_SERVO_TILT, pwm->pulse_ns);
	}
	return 0;
}

int board_adc_convert(int64_t now_us, uint32_t channel, unsigned int bits, uint16_t *codes,
                      unsigned int count, unsigned int stride)
{
	double ratio;

	if (channel >= BOARD_ADC_COUNT) {
		return -1;
	}
	thermal_mass_advance(&board.housing, now_us);
	ratio = ntc_input_ratio(&board.thermistor, board.housing.temp_c);
	for (unsigned int i = 0; i < count; i++) {
		codes[i * stride] = ntc_input_convert(&board.thermistor, ratio, bits);
	}
	if (board_listener.temperature != NULL) {
		board_listener.temperature(now_us, board.housing.temp_c);
	}
	return 0;
}

static bool is_high(uint32_t levels, enum board_line line)
{
	return (levels & (1u << line)) != 0;
}

static void lines_changed(int64_t now_us, uint32_t before)
{
	const uint32_t after = lines_levels(&board.lines);

	if (after == before) {
		return;
	}
	outside_changed();
	focus_motor_run(&board.focus, now_us, is_high(after, BOARD_LINE_FOCUS_IN),
	                is_high(after, BOARD_LINE_FOCUS_OUT));
	if (lamp_set_enable(&board.lamp, now_us,
	                    is_high(after, BOARD_LINE_LAMP_ENABLE) &&
	                            is_high(after, BOARD_LINE_POWER_LAMP))) {
		light_changed(now_us);
	}
	if (board_listener.lines != NULL) {
		board_listener.lines(now_us, after);
	}
	if (board_lines_interrupt != NULL) {
		board_lines_interrupt(before, after);
	}
}

void board_lines_configure(int64_t now_us, uint32_t output, uint32_t level, uint32_t pull_up)
{
	const uint32_t before = lines_levels(&board.lines);

	board.lines.output = output;
	board.lines.output_level = level;
	board.lines.pull_up = pull_up;
	lines_changed(now_us, before);
}

uint32_t board_lines_read(void)
{
	return lines_levels(&board.lines);
}

void board_probe(int64_t now_us, unsigned int channel, int64_t value)
{
	if (channel >= BOARD_PROBE_COUNT ||
	    (board.probes[channel] == value && channel != BOARD_PROBE_COMMAND)) {
		return;
	}
	board.probes[channel] = value;
	if (board_listener.probe != NULL) {
		board_listener.probe(now_us, channel, value);
	}
}

void board_mcu_reset(int64_t now_us)
{
	const uint32_t before = lines_levels(&board.lines);

	/* first: a chip in reset takes no interrupts */
	board_lines_interrupt = NULL;
	lines_reset(&board.lines);
	lines_changed(now_us, before);
	for (uint32_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		board.pwm[channel] = (struct board_pwm){0};
		if (channel != BOARD_PWM_LAMP) {
			pwm_outside_changed(channel);
		}
	}
	for (uint32_t servo = 0; servo < BOARD_SERVO_COUNT; servo++) {
		pulse_changed(now_us, servo, 0);
	}
	if (lamp_set_duty(&board.lamp, now_us, 0)) {
		light_changed(now_us);
	}
	lcd_reset(&board.lcd);
	for (unsigned int channel = 0; channel < BOARD_PROBE_COUNT; channel++) {
		board_probe(now_us, channel, 0);
	}
}

void board_advance(int64_t now_us)
{
	lamp_advance(&board.lamp, now_us);
	thermal_mass_advance(&board.housing, now_us);
	for (uint32_t servo = 0; servo < BOARD_SERVO_COUNT; servo++) {
		servo_advance(&board.servos[servo], now_us);
	}
	focus_motor_advance(&board.focus, now_us);
}

void board_line_drive_late(int64_t now_us, uint32_t line, bool level, int64_t edge_us)
{
	const uint32_t before = lines_levels(&board.lines);
	const uint32_t bit = 1u << line;

	board.edge_us[line] = edge_us;
	board.lines.driven |= bit;
	board.lines.driven_level =
		level ? board.lines.driven_level | bit : board.lines.driven_level & ~bit;
	lines_changed(now_us, before);
}

void board_line_drive(int64_t now_us, uint32_t line, bool level)
{
	board_line_drive_late(now_us, line, level, now_us);
}

void board_line_release(int64_t now_us, uint32_t line)
{
	const uint32_t before = lines_levels(&board.lines);

	board.edge_us[line] = now_us;
	board.lines.driven &= ~(1u << line);
	lines_changed(now_us, before);
}

const char *board_line_name(uint32_t line)
{
	return line < BOARD_LINE_COUNT ? line_names[line] : NULL;
}

const char *board_servo_name(uint32_t servo)
{
	return servo < BOARD_SERVO_COUNT ? servo_names[servo] : NULL;
}

const char *board_chip_name(uint32_t chip)
{
	return chip < BOARD_CHIP_COUNT ? chip_names[chip] : NULL;
}

const char *board_probe_name(unsigned int channel)
{
	return channel < BOARD_PROBE_COUNT ? probe_names[channel] : NULL;
}
