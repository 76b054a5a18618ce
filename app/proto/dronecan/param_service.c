/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/node.h"

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

/* False: no whole number, or none of 32 bits; INT32_MAX + 1 is the first that is too large. */
static bool as_whole(float real, int32_t *integer)
{
	if (!(real >= -2147483648.0f && real < 2147483648.0f)) {
		return false;
	}
	*integer = (int32_t)real;
	return (float)*integer == real;
}

/* The integer that a value means. False: it means none that a parameter could take. */
static bool as_integer(const struct dronecan_param_value *value, int32_t *integer)
{
	switch (value->tag) {
	case DRONECAN_PARAM_VALUE_INTEGER_VALUE:
		*integer = (int32_t)value->integer_value;
		return value->integer_value >= INT32_MIN && value->integer_value <= INT32_MAX;
	case DRONECAN_PARAM_VALUE_BOOLEAN_VALUE:
		*integer = value->boolean_value;
		return value->boolean_value <= 1;
	case DRONECAN_PARAM_VALUE_REAL_VALUE:
		return as_whole(value->real_value, integer);
	case DRONECAN_PARAM_VALUE_EMPTY:
	case DRONECAN_PARAM_VALUE_STRING_VALUE:
		return false;
	}
	return false;
}

static void set(struct dronecan_node *self, int64_t now_us, uint32_t index,
                const struct dronecan_param_value *value)
{
	int32_t integer;

	if (!as_integer(value, &integer) ||
	    pharos_device_set_param(self->device, now_us, &who, index, integer) != PARAMS_OK) {
		self->stats.params_refused++;
	}
}

static struct dronecan_param_numeric_value numeric(int32_t value)
{
	return (struct dronecan_param_numeric_value){
		.tag = DRONECAN_PARAM_NUMERIC_VALUE_INTEGER_VALUE,
		.integer_value = value,
	};
}

static struct dronecan_param_value integer(int32_t value)
{
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
		response->value = integer(value);
		response->default_value = integer(info->fallback);
		response->max_value = numeric(info->max);
		response->min_value = numeric(info->min);
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
