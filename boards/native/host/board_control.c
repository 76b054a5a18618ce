/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The board's models on the command line and the control socket: --ambient; outputs, edges, set,
 * gpio; faults of the thermistor and of threads.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "devices/bridge.h"
#include "host/carry.h"
#include "host/clock.h"
#include "host/control.h"
#include "host/hardware.h"
#include "host/module.h"
#include "host/prng.h"
#include "host/reset.h"
#include "kernel/port.h"
#include "models/board.h"

#define AMBIENT_DEFAULT_MDEGC 25000
#define TEMP_LOW_MDEGC        (-100000)
#define TEMP_HIGH_MDEGC       300000
#define EDGES_MAX             10000
#define STALLED_MAX           8
#define STALLED_NAME_MAX      16
#define PULSE_MAX_US          3600000000
#define DELAY_MAX_US          INT32_MAX

static int64_t ambient_mdegc = AMBIENT_DEFAULT_MDEGC;

/* What this module remembers over a reset, besides the models. */
static struct {
	uint64_t edges_cursor; /* next change that "edges" reports */
	uint32_t resets;
	char stalled[STALLED_MAX][STALLED_NAME_MAX]; /* threads that do not run from a reset on */
} world;

static int64_t now_us(void)
{
	return (int64_t)clock_board_us();
}

static int64_t to_mdegc(double temp_c)
{
	return llround(temp_c * 1000.0);
}

static json_t *lines_object(void)
{
	const uint32_t levels = board_lines_read();
	json_t *object = json_object();

	for (uint32_t line = 0; line < BOARD_LINE_COUNT; line++) {
		control_put_integer(object, board_line_name(line), (levels >> line) & 1u);
	}
	return object;
}

static json_t *pwm_array(void)
{
	json_t *array = json_array();

	for (size_t channel = 0; channel < BOARD_PWM_COUNT; channel++) {
		const struct board_pwm *pwm = &board.pwm[channel];
		json_t *object = json_object();

		control_put_integer(object, "period_ns", pwm->period_ns);
		control_put_integer(object, "pulse_ns", pwm->pulse_ns);
		json_array_append_new(array, object);
	}
	return array;
}

static json_t *servos_object(void)
{
	json_t *object = json_object();

	for (uint32_t servo = 0; servo < BOARD_SERVO_COUNT; servo++) {
		json_t *one = json_object();

		control_put_integer(one, "angle_mdeg", llround(board.servos[servo].angle_mdeg));
		control_put_integer(one, "pulse_ns", board.servos[servo].pulse_ns);
		json_object_set_new(object, board_servo_name(servo), one);
	}
	return object;
}

static json_t *lcd_object(void)
{
	json_t *object = json_object();
	json_t *lines = json_array();

	for (size_t line = 0; line < LCD_LINES; line++) {
		json_array_append_new(lines, json_stringn(board.lcd.text[line], LCD_COLUMNS));
	}
	control_put_bool(object, "on", board.lcd.on);
	json_object_set_new(object, "lines", lines);
	return object;
}

static void put_lamp(json_t *reply)
{
	const struct lamp *lamp = &board.lamp;

	control_put_integer(reply, "level_ppm", lamp->level_ppm);
	control_put_integer(reply, "duty_ppm", lamp->duty_ppm);
	control_put_integer(reply, "peak_ppm", lamp->peak_ppm);
	control_put_integer(reply, "energy_mj", llround(lamp_energy_mj(lamp)));
	control_put_integer(reply, "light_us", (int64_t)lamp->light_us);
	control_put_integer(reply, "lit_us", (int64_t)lamp->lit_us);
	control_put_integer(reply, "edges", (int64_t)lamp->edges);
	control_put_integer(reply, "changes", (int64_t)lamp->changes);
}

static void put_probes(json_t *reply)
{
	for (unsigned int channel = 0; channel < BOARD_PROBE_COUNT; channel++) {
		if (board_probe_name(channel) != NULL) {
			control_put_integer(reply, board_probe_name(channel),
			                    board.probes[channel]);
		}
	}
}

static enum control_result run_outputs(struct control_call *call)
{
	bool reset = false;

