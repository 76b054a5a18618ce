/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The board around the MCU: which model is wired to which pin. The drivers in boards/native/devices
 * use the first part, as registers; the host (control socket, recorder) the second, as the world.
 *
 * All times are board times in microseconds. No host and no Zephyr headers.
 */
#ifndef NATIVE_MODELS_BOARD_H_
#define NATIVE_MODELS_BOARD_H_

#include <stdbool.h>
#include <stdint.h>

#include "models/focus_motor.h"
#include "models/lamp.h"
#include "models/lcd.h"
#include "models/lines.h"
#include "models/ntc_input.h"
#include "models/servo.h"
#include "models/thermal_mass.h"

enum board_pwm_channel {
	BOARD_PWM_LAMP,
	BOARD_PWM_SERVO_PAN,
	BOARD_PWM_SERVO_TILT,
	BOARD_PWM_AUX0,
	BOARD_PWM_AUX1,
	BOARD_PWM_THRUSTER,
	BOARD_PWM_LED_STATUS,
	BOARD_PWM_LED_SIGNAL,
	BOARD_PWM_COUNT,
};

enum board_adc_channel {
	BOARD_ADC_THERMISTOR,
	BOARD_ADC_COUNT,
};

enum board_line {
	BOARD_LINE_LAMP_ENABLE,
	BOARD_LINE_SYNC,
	BOARD_LINE_BUTTON,
	BOARD_LINE_DRIVER_FAULT,
	BOARD_LINE_OUT0,
	BOARD_LINE_OUT1,
	BOARD_LINE_IN0,
	BOARD_LINE_IN1,
	BOARD_LINE_POWER_LAMP, /* switches of the power channels, closed unless driven low */
	BOARD_LINE_POWER_GIMBAL,
	BOARD_LINE_POWER_CAMERA,
	BOARD_LINE_POWER_AUX,
	BOARD_LINE_FOCUS_IN,
	BOARD_LINE_FOCUS_OUT,
	BOARD_LINE_COUNT,
};

enum board_servo {
	BOARD_SERVO_PAN,
	BOARD_SERVO_TILT,
	BOARD_SERVO_COUNT,
};

/* Chips, in the MCU or beside it, whose failing can be injected. */
enum board_chip {
	BOARD_CHIP_ADC,
	BOARD_CHIP_PWM,
	BOARD_CHIP_GPIO,
	BOARD_CHIP_COUNTER, /* that times the edges of inputs */
	BOARD_CHIP_WATCHDOG,
	BOARD_CHIP_UART0,
	BOARD_CHIP_UART1,
	BOARD_CHIP_UART2,
	BOARD_CHIP_UART3,
	BOARD_CHIP_CAN,
	BOARD_CHIP_IMC,
	BOARD_CHIP_STORAGE,
	BOARD_CHIP_FLASH, /* of the image slots */
	BOARD_CHIP_COUNT,
};

enum board_fault_kind {
	BOARD_FAULT_NONE,
	BOARD_FAULT_LATE,  /* answers after delay_us */
	BOARD_FAULT_NEVER, /* does not answer */
	BOARD_FAULT_ERROR, /* answers with an error, and its driver does not start */
};

struct board_fault {
	enum board_fault_kind kind;
	uint32_t delay_us;
};

#define BOARD_PROBE_COUNT   16
#define BOARD_PROBE_COMMAND 10u /* an event: the same value again is news */

struct board_pwm {
	uint32_t period_ns;
	uint32_t pulse_ns; /* active time of each period */
	uint32_t duty_ppm;
};

/* Everything that has a memory; plain data, and so carried over a reset of the MCU. */
struct board {
	struct lamp lamp;
	struct thermal_mass housing;
	struct ntc_input thermistor;
	struct lines lines;
	struct focus_motor focus;
	struct lcd lcd;
	int64_t edge_us[BOARD_LINE_COUNT]; /* when the world last drove the line */
	struct board_pwm pwm[BOARD_PWM_COUNT];
	struct servo servos[BOARD_SERVO_COUNT];
	int64_t probes[BOARD_PROBE_COUNT];
	struct board_fault faults[BOARD_CHIP_COUNT];
	bool watchdog_at_boot; /* its driver starts it, as STM32's does from Zephyr 4.2 on */
};

extern struct board board;

/* Told of each change; NULL: nobody listens. */
struct board_listener {
	void (*light)(int64_t now_us);
	void (*temperature)(int64_t now_us, double temp_c); /* at each conversion */
	void (*lines)(int64_t now_us, uint32_t levels);
	void (*servo)(int64_t now_us, uint32_t servo); /* its pulses have changed */
	void (*probe)(int64_t now_us, unsigned int channel, int64_t value);
};

extern struct board_listener board_listener;

/*
 * Told of every change of a line or of the light, before all others: carries the outputs to where
 * the board is real. NULL: nobody does.
 */
extern void (*board_outside)(void);

/* The same of a PWM output; the lamp's is its light. */
extern void (*board_pwm_outside)(uint32_t channel);

/* A bit for each PWM output that is real and away: writing to it fails. */
extern uint32_t board_pwm_away;

/* The MCU's interrupt controller: line levels have changed. Set by the GPIO device. */
extern void (*board_lines_interrupt)(uint32_t before, uint32_t after);

/* --- as registers --- */

/* 0, or -1: no such channel. pulse <= period, in cycles of hz. */
int board_pwm_set(int64_t now_us, uint32_t channel, uint32_t period, uint32_t pulse, uint64_t hz);

/* count conversions of a channel, all at the same instant. 0, or -1: no such channel. */
int board_adc_convert(int64_t now_us, uint32_t channel, unsigned int bits, uint16_t *codes,
                      unsigned int count, unsigned int stride);

/* Directions, levels and pulls at once. */
void board_lines_configure(int64_t now_us, uint32_t output, uint32_t level, uint32_t pull_up);
uint32_t board_lines_read(void);

void board_probe(int64_t now_us, unsigned int channel, int64_t value);

/* --- as the world --- */

void board_init(double ambient_c, uint64_t seed);

/* The MCU is in reset from now on: its pins float, so the lamp is dark. */
void board_mcu_reset(int64_t now_us);

/* Brings all models to now_us. */
void board_advance(int64_t now_us);

/* Drives a line from outside. */
void board_line_drive(int64_t now_us, uint32_t line, bool level);

/* The same, of an edge that happened at edge_us and is told now. */
void board_line_drive_late(int64_t now_us, uint32_t line, bool level, int64_t edge_us);

/* Lets go of it. */
void board_line_release(int64_t now_us, uint32_t line);

/* "lamp_enable", "sync", "button", …; NULL: no such line. */
const char *board_line_name(uint32_t line);

/* "pan", "tilt"; NULL: no such servo. */
const char *board_servo_name(uint32_t servo);

/* "adc", "pwm", …; NULL: no such chip. */
const char *board_chip_name(uint32_t chip);

/* "limit_ppm", "gate", …: the name of a probe channel; NULL: no such channel. */
const char *board_probe_name(unsigned int channel);

#endif
