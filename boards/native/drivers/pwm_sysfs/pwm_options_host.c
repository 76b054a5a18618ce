/* SPDX-License-Identifier: Apache-2.0 */
#include "pwm_options_host.h"

#include <stdio.h>
#include <string.h>

enum {
	CHANNEL_MAX = 1023,
	PERIOD_MIN_US = 1,
	PERIOD_MAX_US = 100000,
	PULSE_PERIOD_MIN_US =
		3000, /* a servo's pulse is shorter; at its length it would never end */
};

/* The periods are those of native.dts. */
const struct pwm_use pwm_uses[BOARD_PWM_COUNT] = {
	[BOARD_PWM_LAMP] = {"light", true, 500000},
	[BOARD_PWM_SERVO_PAN] = {"servo-pan", false, 20000000},
	[BOARD_PWM_SERVO_TILT] = {"servo-tilt", false, 20000000},
	[BOARD_PWM_AUX0] = {"aux0", false, 20000000},
	[BOARD_PWM_AUX1] = {"aux1", false, 20000000},
	[BOARD_PWM_THRUSTER] = {"thruster", false, 20000000},
	[BOARD_PWM_LED_STATUS] = {"led-status", true, 1000000},
	[BOARD_PWM_LED_SIGNAL] = {"led-signal", true, 1000000},
};

struct pwm_place pwm_places[BOARD_PWM_COUNT];

static int parse_word(enum board_pwm_channel use, struct pwm_place *place, const char *word,
                      struct host_error *error)
{
	struct host_error reason;
	uint64_t us;
	const uint64_t min_us = pwm_uses[use].is_ratio ? PERIOD_MIN_US : PULSE_PERIOD_MIN_US;

	if (strcmp(word, "inverted") == 0) {
		place->is_inverted = true;
		return 0;
	}
	if (strncmp(word, "period=", 7) != 0) {
		return host_error_set(error, "\"%.40s\" is neither period=TIME nor inverted", word);
	}
	if (parse_duration_us(word + 7, &us, &reason) != 0) {
		return host_error_set(error, "period: %.200s", reason.text);
	}
	if (us < min_us || us > PERIOD_MAX_US) {
		return host_error_set(error, "period: %s is not from %s to %dms", word + 7,
		                      pwm_uses[use].is_ratio ? "1us" : "3ms, for pulses,",
		                      PERIOD_MAX_US / 1000);
	}
	place->period_ns = (uint32_t)us * 1000u;
	return 0;
}

static int parse_place(enum board_pwm_channel use, const char *value, struct host_error *error)
{
	struct pwm_place *place = &pwm_places[use];
	char text[SYSFS_PATH_SIZE];
	char *rest = text;
	struct host_error reason;
	uint64_t channel;
	char *words;
	char *slash;

	*place = (struct pwm_place){.period_ns = pwm_uses[use].period_ns};
	if (strcmp(value, "sim") == 0) {
		return 0;
	}
	if (strncmp(value, "pwm:", 4) != 0 || strlen(value + 4) >= sizeof(text)) {
		return host_error_set(error, "\"%.60s\" is neither sim nor pwm:CHIP/CHANNEL",
		                      value);
	}
	strcpy(text, value + 4);
	words = strsep(&rest, ",");
	slash = strrchr(words, '/');
	if (slash == NULL || slash == words ||
	    parse_number(slash + 1, 0, CHANNEL_MAX, &channel, &reason) != 0) {
		return host_error_set(
			error, "\"%.60s\" is not as pwm:CHIP/CHANNEL, such as pwm:0/1", value);
	}
	*slash = '\0';
	strcpy(place->chip, words);
	place->channel = (uint32_t)channel;
	while ((words = strsep(&rest, ",")) != NULL) {
		if (parse_word(use, place, words, error) != 0) {
			return -1;
		}
	}
	return 0;
}

#define PARSE(name_, use_)                                                                         \
	static int parse_##name_(const char *value, struct host_error *error)                      \
	{                                                                                          \
		return parse_place(use_, value, error);                                            \
	}

PARSE(light, BOARD_PWM_LAMP)
PARSE(servo_pan, BOARD_PWM_SERVO_PAN)
PARSE(servo_tilt, BOARD_PWM_SERVO_TILT)
PARSE(aux0, BOARD_PWM_AUX0)
PARSE(aux1, BOARD_PWM_AUX1)
PARSE(thruster, BOARD_PWM_THRUSTER)
PARSE(led_status, BOARD_PWM_LED_STATUS)
PARSE(led_signal, BOARD_PWM_LED_SIGNAL)

const struct host_option pwm_options[] = {
	{"light", "PWM",
         "the lamp's brightness (sim); PWM is one of these:\n"
         "sim                  the board's model\n"
         "pwm:CHIP/CHANNEL[,period=500us][,inverted]\n"
         "                     a channel of the kernel's; CHIP: 0 for\n"
         "                     /sys/class/pwm/pwmchip0, a device such as\n"
         "                     fe20c000.pwm or 1-0040, or a path of these",
         parse_light},
	{"servo-pan", "PWM", "the same for the pan servo, with period=20ms", parse_servo_pan},
	{"servo-tilt", "PWM", "the tilt servo, 20ms", parse_servo_tilt},
	{"aux0", "PWM", "the first auxiliary output, 20ms", parse_aux0},
	{"aux1", "PWM", "the second one, 20ms", parse_aux1},
	{"thruster", "PWM", "the thruster, 20ms", parse_thruster},
	{"led-status", "PWM", "the status LED, 1ms", parse_led_status},
	{"led-signal", "PWM", "the signal LED, 1ms", parse_led_signal},
	{0},
};