	if (json_object_get(call->request, "reset") != NULL &&
	    !control_bool(call, "reset", &reset)) {
		return CONTROL_ERROR;
	}
	board_advance(now_us());
	control_put_integer(call->reply, "now_us", now_us());
	put_lamp(call->reply);
	put_probes(call->reply);
	control_put_integer(call->reply, "temp_mdegc", to_mdegc(board.housing.temp_c));
	control_put_integer(call->reply, "ambient_mdegc", to_mdegc(board.housing.ambient_c));
	control_put_bool(call->reply, "fan", !board.housing.fan_failed);
	json_object_set_new(call->reply, "lines", lines_object());
	json_object_set_new(call->reply, "pwm", pwm_array());
	json_object_set_new(call->reply, "servos", servos_object());
	json_object_set_new(call->reply, "lcd", lcd_object());
	control_put_integer(call->reply, "focus_ppm", focus_motor_ppm(&board.focus));
	control_put_bool(call->reply, "unprotected", hardware_is_unprotected());
	control_put_integer(call->reply, "resets", world.resets);
	control_put_string(call->reply, "reset_cause", reset_cause_name(reset_last_cause()));
	control_put_integer(call->reply, "reset_us", (int64_t)clock_boot_us());
	if (reset) {
		lamp_reset_totals(&board.lamp, now_us());
	}
	return CONTROL_OK;
}

static enum control_result run_edges(struct control_call *call)
{
	const struct lamp *lamp = &board.lamp;
	const uint64_t oldest = lamp_oldest_change(lamp);
	int64_t max = 1000;
	int64_t since = (int64_t)world.edges_cursor;
	json_t *edges;
	uint64_t next;
	uint64_t end;

	if (!control_integer_or(call, "max", 0, EDGES_MAX, &max) ||
	    !control_integer_or(call, "since", 0, (int64_t)lamp->changes, &since)) {
		return CONTROL_ERROR;
	}
	next = (uint64_t)since < oldest ? oldest : (uint64_t)since;
	control_put_integer(call->reply, "lost", (int64_t)next - since);
	end = lamp->changes - next > (uint64_t)max ? next + (uint64_t)max : lamp->changes;
	edges = json_array();
	for (; next < end; next++) {
		const struct lamp_change *change = lamp_change_at(lamp, next);

		json_array_append_new(edges, json_pack("[I, I]", (json_int_t)change->time_us,
		                                       (json_int_t)change->level_ppm));
	}
	world.edges_cursor = next;
	json_object_set_new(call->reply, "edges", edges);
	control_put_integer(call->reply, "next", (int64_t)next);
	control_put_bool(call->reply, "more", next < lamp->changes);
	return CONTROL_OK;
}

static enum control_result run_set(struct control_call *call)
{
	int64_t ambient = to_mdegc(board.housing.ambient_c);
	int64_t temp = INT64_MAX;
	bool fan = !board.housing.fan_failed;
	const char *field;
	json_t *value;

	json_object_foreach(call->request, field, value)
	{
		if (strcmp(field, "op") != 0 && strcmp(field, "id") != 0 &&
		    strcmp(field, "ambient_mdegc") != 0 && strcmp(field, "temp_mdegc") != 0 &&
		    strcmp(field, "fan") != 0) {
			return control_fail(
				call, "set: no '%s'; there are ambient_mdegc, temp_mdegc, fan",
				field);
		}
	}
	if (!control_integer_or(call, "ambient_mdegc", TEMP_LOW_MDEGC, TEMP_HIGH_MDEGC, &ambient) ||
	    !control_integer_or(call, "temp_mdegc", TEMP_LOW_MDEGC, TEMP_HIGH_MDEGC, &temp) ||
	    (json_object_get(call->request, "fan") != NULL && !control_bool(call, "fan", &fan))) {
		return CONTROL_ERROR;
	}
	thermal_mass_set_ambient(&board.housing, now_us(), (double)ambient * 1e-3);
	thermal_mass_set_fan(&board.housing, now_us(), !fan);
	if (temp != INT64_MAX) {
		thermal_mass_set_temp(&board.housing, now_us(), (double)temp * 1e-3);
	}
	return CONTROL_OK;
}

