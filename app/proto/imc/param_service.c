/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/node.h"

#include "core/param_units.h"

/* "-40", "40.5"; "true", "false". */
static bool parse(const struct param_info *info, const struct imc_text *text, int32_t *value)
{
	if (imc_text_is(text, "true") || imc_text_is(text, "false")) {
		return param_from_integer(info, imc_text_is(text, "true") ? 1 : 0, value);
	}
	return param_parse(info, text->bytes, text->length, value);
}

/* --- messages --------------------------------------------------------------------------------- */

/* By name, or without one the entity that the header means. IMC_ENTITY_COUNT: none. */
static enum imc_entity find_entity(const struct imc_packet *packet, const struct imc_text *name)
{
	if (name->length == 0 && packet->header.dst_ent < IMC_ENTITY_COUNT) {
		return (enum imc_entity)packet->header.dst_ent;
	}
	return imc_entity_find(name);
}

/* What is in force now, of the parameters with one of these indices. */
static void add(struct imc_node *self, struct imc_message *message, enum imc_entity entity,
                uint32_t index, const struct imc_packet *request, struct imc_outbox *out)
{
	struct imc_parameter_list *const list = &message->entity_parameters.params;
	const struct param_info *const info = params_info(index);
	char number[DECIMAL_TEXT_MAX];

	(void)param_print(info, self->device->params.values[index], number);

	const struct imc_entity_parameter parameter = {
		.name = imc_text_of(info->name),
		.value = imc_text_of(number),
	};

	if (!imc_parameters_add(list, self->list, IMC_LIST_MAX, &parameter)) {
		imc_outbox_reply(out, request, (uint8_t)entity, message); /* and a further one */
		*list = (struct imc_parameter_list){0};
		(void)imc_parameters_add(list, self->list, IMC_LIST_MAX, &parameter);
	}
}

static struct imc_message empty_answer(enum imc_entity entity)
{
	return (struct imc_message){
		.id = IMC_ENTITY_PARAMETERS,
		.entity_parameters = {.name = imc_text_of(imc_entity_name(entity))},
	};
}

void imc_node_query_parameters(struct imc_node *self, const struct imc_packet *packet,
                               struct imc_outbox *out)
{
	const enum imc_entity entity =
		find_entity(packet, &packet->message.query_entity_parameters.name);

	if (entity == IMC_ENTITY_COUNT) {
		self->stats.unknown_names++;
		return;
	}
	struct imc_message answer = empty_answer(entity);

	for (uint32_t i = 0; i < PARAM_COUNT; i++) {
		if (imc_entity_of_group(params_info(i)->group) == entity) {
			add(self, &answer, entity, i, packet, out);
		}
	}
	self->stats.requests++;
	imc_outbox_reply(out, packet, (uint8_t)entity, &answer);
}

/* PARAM_COUNT: there is none, or not in this entity. */
static uint32_t find_parameter(enum imc_entity entity, const struct imc_text *name)
{
	const uint32_t index = params_find(name->bytes, name->length);

	return index < PARAM_COUNT && imc_entity_of_group(params_info(index)->group) == entity
	               ? index
	               : (uint32_t)PARAM_COUNT;
}

static bool set(struct imc_node *self, int64_t now_us, uint32_t index, const struct imc_text *text)
{
	static const struct device_who who = {.way = SECURITY_WAY_IMC};
	int32_t value;

	if (index == PARAM_COUNT || !parse(params_info(index), text, &value) ||
	    pharos_device_set_param(self->device, now_us, &who, index, value) != PARAMS_OK) {
		self->stats.params_refused++;
		return false;
	}
	return true;
}

/* The answer lists what was accepted, and nothing else. */
void imc_node_set_parameters(struct imc_node *self, int64_t now_us, const struct imc_packet *packet,
                             struct imc_outbox *out)
{
	struct imc_parameter_list asked = packet->message.entity_parameters.params;
	const enum imc_entity entity = find_entity(packet, &packet->message.entity_parameters.name);
	struct imc_entity_parameter parameter;

	if (entity == IMC_ENTITY_COUNT) {
		self->stats.unknown_names++;
		return;
	}
	struct imc_message answer = empty_answer(entity);

	while (imc_parameters_next(&asked, &parameter)) {
		const uint32_t index = find_parameter(entity, &parameter.name);

		if (set(self, now_us, index, &parameter.value)) {
			add(self, &answer, entity, index, packet, out);
		}
	}
	self->stats.requests++;
	imc_outbox_reply(out, packet, (uint8_t)entity, &answer);
}
