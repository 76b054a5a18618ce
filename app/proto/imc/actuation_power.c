/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Power channels and power-down of the actuation service.
 */
#include "proto/imc/actuation_internal.h"
#include "proto/imc/seconds.h"

#define GRACE_MAX_S 3600.0f
_Static_assert(SHUTDOWN_GRACE_MAX_US == 3600 * (int64_t)US_PER_S, "as the core has it");

enum imc_actuation_outcome imc_actuation_take_power_channel_control(struct imc_actuation *self,
                                                                    const struct imc_turn *turn)
{
	const struct imc_power_channel_control *const set =
		&turn->packet->message.power_channel_control;
	const struct imc_map_row *const row =
		imc_actuation_find_name(self, IMC_MAP_POWER, &set->name);
	const bool timed =
		set->op == IMC_CHANNEL_SCHEDULE_ON || set->op == IMC_CHANNEL_SCHEDULE_OFF;
	struct actuators_event event = {.kind = ACTUATORS_EVENT_POWER, .timed = {.op = set->op}};

	if (row == NULL) {
		return IMC_ACTUATION_UNKNOWN;
	}
	if (timed && !imc_seconds_to_us(set->sched_time, &event.timed.us)) {
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	event.number = row->number;
	return imc_actuation_drive(self, turn->now_us, &event);
}

enum imc_actuation_outcome imc_actuation_take_query_power_channel_state(struct imc_actuation *self,
                                                                        const struct imc_turn *turn)
{
	const uint32_t on = power_outputs(&self->device->actuators.power);

	for (uint32_t i = 0; i < imc_map_count; i++) {
		const struct imc_map_row *const row = &imc_map[i];

		if (row->space != IMC_MAP_POWER || !imc_actuation_has(self, row)) {
			continue;
		}
		const struct imc_message message = {
			.id = IMC_POWER_CHANNEL_STATE,
			.power_channel_state = {.name = imc_text_of(row->name),
		                                .state = imc_mask_has(on, row->number) ? 1 : 0},
		};

		imc_turn_reply(turn, IMC_ENTITY_POWER, &message);
	}
	return IMC_ACTUATION_DONE;
}

/* 0…GRACE_MAX_S, to the nearest microsecond that an f32 tells. */
static bool grace_us(float seconds, int64_t *us)
{
	if (!(seconds >= 0.0f && seconds <= GRACE_MAX_S)) {
		return false;
	}
	const uint32_t whole = (uint32_t)seconds;

	*us = (int64_t)whole * US_PER_S +
	      (uint32_t)((seconds - (float)whole) * (float)US_PER_S + 0.5f);
	return true;
}

enum imc_actuation_outcome imc_actuation_take_power_operation(struct imc_actuation *self,
                                                              const struct imc_turn *turn)
{
	const struct imc_power_operation *const set = &turn->packet->message.power_operation;
	const bool timed = set->op == IMC_POWER_SCHEDULE_DOWN || set->op == IMC_POWER_SCHEDULE_UP;
	struct actuators_event event = {.kind = ACTUATORS_EVENT_SHUTDOWN, .timed = {.op = set->op}};

	if ((timed && !imc_seconds_to_us(set->sched_time, &event.timed.us)) ||
	    (set->op == IMC_POWER_DOWN && !grace_us(set->time_remain, &event.timed.us))) {
		return IMC_ACTUATION_OUT_OF_RANGE;
	}
	if (set->op == IMC_POWER_DOWN_IN_PROGRESS || set->op == IMC_POWER_UP_IN_PROGRESS) {
		return IMC_ACTUATION_DONE; /* somebody else's */
	}
	return imc_actuation_drive(self, turn->now_us, &event);
}