static bool find_line(struct control_call *call, uint32_t *line)
{
	const char *name;

	if (!control_string(call, "line", &name)) {
		return false;
	}
	for (*line = 0; *line < BOARD_LINE_COUNT; (*line)++) {
		if (strcmp(board_line_name(*line), name) == 0) {
			return true;
		}
	}
	(void)control_fail(call, "gpio: no line '%s'; outputs lists them", name);
	return false;
}

static enum control_result run_gpio(struct control_call *call)
{
	int64_t value;
	int64_t pulse_us = 0;
	bool release = false;
	uint32_t line;

	if (!find_line(call, &line) ||
	    !control_integer_or(call, "pulse_us", 1, PULSE_MAX_US, &pulse_us) ||
	    (json_object_get(call->request, "release") != NULL &&
	     !control_bool(call, "release", &release))) {
		return CONTROL_ERROR;
	}
	if (release) {
		bridge_line_pulse_stop(line);
		board_line_release(now_us(), line);
		return CONTROL_OK;
	}
	if (!control_integer(call, "value", 0, 1, &value)) {
		return CONTROL_ERROR;
	}
	if (pulse_us > 0) {
		bridge_line_pulse(line, value != 0, (uint32_t)pulse_us);
	} else {
		bridge_line_pulse_stop(line);
		board_line_drive(now_us(), line, value != 0);
	}
	return CONTROL_OK;
}

static enum control_result fault_thermistor(struct control_call *call)
{
	static const char *const kinds[NTC_FAULT_COUNT] = {
		[NTC_FAULT_NONE] = "none",   [NTC_FAULT_OPEN] = "open",
		[NTC_FAULT_SHORT] = "short", [NTC_FAULT_STUCK] = "stuck",
		[NTC_FAULT_NOISY] = "noisy",
	};
	const char *kind;

	if (!control_string(call, "kind", &kind)) {
		return CONTROL_ERROR;
	}
	for (int i = 0; i < NTC_FAULT_COUNT; i++) {
		if (strcmp(kinds[i], kind) == 0) {
			ntc_input_set_fault(&board.thermistor, (enum ntc_fault)i);
			return CONTROL_OK;
		}
	}
	return control_fail(
		call, "thermistor: no kind '%s'; there are none, open, short, stuck, noisy", kind);
}

bool port_thread_stalled(const char *name)
{
	for (size_t i = 0; i < STALLED_MAX; i++) {
		if (name[0] != '\0' && strcmp(world.stalled[i], name) == 0) {
			return true;
		}
	}
	return false;
}

/* True: that changes something. */
static bool stall_at_start(const char *name, bool stalled)
{
	for (size_t i = 0; i < STALLED_MAX; i++) {
		if (strcmp(world.stalled[i], name) == 0 ||
		    (stalled && world.stalled[i][0] == '\0')) {
			(void)snprintf(world.stalled[i], STALLED_NAME_MAX, "%s",
			               stalled ? name : "");
			return true;
		}
	}
	return false;
}

static enum control_result fault_thread(struct control_call *call)
{
	const char *kind;
	const char *name;
	char names[160];

	if (!control_string(call, "kind", &kind) || !control_string(call, "name", &name)) {
		return CONTROL_ERROR;
	}
	const bool at_start = strcmp(kind, "stalled at start") == 0;
	const bool none = strcmp(kind, "none") == 0;

	if (!at_start && !none && strcmp(kind, "stalled") != 0) {
		return control_fail(
			call, "thread: no kind '%s'; there are none, stalled, stalled at start",
			kind);
	}
	const bool changed = (at_start || none) && stall_at_start(name, at_start);

	if (!at_start && !bridge_stall_thread(name, !none, names, sizeof(names)) && !changed) {
		return control_fail(call, "thread: no '%s'; there are %s", name, names);
	}
	return CONTROL_OK;
}

static bool find_chip(struct control_call *call, uint32_t *chip)
{
	const char *name;

	if (!control_string(call, "name", &name)) {
		return false;
	}
	for (*chip = 0; *chip < BOARD_CHIP_COUNT; (*chip)++) {
		if (strcmp(board_chip_name(*chip), name) == 0) {
			return true;
		}
	}
	(void)control_fail(call,
	                   "chip: no '%s'; there are adc, pwm, gpio, counter, watchdog, uart0 … "
	                   "uart3, can0, imc, storage, flash",
	                   name);
	return false;
}

