/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the device drives besides its lamp and gimbal: power channels, PWM outputs, indicator LEDs,
 * GPIO lines, a thruster, the beam's zoom and a display; and the power-down of all of it. A board
 * has some of these, or none.
 *
 * The members are commanded through their own functions. actuators_outputs() says what the hardware
 * shall do now: the owner carries out whatever differs from what it did last.
 *
 * Context: the thread that owns it, no locks inside.
 */
#ifndef PHAROS_CORE_ACTUATORS_H
#define PHAROS_CORE_ACTUATORS_H

#include "core/display.h"
#include "core/focus.h"
#include "core/limits.h"
#include "core/power.h"
#include "core/shutdown.h"
#include "core/thruster.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Channel of the lamp's driver. */
#define POWER_CHANNEL_LAMP 0u

/* What the board has. Bit n of a mask is number n; more bits than …_MAX are asserted away. */
struct actuators_config {
	uint32_t power;    /* power channels */
	uint32_t power_on; /* those that are on after this start */
	uint32_t pwms;
	uint32_t leds;
	uint32_t gpio_outputs;
	uint32_t gpio_inputs; /* numbers of their own */
	bool thruster;
	bool focus;
	bool display;
	int64_t grace_us;        /* shutdown.h */
	int64_t focus_travel_us; /* focus.h */
	struct thruster_config thruster_config;
};

/* duty_us <= period_us. period_us 0: never set, the output is idle. */
struct actuators_pwm {
	uint32_t period_us;
	uint32_t duty_us;
};

struct actuators {
	struct actuators_config config;
	struct power power;
	struct shutdown shutdown;
	struct thruster thruster;
	struct focus focus;
	struct display display;
	struct actuators_pwm pwms[ACTUATORS_PWMS_MAX];
	uint8_t leds[ACTUATORS_LEDS_MAX]; /* 0…255 of full brightness */
	uint32_t gpio_outputs;            /* levels */
};

enum actuators_event_kind {
	ACTUATORS_EVENT_POWER,    /* timed, of channel number: power_command() */
	ACTUATORS_EVENT_SHUTDOWN, /* timed: shutdown_command() */
	ACTUATORS_EVENT_PWM,      /* pwm */
	ACTUATORS_EVENT_SERVO,    /* angle_mdeg */
	ACTUATORS_EVENT_LED,      /* led */
	ACTUATORS_EVENT_GPIO,     /* level */
	ACTUATORS_EVENT_THRUSTER, /* share_ppm: thruster_set() */
	ACTUATORS_EVENT_FOCUS,    /* op: focus_command() */
	ACTUATORS_EVENT_ZOOM,     /* share_ppm: focus_move() */
	ACTUATORS_EVENT_DISPLAY,  /* display: display_command() */
};

/* Values as the functions take them that are named above, or stand below. */
struct actuators_event {
	enum actuators_event_kind kind;
	uint8_t number; /* of several of that kind */
	union {
		struct {
			uint32_t op;
			int64_t us;
		} timed;
		struct actuators_pwm pwm;
		int32_t angle_mdeg;
		uint8_t led;
		bool level;
		int32_t share_ppm;
		uint32_t op;
		struct {
			uint32_t op;
			const char *text;
			size_t length;
		} display;
	};
};

/* DENIED: no such output, or a value out of range. FAILED: not now. Neither changed anything. */
enum actuators_result {
	ACTUATORS_ACCEPTED,
	ACTUATORS_DENIED,
	ACTUATORS_FAILED,
};

/* thruster_pulse_us 0: no pulses. */
struct actuators_outputs {
	uint32_t power;
	uint32_t gpio_outputs;
	uint32_t thruster_pulse_us;
	enum focus_motor focus;
	struct actuators_pwm pwms[ACTUATORS_PWMS_MAX];
	uint8_t leds[ACTUATORS_LEDS_MAX];
	struct display display;
};

/* Everything idle but the power channels. config as above, asserted. */
void actuators_init(struct actuators *self, int64_t now_us, const struct actuators_config *config);

/* Any of the commands. */
enum actuators_result actuators_step(struct actuators *self, int64_t now_us,
                                     const struct actuators_event *event);

/* False: the board has no such output, or duty_us > period_us, or period_us not
 * 1…ACTUATORS_PERIOD_MAX_US; nothing changed.
 */
bool actuators_set_pwm(struct actuators *self, uint32_t number, uint32_t period_us,
                       uint32_t duty_us);

/* Lets a PWM output drive a servo: angle_mdeg ±ACTUATORS_SERVO_RANGE_MDEG is 1500 ± 500 us. False:
 * the board has no such output, or the angle is out of range.
 */
bool actuators_set_servo(struct actuators *self, uint32_t number, int32_t angle_mdeg);

/* False: the board has no such LED. */
bool actuators_set_led(struct actuators *self, uint32_t number, uint8_t value);

/* False: the board has no such output. */
bool actuators_set_gpio(struct actuators *self, uint32_t number, bool level);

/* The device is up, or down: then nothing has power or moves, and its owner takes no commands. */
bool actuators_is_up(const struct actuators *self);

/*
 * Does what has fallen due. True: *notice is to be told; call again, there may be another. Call
 * after every command, and at the deadline.
 */
bool actuators_advance(struct actuators *self, int64_t now_us, struct shutdown_notice *notice);
int64_t actuators_deadline_us(const struct actuators *self);

void actuators_outputs(const struct actuators *self, struct actuators_outputs *outputs);

#endif
