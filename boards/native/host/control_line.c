/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "host/control.h"

/* jansson recurses; requests run on the stacks of small threads. Brackets in strings count too: no
 * harm. */
static bool too_deep(const char *line, size_t length)
{
	int depth = 0;

	for (size_t i = 0; i < length; i++) {
		if (line[i] == '[' || line[i] == '{') {
			if (++depth > CONTROL_DEPTH_MAX) {
				return true;
			}
		} else if ((line[i] == ']' || line[i] == '}') && depth > 0) {
			depth--;
		}
	}
	return false;
}

json_t *control_decode(const char *line, size_t length, struct host_error *error)
{
	json_error_t where;
	json_t *request;

	if (length > CONTROL_LINE_MAX) {
		host_error_set(error, "the line is longer than %d bytes", CONTROL_LINE_MAX);
		return NULL;
	}
	if (too_deep(line, length)) {
		host_error_set(error, "nested deeper than %d", CONTROL_DEPTH_MAX);
		return NULL;
	}
	request = json_loadb(line, length, JSON_REJECT_DUPLICATES, &where);
	if (request == NULL) {
		host_error_set(error, "not JSON: %s", where.text);
		return NULL;
	}
	if (!json_is_object(request) || !json_is_string(json_object_get(request, "op"))) {
		host_error_set(error, "not a request; say {\"op\":\"hello\"}");
		json_decref(request);
		return NULL;
	}
	return request;
}

static bool missing(struct control_call *call, const char *field, const char *what)
{
	if (json_object_get(call->request, field) == NULL) {
		host_error_set(call->error, "\"%s\" is missing; it is %s", field, what);
	} else {
		host_error_set(call->error, "\"%s\" must be %s", field, what);
	}
	return false;
}

bool control_integer_or(struct control_call *call, const char *field, int64_t low, int64_t high,
                        int64_t *value)
{
	return json_object_get(call->request, field) == NULL ||
	       control_integer(call, field, low, high, value);
}

bool control_integer(struct control_call *call, const char *field, int64_t low, int64_t high,
                     int64_t *value)
{
	const json_t *json = json_object_get(call->request, field);
	char what[96];

	if (!json_is_integer(json) || json_integer_value(json) < low ||
	    json_integer_value(json) > high) {
		snprintf(what, sizeof(what), "a whole number from %lld to %lld", (long long)low,
		         (long long)high);
		return missing(call, field, what);
	}
	*value = json_integer_value(json);
	return true;
}

bool control_string(struct control_call *call, const char *field, const char **value)
{
	const json_t *json = json_object_get(call->request, field);

	if (!json_is_string(json)) {
		return missing(call, field, "a string");
	}
	*value = json_string_value(json);
	return true;
}

bool control_bool(struct control_call *call, const char *field, bool *value)
{
	const json_t *json = json_object_get(call->request, field);

	if (!json_is_boolean(json)) {
		return missing(call, field, "true or false");
	}
	*value = json_is_true(json);
	return true;
}

void control_put_integer(json_t *object, const char *field, int64_t value)
{
	json_object_set_new(object, field, json_integer(value));
}

void control_put_string(json_t *object, const char *field, const char *value)
{
	json_object_set_new(object, field, json_string(value));
}

void control_put_bool(json_t *object, const char *field, bool value)
{
	json_object_set_new(object, field, json_boolean(value));
}
