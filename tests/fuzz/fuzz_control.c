/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libFuzzer: any bytes as a line of the native board's control socket
 * (boards/native/host/control_line.c).
 *
 * Invariants: nothing is read or written out of bounds, nothing leaks (sanitizers); what is refused
 * has a reason; what is accepted is an object with a string "op", and reads the same when it is
 * written out and read again.
 */
#include <string.h>

#include "host/control.h"

#include "check.h"

static void read_fields(json_t *request)
{
	struct host_error error = {{0}};
	struct control_call call = {.request = request, .error = &error};
	int64_t integer = -1;
	const char *string = NULL;
	bool boolean = false;

	if (control_integer(&call, "us", 0, 1000, &integer)) {
		CHECK(integer >= 0 && integer <= 1000);
	} else {
		CHECK(error.text[0] != '\0');
	}
	error.text[0] = '\0';
	CHECK(control_string(&call, "kind", &string) == (string != NULL));
	CHECK((string == NULL) == (error.text[0] != '\0'));
	error.text[0] = '\0';
	CHECK(control_bool(&call, "fan", &boolean) == (error.text[0] == '\0'));
}

static void check_round_trip(json_t *request)
{
	char *text = json_dumps(request, JSON_COMPACT);
	struct host_error error;
	json_t *again;

	CHECK(text != NULL);
	if (strlen(text) <= CONTROL_LINE_MAX) {
		again = control_decode(text, strlen(text), &error);
		CHECK(again != NULL && json_equal(request, again));
		json_decref(again);
	}
	free(text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	struct host_error error = {{0}};
	json_t *request = control_decode((const char *)data, size, &error);

	if (request == NULL) {
		CHECK(error.text[0] != '\0');
		return 0;
	}
	CHECK(size <= CONTROL_LINE_MAX);
	CHECK(json_is_string(json_object_get(request, "op")));
	read_fields(request);
	check_round_trip(request);
	json_decref(request);
	return 0;
}
