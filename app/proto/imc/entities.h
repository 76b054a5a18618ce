/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The device's entities: one for each thing that IMC addresses, with a state that is told when it
 * changes and when somebody asks. Parameters belong to the entity that they are about.
 *
 * Context: the thread that owns it.
 */
#ifndef PHAROS_PROTO_IMC_ENTITIES_H
#define PHAROS_PROTO_IMC_ENTITIES_H

#include "core/illuminator.h"
#include "core/params.h"
#include "proto/imc/messages.h"

#include <stdbool.h>
#include <stdint.h>

/* Ids on the wire (src_ent, dst_ent); rows of the table in entities.c. */
enum imc_entity {
	IMC_ENTITY_SYSTEM,
	IMC_ENTITY_LAMP,
	IMC_ENTITY_THERMAL,
	IMC_ENTITY_SYNC,
	IMC_ENTITY_GIMBAL,
	IMC_ENTITY_POWER,
	IMC_ENTITY_OUTPUTS, /* PWM, GPIO, thruster, focus */
	IMC_ENTITY_PANEL,   /* display, buttons, remote actions */
	IMC_ENTITY_MAVLINK,
	IMC_ENTITY_DRONECAN,
	IMC_ENTITY_IMC,
	IMC_ENTITY_COUNT
};

/* description: constant. */
struct imc_entity_condition {
	enum imc_entity_state_state state;
	const char *description;
};

struct imc_entities {
	struct imc_entity_condition conditions[IMC_ENTITY_COUNT];
	uint32_t changed; /* bit per entity whose state nobody has been told yet */
};

/* All BOOT, until the first report. */
void imc_entities_init(struct imc_entities *self);

/* description: constant, "" is "active". */
void imc_entities_set(struct imc_entities *self, enum imc_entity entity,
                      enum imc_entity_state_state state, const char *description);

/*
 * Lamp and heat as the core has them: limited is a FAULT, shut down an ERROR, a failed sensor a
 * FAILURE of Thermal. Entities in BOOT are NORMAL now.
 */
void imc_entities_report(struct imc_entities *self, const struct illuminator *illuminator);

/* "Lamp"; what it is made of, for EntityInfo. Constant. */
const char *imc_entity_name(enum imc_entity entity);
const char *imc_entity_component(enum imc_entity entity);

/* IMC_ENTITY_COUNT: none has this name. */
enum imc_entity imc_entity_find(const struct imc_text *name);

/* Whose parameter this is. */
enum imc_entity imc_entity_of_group(enum param_group group);

#endif
