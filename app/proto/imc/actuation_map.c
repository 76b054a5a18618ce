/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/actuation_map.h"

#include "core/actuators.h"
#include "proto/imc/codec.h"

#include <stddef.h>

/* docs/imc.md has the same table; tests/rules compares them. */
const struct imc_map_row imc_map[] = {
	{IMC_MAP_POWER, 0, "lamp", IMC_THING_POWER_CHANNEL, POWER_CHANNEL_LAMP},
	{IMC_MAP_POWER, 0, "gimbal", IMC_THING_POWER_CHANNEL, 1},
	{IMC_MAP_POWER, 0, "camera", IMC_THING_POWER_CHANNEL, 2},
	{IMC_MAP_POWER, 0, "aux", IMC_THING_POWER_CHANNEL, 3},
	{IMC_MAP_LED, 0, "lamp", IMC_THING_LAMP, 0},
	{IMC_MAP_LED, 0, "status", IMC_THING_LED, 0},
	{IMC_MAP_LED, 0, "signal", IMC_THING_LED, 1},
	{IMC_MAP_GPIO, 0, "out0", IMC_THING_GPIO_OUTPUT, 0},
	{IMC_MAP_GPIO, 0, "out1", IMC_THING_GPIO_OUTPUT, 1},
	{IMC_MAP_GPIO, 0, "in0", IMC_THING_GPIO_INPUT, 0},
	{IMC_MAP_GPIO, 0, "in1", IMC_THING_GPIO_INPUT, 1},
	{IMC_MAP_PWM, 0, "lamp", IMC_THING_LAMP, 0},
	{IMC_MAP_PWM, 1, "aux0", IMC_THING_PWM, 0},
	{IMC_MAP_PWM, 2, "aux1", IMC_THING_PWM, 1},
	{IMC_MAP_SERVO, 0, "pan", IMC_THING_PAN, 0},
	{IMC_MAP_SERVO, 1, "tilt", IMC_THING_TILT, 0},
	{IMC_MAP_SERVO, 2, "aux0", IMC_THING_PWM, 0},
	{IMC_MAP_SERVO, 3, "aux1", IMC_THING_PWM, 1},
	{IMC_MAP_THRUSTER, 0, "thruster", IMC_THING_THRUSTER, 0},
	{IMC_MAP_ZOOM, 0, "beam", IMC_THING_FOCUS, 0},
};
const uint32_t imc_map_count = sizeof(imc_map) / sizeof(imc_map[0]);

const struct imc_map_row *imc_map_by_name(enum imc_map_space space, const struct imc_text *name)
{
	for (uint32_t i = 0; i < imc_map_count; i++) {
		if (imc_map[i].space == space && imc_text_is(name, imc_map[i].name)) {
			return &imc_map[i];
		}
	}
	return NULL;
}

const struct imc_map_row *imc_map_by_id(enum imc_map_space space, uint8_t id)
{
	for (uint32_t i = 0; i < imc_map_count; i++) {
		if (imc_map[i].space == space && imc_map[i].id == id) {
			return &imc_map[i];
		}
	}
	return NULL;
}
