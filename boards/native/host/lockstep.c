/* SPDX-License-Identifier: Apache-2.0 */
#include "host/lockstep.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "host/carry.h"
#include "host/clock.h"
#include "host/control.h"
#include "host/loop.h"
#include "host/module.h"
#include "host/wire.h"
#include "kernel/port.h"

/* A thousand years: far from overflow, further than anybody asks for. */
#define ADVANCE_MAX_US 31536000000000000

enum {
	AWAIT_MS = 5000,
	NAME_MAX_LENGTH = 16,
	JUMPS_PER_POLL = 4096, /* jumps between looks at signals and at the client */
	LOOKS_MAX = 256,       /* rounds of the loop at the start of an advance */
};

/* Carried over resets. */
static struct {
	bool active;
	bool gathering; /* bytes for this advance; nothing has moved yet */
	uint64_t target_us;
	uint64_t gather_until_ns; /* host time */
	uint32_t await_ms;
	uint32_t await_count;
	struct await {
		char name[NAME_MAX_LENGTH];
		uint64_t total; /* bytes of a wire, frames of a bus */
	} await[WIRES_MAX];
} state;

static struct lockstep_source *sources;

static uint32_t jumps;

void lockstep_add(struct lockstep_source *source)
{
	source->next = sources;
	sources = source;
}

static const struct lockstep_source *source_find(const char *name)
{
	const struct lockstep_source *source = sources;

	while (source != NULL && strcmp(source->name, name) != 0) {
		source = source->next;
	}
	return source;
}

static uint64_t received(const char *name)
{
	const struct wire *wire = wire_find(name);

	return wire != NULL ? wire->kept.counts.rx_bytes : source_find(name)->received();
}

static const char *unit(const char *name)
{
	return wire_find(name) != NULL ? "bytes" : "frames";
}

/* The client of the advance under way has gone: time stops where it is. */
static void cancel_advance(void)
{
	if (state.active) {
		state.active = false;
		control_reply(NULL, "the client has gone");
	}
}

/* --- the request ---------------------------------------------------------------------------------
 */

static bool parse_await(struct control_call *call)
{
	json_t *await = json_object_get(call->request, "await");
	const char *name;
	json_t *total;

	state.await_count = 0;
	if (await == NULL) {
		return true;
	}
	if (!json_is_object(await)) {
		host_error_set(call->error, "\"await\" must be an object, such as {\"uart0\":20}");
		return false;
	}
	json_object_foreach(await, name, total)
	{
		if ((wire_find(name) == NULL && source_find(name) == NULL) ||
		    strlen(name) >= NAME_MAX_LENGTH) {
			host_error_set(call->error, "await: no wire \"%.40s\"", name);
			return false;
		}
		if (!json_is_integer(total) || json_integer_value(total) < 0 ||
		    state.await_count == WIRES_MAX) {
			host_error_set(call->error, "await: %s must be a total of received %s",
			               name, unit(name));
			return false;
		}
		strcpy(state.await[state.await_count].name, name);
		state.await[state.await_count].total = (uint64_t)json_integer_value(total);
		state.await_count++;
	}
	return true;
}

static enum control_result run_advance(struct control_call *call)
{
	int64_t us;
	int64_t await_ms = AWAIT_MS;

	if (!clock_is_virtual()) {
		return control_fail(call, "real time moves by itself; start with --time virtual");
	}
	if (!control_integer(call, "us", 0, ADVANCE_MAX_US, &us) ||
	    !control_integer_or(call, "await_ms", 0, 3600000, &await_ms) || !parse_await(call)) {
		return CONTROL_ERROR;
	}
	state.active = true;
	state.gathering = true;
	state.target_us = clock_board_us() + (uint64_t)us;
	state.await_ms = (uint32_t)await_ms;
	state.gather_until_ns = 0;
	return CONTROL_LATER;
}

