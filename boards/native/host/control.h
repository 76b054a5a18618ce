/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The control socket: JSON lines over a Unix stream socket (--control PATH;
 * boards/native/CONTROL.md). A request
 * {"op":NAME,…} has one reply line, {"ok":true,…} or {"ok":false,"error":"one clear line"}; an "id"
 * in it comes back. Operations and faults come in tables of modules (host/module.h). They run in
 * interrupt context.
 */
#ifndef NATIVE_HOST_CONTROL_H_
#define NATIVE_HOST_CONTROL_H_

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "host/error.h"

struct control_call {
	json_t *request;
	json_t *reply; /* an object; "ok" and "id" are set by the caller */
	struct host_error *error;
};

enum control_result {
	CONTROL_OK,
	CONTROL_ERROR, /* call->error says why; reply is not used */
	CONTROL_LATER, /* control_reply() will be called; no other request runs until then */
};

struct control_op {
	const char *name;
	const char *help; /* one line: fields and meaning */
	enum control_result (*run)(struct control_call *call);
};

/* {"op":"fault","device":NAME,"kind":KIND,…}: runs the entry of that device. */
struct control_fault {
	const char *device;
	const char *help; /* one line: kinds and fields */
	enum control_result (*run)(struct control_call *call);
};

/* For ops: the error line, and CONTROL_ERROR. */
#define control_fail(call, ...) ((void)host_error_set((call)->error, __VA_ARGS__), CONTROL_ERROR)

/*
 * Fields of a request. False: it is missing or wrong, and the error line says so. The _or variants
 * leave *value as it is when the field is missing.
 */
bool control_integer(struct control_call *call, const char *field, int64_t low, int64_t high,
                     int64_t *value);
bool control_integer_or(struct control_call *call, const char *field, int64_t low, int64_t high,
                        int64_t *value);
bool control_string(struct control_call *call, const char *field, const char **value);
bool control_bool(struct control_call *call, const char *field, bool *value);

/* Sets a field of the reply. */
void control_put_integer(json_t *object, const char *field, int64_t value);
void control_put_string(json_t *object, const char *field, const char *value);
void control_put_bool(json_t *object, const char *field, bool value);

/* --- the host's own ------------------------------------------------------------------------------
 */

/* Runs one request that has been read; false: there is none. */
bool control_run_one(void);

/* The reply to the request that said CONTROL_LATER. Takes `reply`. error != NULL: it failed. */
void control_reply(json_t *reply, const char *error);

/* Start hooks: who is told when the client of a request that said CONTROL_LATER has gone. */
void control_on_gone(void (*gone)(void));

/* The process ends when the reply of the request that runs is out. */
void control_quit(void);

/* --- the decoder (fuzzed) ------------------------------------------------------------------------
 */

enum {
	CONTROL_LINE_MAX = 65536,
	CONTROL_DEPTH_MAX = 8
};

/* One line without its line feed. The request, an object with a string "op"; NULL: *error says why.
 */
json_t *control_decode(const char *line, size_t length, struct host_error *error);

#endif
