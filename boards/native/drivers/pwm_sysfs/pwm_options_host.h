/* SPDX-License-Identifier: Apache-2.0 */
/* Which outputs of the board can be real, and their options: pwm:CHIP/CHANNEL. */
#ifndef PWM_OPTIONS_HOST_H_
#define PWM_OPTIONS_HOST_H_

#include <stdbool.h>
#include <stdint.h>

#include "host/options.h"
#include "models/board.h"
#include "pwm_channel_host.h"

/* An output of the board, by its PWM channel there. */
struct pwm_use {
	const char *name; /* of the option */
	bool is_ratio;    /* the share of the period counts; else the pulse's length */
	uint32_t period_ns;
};

extern const struct pwm_use pwm_uses[BOARD_PWM_COUNT];

/* What the command line says. chip empty: the model. */
extern struct pwm_place pwm_places[BOARD_PWM_COUNT];

extern const struct host_option pwm_options[];

#endif