static void reply(void)
{
	json_t *body = json_object();
	json_t *wires = json_object();
	json_t *buses = json_object();
	const struct wire *wire;

	control_put_integer(body, "now_us", (int64_t)clock_board_us());
	for (size_t i = 0; (wire = wire_at(i)) != NULL; i++) {
		json_t *entry;

		if (wire->type == &wire_none) {
			continue;
		}
		entry = json_object();
		control_put_integer(entry, "rx_bytes", (int64_t)wire->kept.counts.rx_bytes);
		control_put_integer(entry, "tx_bytes", (int64_t)wire->kept.counts.tx_bytes);
		control_put_integer(entry, "tx_datagrams", (int64_t)wire->kept.counts.tx_datagrams);
		json_object_set_new(wires, wire->name, entry);
	}
	for (const struct lockstep_source *at = sources; at != NULL; at = at->next) {
		at->report(buses);
	}
	json_object_set_new(body, "wires", wires);
	json_object_set_new(body, "buses", buses);
	control_reply(body, NULL);
}

/* --- its steps -----------------------------------------------------------------------------------
 */

/* The first that still lacks input; NULL: all is here. */
static const struct await *find_missing(void)
{
	for (uint32_t i = 0; i < state.await_count; i++) {
		if (received(state.await[i].name) < state.await[i].total) {
			return &state.await[i];
		}
	}
	return NULL;
}

static void fail_missing(const struct await *missing)
{
	char text[160];

	snprintf(text, sizeof(text),
	         "await: %s has received %" PRIu64 " of %" PRIu64 " %s after %" PRIu32 " ms",
	         missing->name, received(missing->name), missing->total, unit(missing->name),
	         state.await_ms);
	state.active = false;
	control_reply(NULL, text);
}

/* How much of it may go to the device. */
static uint64_t limit_of(const char *name)
{
	for (uint32_t i = 0; i < state.await_count; i++) {
		if (strcmp(state.await[i].name, name) == 0) {
			return state.await[i].total;
		}
	}
	return UINT64_MAX;
}

static void release_all(void)
{
	struct wire *wire;

	for (size_t i = 0; (wire = wire_at(i)) != NULL; i++) {
		wire_release(wire, limit_of(wire->name));
	}
	for (const struct lockstep_source *at = sources; at != NULL; at = at->next) {
		at->release(limit_of(at->name));
	}
}

/* Collects what was sent to the device; gives it to it all at once. */
static void gather(void)
{
	const struct await *missing;

	if (state.gather_until_ns == 0) {
		state.gather_until_ns = clock_host_ns() + state.await_ms * 1000000ull;
		wires_poke();
		for (const struct lockstep_source *at = sources; at != NULL; at = at->next) {
			at->poke();
		}
		for (int i = 0; i < LOOKS_MAX && loop_poll(0) > 0; i++) {
		}
	}
	while (state.active && !loop_interrupted() && (missing = find_missing()) != NULL) {
		const uint64_t now_ns = clock_host_ns();

		if (now_ns >= state.gather_until_ns) {
			fail_missing(missing);
			return;
		}
		loop_poll((int64_t)(state.gather_until_ns - now_ns));
	}
	if (state.active && !loop_interrupted()) {
		state.gathering = false;
		release_all();
	}
}

static void arrive(void)
{
	clock_jump(state.target_us);
	wires_flush();
	state.active = false;
	reply();
	if (clock_board_us() >= clock_until_us()) {
		port_exit(0);
	}
}

void lockstep_idle(uint64_t deadline_us)
{
	if (!state.active) {
		wires_flush();
		if (!control_run_one()) {
			loop_poll(-1);
		}
	} else if (state.gathering) {
		gather();
	} else if (deadline_us > state.target_us) {
		arrive();
	} else {
		clock_jump(deadline_us);
		if (++jumps % JUMPS_PER_POLL == 0) {
			loop_poll(0);
		}
	}
}

static int start(void)
{
	carry_register("lockstep", &state, sizeof(state));
	control_on_gone(cancel_advance);
	return 0;
}

static const struct control_op ops[] = {
	{"advance",
         "us: moves virtual time; await {WIRE: TOTAL}: first waits for that many received bytes, "
         "await_ms (5000) at most",
         run_advance},
	{0},
};

HOST_MODULE(lockstep_module) = {
	.name = "lockstep",
	.order = HOST_ORDER_WIRES + 1,
	.ops = ops,
	.start = start,
};
