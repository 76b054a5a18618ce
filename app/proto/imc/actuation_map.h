/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which thing of the device a name or an id of IMC's actuation group is.
 */
#ifndef PHAROS_PROTO_IMC_ACTUATION_MAP_H
#define PHAROS_PROTO_IMC_ACTUATION_MAP_H

#include "proto/imc/messages.h"

#include <stdint.h>

/* What messages address. Power channels, LEDs and GPIO lines have names, the others ids. */
enum imc_map_space {
	IMC_MAP_POWER,    /* 309, 311 */
	IMC_MAP_LED,      /* 312…314 */
	IMC_MAP_GPIO,     /* 2000…2002 */
	IMC_MAP_PWM,      /* 315, 316 */
	IMC_MAP_SERVO,    /* 302, 303 */
	IMC_MAP_THRUSTER, /* 301 */
	IMC_MAP_ZOOM,     /* 300 */
};

/* What it is, with a number where there are several (core/actuators.h). */
enum imc_map_thing {
	IMC_THING_POWER_CHANNEL,
	IMC_THING_LAMP,
	IMC_THING_LED,
	IMC_THING_GPIO_OUTPUT,
	IMC_THING_GPIO_INPUT,
	IMC_THING_PWM,
	IMC_THING_PAN,
	IMC_THING_TILT,
	IMC_THING_THRUSTER,
	IMC_THING_FOCUS,
};

/* name: of spaces with names, the address; of the others, for people. */
struct imc_map_row {
	enum imc_map_space space;
	uint8_t id; /* of spaces with ids */
	const char *name;
	enum imc_map_thing thing;
	uint8_t number;
};

extern const struct imc_map_row imc_map[];
extern const uint32_t imc_map_count;

/* NULL: there is none, on any board. */
const struct imc_map_row *imc_map_by_name(enum imc_map_space space, const struct imc_text *name);
const struct imc_map_row *imc_map_by_id(enum imc_map_space space, uint8_t id);

#endif
