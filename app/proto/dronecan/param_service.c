/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/node.h"

#include "core/param_units.h"

#include <string.h>

_Static_assert(PARAMS_NAME_MAX <= sizeof(((struct dronecan_param_get_set_response *)0)->name),
               "a parameter's name fits");

static const struct device_who who = {.way = SECURITY_WAY_DRONECAN};

/* A name counts before an index. PARAM_COUNT: no such parameter. */
static uint32_t find(const struct dronecan_param_get_set_request *request)
{
	if (request->name_len > 0) {
		return params_find((const char *)request->name, request->name_len);
	}
	return (request->index < PARAM_COUNT) ? request->index : (uint32_t)PARAM_COUNT;
}

/* False: it means nothing that the parameter could be. */
static bool as_value(const struct param_info *info, const struct dronecan_param_value *wire,
                     int32_t *value)
{
	uint32_t real;

	switch (wire->tag) {
	case DRONECAN_PARAM_VALUE_INTEGER_VALUE:
		return param_from_integer(info, wire->integer_value, value);
	case DRONECAN_PARAM_VALUE_BOOLEAN_VALUE:
		return wire->boolean_value <= 1 &&
		       param_from_integer(info, wire->boolean_value, value);
	case DRONECAN_PARAM_VALUE_REAL_VALUE:
		memcpy(&real, &wire->real_value, sizeof(real));
		return param_from_real(info, real, value);
	case DRONECAN_PARAM_VALUE_EMPTY:
	case DRONECAN_PARAM_VALUE_STRING_VALUE:
		return false;
	}
	return false;
}

static void set(struct dronecan_node *self, int64_t now_us, uint32_t index,
                const struct dronecan_param_value *wire)
{
	int32_t value;

	if (!as_value(params_info(index), wire, &value) ||
	    pharos_device_set_param(self->device, now_us, &who, index, value) != PARAMS_OK) {
		self->stats.params_refused++;
	}
}

static float real(const struct param_info *info, int32_t value)
{
	const uint32_t bits = param_to_real(info, value);
	float wire;

	memcpy(&wire, &bits, sizeof(wire));
	return wire;
}

/* What has decimals is a real value, all else an integer: so editors offer what can be set. */
static struct dronecan_param_numeric_value numeric(const struct param_info *info, int32_t value)
{
	if (info->decimals > 0) {
		return (struct dronecan_param_numeric_value){
			.tag = DRONECAN_PARAM_NUMERIC_VALUE_REAL_VALUE,
			.real_value = real(info, value),
		};
	}
	return (struct dronecan_param_numeric_value){
		.tag = DRONECAN_PARAM_NUMERIC_VALUE_INTEGER_VALUE,
		.integer_value = value,
	};
}

static struct dronecan_param_value wire_of(const struct param_info *info, int32_t value)
{
	if (info->decimals > 0) {
		return (struct dronecan_param_value){
			.tag = DRONECAN_PARAM_VALUE_REAL_VALUE,
			.real_value = real(info, value),
		};
	}
	return (struct dronecan_param_value){
		.tag = DRONECAN_PARAM_VALUE_INTEGER_VALUE,
		.integer_value = value,
	};
}

/* What is in force now; all empty for a parameter that does not exist. */
static void answer(struct dronecan_node *self, int64_t now_us,
                   const struct dronecan_transfer *request, uint32_t index,
                   struct dronecan_param_get_set_response *response)
{
	const struct param_info *info = params_info(index);
	uint8_t data[DRONECAN_TX_PAYLOAD_MAX];
	int32_t value = 0;
	size_t size;

	memset(response, 0, sizeof(*response));
	if (info != NULL && params_get(&self->device->params, index, &value) == PARAMS_OK) {
		response->value = wire_of(info, value);
		response->default_value = wire_of(info, info->fallback);
		response->max_value = numeric(info, info->max);
		response->min_value = numeric(info, info->min);
		response->name_len = (uint8_t)strlen(info->name);
		memcpy(response->name, info->name, response->name_len);
	}
	if (dronecan_param_get_set_response_encode(response, !(request->fd && self->transport->fd),
	                                           data, sizeof(data), &size)) {
		(void)dronecan_node_respond(self, now_us, request, data, size);
	}
}

void dronecan_node_get_set(struct dronecan_node *self, int64_t now_us,
                           const struct dronecan_transfer *request)
{
	/* one after the other, so that the stack need not hold both */
	union {
		struct dronecan_param_get_set_request request;
		struct dronecan_param_get_set_response response;
	} wire;

	if (!dronecan_param_get_set_request_decode(&wire.request, !request->fd, request->data,
	                                           request->size)) {
		self->stats.malformed++;
		return;
	}
	const uint32_t index = find(&wire.request);

	if (index != PARAM_COUNT && wire.request.value.tag != DRONECAN_PARAM_VALUE_EMPTY) {
		set(self, now_us, index, &wire.request.value);
	}
	answer(self, now_us, request, index, &wire.response);
}

void dronecan_node_execute_opcode(struct dronecan_node *self, int64_t now_us,
                                  const struct dronecan_transfer *request,
                                  struct dronecan_node_outbox *out)
{
	struct dronecan_param_execute_opcode_request message;
	struct dronecan_param_execute_opcode_response response = {.argument = 0, .ok = true};
	uint8_t data[DRONECAN_PARAM_EXECUTE_OPCODE_RESPONSE_MAX_SIZE];
	size_t size;

	if (!dronecan_param_execute_opcode_request_decode(&message, !request->fd, request->data,
	                                                  request->size)) {
		self->stats.malformed++;
		return;
	}
	if (message.opcode == DRONECAN_PARAM_EXECUTE_OPCODE_OPCODE_SAVE &&
	    pharos_device_may(self->device, &who, SECURITY_PARAMS)) {
		out->actions[out->count++] =
			(struct dronecan_node_action){.kind = DRONECAN_NODE_SAVE};
	} else if (message.opcode == DRONECAN_PARAM_EXECUTE_OPCODE_OPCODE_ERASE &&
	           pharos_device_reset_params(self->device, now_us, &who)) {
		out->actions[out->count++] =
			(struct dronecan_node_action){.kind = DRONECAN_NODE_ERASE};
	} else {
		response.ok = false;
	}
	if (dronecan_param_execute_opcode_response_encode(&response, true, data, sizeof(data),
	                                                  &size)) {
		(void)dronecan_node_respond(self, now_us, request, data, size);
	}
}