static enum control_result fault_chip(struct control_call *call)
{
	static const char *const kinds[] = {
		[BOARD_FAULT_NONE] = "none",
		[BOARD_FAULT_LATE] = "late",
		[BOARD_FAULT_NEVER] = "never",
		[BOARD_FAULT_ERROR] = "error",
	};
	const char *kind;
	int64_t delay_us = 0;
	uint32_t chip;

	if (!control_string(call, "kind", &kind) || !find_chip(call, &chip)) {
		return CONTROL_ERROR;
	}
	if (strcmp(kind, "running") == 0 && chip == BOARD_CHIP_WATCHDOG) {
		board.watchdog_at_boot = true;
		return CONTROL_OK;
	}
	for (size_t i = 0; i < sizeof(kinds) / sizeof(kinds[0]); i++) {
		if (strcmp(kinds[i], kind) != 0) {
			continue;
		}
		if (i == BOARD_FAULT_LATE &&
		    !control_integer(call, "delay_us", 1, DELAY_MAX_US, &delay_us)) {
			return CONTROL_ERROR;
		}
		board.watchdog_at_boot &= chip != BOARD_CHIP_WATCHDOG;
		board.faults[chip] =
			(struct board_fault){(enum board_fault_kind)i, (uint32_t)delay_us};
		return CONTROL_OK;
	}
	return control_fail(call, "chip: no kind '%s'; there are none, late, never, error%s", kind,
	                    chip == BOARD_CHIP_WATCHDOG ? ", running" : "");
}

static int parse_ambient(const char *value, struct host_error *error)
{
	char *end;
	const double celsius = strtod(value, &end);

	if (end == value || *end != '\0' || !(celsius >= TEMP_LOW_MDEGC / 1000) ||
	    !(celsius <= TEMP_HIGH_MDEGC / 1000)) {
		return host_error_set(error, "'%s' is no temperature of %d to %d degrees Celsius",
		                      value, TEMP_LOW_MDEGC / 1000, TEMP_HIGH_MDEGC / 1000);
	}
	ambient_mdegc = to_mdegc(celsius);
	return 0;
}

static int start(void)
{
	struct prng prng;

	if (!carry_register("board", &board, sizeof(board))) {
		prng_init(&prng, "board");
		board_init((double)ambient_mdegc * 1e-3, prng_next(&prng));
	}
	(void)carry_register("board.world", &world, sizeof(world));
	world.resets += carry_is_reset() ? 1 : 0;
	return 0;
}

static void off(void)
{
	board_mcu_reset(now_us());
}

static const struct host_option options[] = {
	{"ambient", "CELSIUS", "temperature around the lamp (default 25)", parse_ambient},
	{0},
};

static const struct control_op ops[] = {
	{"outputs",
         "lamp, temperature, lines, PWM, servos, commanded values and resets; reset: true starts "
         "energy_mj, "
         "light_us, lit_us and peak_ppm anew",
         run_outputs},
	{"edges",
         "changes of the lamp's level as [board time in us, ppm], from number `since` (default: "
         "after "
         "the last that was reported), at most `max` (1000)",
         run_edges},
	{"set", "ambient_mdegc, fan (false: failed), temp_mdegc (of the lamp, now)", run_set},
	{"gpio",
         "line, value 0 or 1: drives a line; pulse_us: for so long, then the opposite; release: "
         "true "
         "lets go of it",
         run_gpio},
	{0},
};

static const struct control_fault faults[] = {
	{"thermistor", "none, open, short, stuck, noisy", fault_thermistor},
	{"thread", "none, stalled, stalled at start (from the next reset on); name: the thread's",
         fault_thread},
	{"chip",
         "none, late (delay_us), never, error; name: adc, pwm, gpio, counter, watchdog (also: "
         "running), uart0 … uart3, can0, imc, storage, flash",
         fault_chip},
	{0},
};

HOST_MODULE(board_module) = {
	.name = "board",
	.order = HOST_ORDER_BOARD,
	.options = options,
	.ops = ops,
	.faults = faults,
	.start = start,
	.off = off,
};
