/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/entities.h"

#include "proto/imc/codec.h"

#include <string.h>

struct row {
	const char *name;
	const char *component;
};

static const struct row rows[IMC_ENTITY_COUNT] = {
	[IMC_ENTITY_SYSTEM] = {"System", "Pharos"},
	[IMC_ENTITY_LAMP] = {"Lamp", "Pharos.Illuminator"},
	[IMC_ENTITY_THERMAL] = {"Thermal", "Pharos.Thermal"},
	[IMC_ENTITY_SYNC] = {"Sync", "Pharos.Sync"},
	[IMC_ENTITY_GIMBAL] = {"Gimbal", "Pharos.Gimbal"},
	[IMC_ENTITY_POWER] = {"Power", "Pharos.Power"},
	[IMC_ENTITY_OUTPUTS] = {"Outputs", "Pharos.Outputs"},
	[IMC_ENTITY_PANEL] = {"Panel", "Pharos.Panel"},
	[IMC_ENTITY_MAVLINK] = {"MAVLink", "Pharos.MAVLink"},
	[IMC_ENTITY_DRONECAN] = {"DroneCAN", "Pharos.DroneCAN"},
	[IMC_ENTITY_IMC] = {"IMC", "Pharos.IMC"},
};

/* Groups that are not named here are the system's. */
static const enum imc_entity of_group[PARAM_GROUP_COUNT] = {
	[PARAM_GROUP_LIGHT] = IMC_ENTITY_LAMP,      [PARAM_GROUP_ARBITER] = IMC_ENTITY_LAMP,
	[PARAM_GROUP_THERMAL] = IMC_ENTITY_THERMAL, [PARAM_GROUP_SYNC] = IMC_ENTITY_SYNC,
	[PARAM_GROUP_MAVLINK] = IMC_ENTITY_MAVLINK, [PARAM_GROUP_DRONECAN] = IMC_ENTITY_DRONECAN,
	[PARAM_GROUP_IMC] = IMC_ENTITY_IMC,         [PARAM_GROUP_OUTPUTS] = IMC_ENTITY_OUTPUTS,
	[PARAM_GROUP_GIMBAL] = IMC_ENTITY_GIMBAL,
};

void imc_entities_init(struct imc_entities *self)
{
	self->changed = 0;
	for (uint32_t i = 0; i < IMC_ENTITY_COUNT; i++) {
		self->conditions[i] = (struct imc_entity_condition){IMC_ENTITY_STATE_BOOT, "boot"};
	}
}

void imc_entities_set(struct imc_entities *self, enum imc_entity entity,
                      enum imc_entity_state_state state, const char *description)
{
	struct imc_entity_condition *const now = &self->conditions[entity];
	const char *const text = description[0] != '\0' ? description : "active";

	if (now->state != state || strcmp(now->description, text) != 0) {
		*now = (struct imc_entity_condition){state, text};
		self->changed |= 1u << entity;
	}
}

static void report_thermal(struct imc_entities *self, const struct thermal_report *thermal)
{
	if (thermal->fault != THERMAL_FAULT_NONE) {
		imc_entities_set(self, IMC_ENTITY_THERMAL, IMC_ENTITY_STATE_FAILURE,
		                 thermal_fault_name(thermal->fault));
		return;
	}
	imc_entities_set(self, IMC_ENTITY_THERMAL, IMC_ENTITY_STATE_NORMAL, "");
}

void imc_entities_report(struct imc_entities *self, const struct illuminator *illuminator)
{
	const uint32_t flags = illuminator_error_flags(illuminator);

	for (uint32_t i = 0; i < IMC_ENTITY_COUNT; i++) {
		if (self->conditions[i].state == IMC_ENTITY_STATE_BOOT) {
			imc_entities_set(self, (enum imc_entity)i, IMC_ENTITY_STATE_NORMAL, "");
		}
	}
	report_thermal(self, &illuminator->thermal);
	if ((flags & THERMAL_FLAG_SHUTDOWN) != 0) {
		imc_entities_set(self, IMC_ENTITY_LAMP, IMC_ENTITY_STATE_ERROR, "over temperature");
	} else if (illuminator->thermal.dark) {
		imc_entities_set(self, IMC_ENTITY_LAMP, IMC_ENTITY_STATE_ERROR, "no light allowed");
	} else if ((flags & THERMAL_FLAG_THERMISTOR) != 0) {
		imc_entities_set(self, IMC_ENTITY_LAMP, IMC_ENTITY_STATE_FAULT,
		                 "limited, temperature unknown");
	} else if ((flags & THERMAL_FLAG_THROTTLING) != 0) {
		imc_entities_set(self, IMC_ENTITY_LAMP, IMC_ENTITY_STATE_FAULT, "throttling");
	} else {
		imc_entities_set(self, IMC_ENTITY_LAMP, IMC_ENTITY_STATE_NORMAL, "");
	}
}

const char *imc_entity_name(enum imc_entity entity)
{
	return rows[entity].name;
}

const char *imc_entity_component(enum imc_entity entity)
{
	return rows[entity].component;
}

enum imc_entity imc_entity_find(const struct imc_text *name)
{
	uint32_t entity = 0;

	while (entity < IMC_ENTITY_COUNT && !imc_text_is(name, rows[entity].name)) {
		entity++;
	}
	return (enum imc_entity)entity;
}

enum imc_entity imc_entity_of_group(enum param_group group)
{
	return of_group[group];
}
