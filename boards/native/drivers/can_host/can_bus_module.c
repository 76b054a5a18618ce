/* SPDX-License-Identifier: Apache-2.0 */
/* --can0: which bus the CAN controller of the native board is on; its control operations. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "can_bus.h"
#include "host/carry.h"
#include "host/clock.h"
#include "host/control.h"
#include "host/lockstep.h"
#include "host/module.h"
#include "host/say.h"

static const struct can_bus_type *const types[] = {&can_bus_udp, &can_bus_socketcan, &can_bus_none};

enum {
	TYPES = sizeof(types) / sizeof(types[0])
};

static struct can_bus can0 = {.name = "can0"};

struct can_bus *can_host_bus_find(const char *name)
{
	return strcmp(name, can0.name) == 0 ? &can0 : NULL;
}

/* --- the option ------------------------------------------------------------------------------ */

int can_bus_parse(struct can_bus *bus, const char *url, struct host_error *error)
{
	const size_t scheme = strcspn(url, ":,");
	char *paced;

	if (strlen(url) >= sizeof(bus->url)) {
		return host_error_set(error, "longer than %zu characters", sizeof(bus->url) - 1);
	}
	strcpy(bus->url, url);
	paced = strstr(bus->url, ",paced");
	bus->paced = paced != NULL && paced[strlen(",paced")] == '\0';
	if (bus->paced) {
		*paced = '\0';
	}
	for (size_t i = 0; i < TYPES; i++) {
		const char *rest = bus->url + scheme;

		if (strlen(types[i]->scheme) != scheme ||
		    memcmp(types[i]->scheme, url, scheme) != 0) {
			continue;
		}
		free(bus->state);
		bus->type = types[i];
		bus->state = calloc(1, types[i]->state_size + 1);
		if (bus->state == NULL) {
			abort();
		}
		if (bus->paced && types[i]->is_real) {
			return host_error_set(error, "\"%.40s\" has its own pace; leave out ,paced",
			                      bus->url);
		}
		rest += *rest == ':' ? 1 : 0;
		if (types[i]->parse == NULL) {
			return *rest == '\0' ? 0
			                     : host_error_set(error, "\"%.40s\": say %s", url,
			                                      types[i]->scheme);
		}
		return types[i]->parse(bus, rest, error);
	}
	return host_error_set(error, "\"%.40s\" is no CAN bus; udp, socketcan:NAME and none are",
	                      url);
}

static int parse_can0(const char *value, struct host_error *error)
{
	return can_bus_parse(&can0, value, error);
}

static const struct host_option options[] = {
	{"can0", "BUS",
         "where the CAN controller is; BUS is one of these:\n"
         "udp[:N]           bus N (0) in UDP datagrams on loopback: what mcast:N is\n"
         "                  to DroneCAN's tools and ArduPilot's simulator\n"
         "udp:ADDRESS:PORT  the same on another group, or on 127.255.255.255\n"
         "socketcan:NAME    an interface of the system's; it may come and go\n"
         "none              not connected\n"
         "udp in real time, none in virtual time. After udp: ,paced for frames\n"
         "that take their time, by the bit rate (in virtual time too)",
         parse_can0},
	{0},
};

/* --- control operations ---------------------------------------------------------------------- */

static void describe(const struct can_bus *bus, char *text, size_t size)
{
	if (bus->type->describe != NULL) {
		bus->type->describe(bus, text, size);
	} else {
		snprintf(text, size, "%s", bus->url);
	}
}

static enum control_result run_buses(struct control_call *call)
{
	const struct can_bus_counts *counts = &can0.kept.counts;
	char text[CAN_BUS_URL_MAX + 64];
	json_t *buses = json_object();
	json_t *entry = json_object();

	if (can0.type->count != NULL) {
		can0.type->count(&can0);
	}
	describe(&can0, text, sizeof(text));
	control_put_string(entry, "address", text);
	control_put_integer(entry, "rx_frames", (int64_t)counts->rx_frames);
	control_put_integer(entry, "tx_frames", (int64_t)counts->tx_frames);
	control_put_integer(entry, "rx_malformed", (int64_t)counts->rx_malformed);
	control_put_integer(entry, "rx_drops", (int64_t)counts->rx_drops);
	control_put_integer(entry, "tx_retries", (int64_t)counts->tx_retries);
	control_put_integer(entry, "errors", (int64_t)counts->errors);
	control_put_integer(entry, "reconnects", (int64_t)counts->reconnects);
	control_put_integer(entry, "faults", (int64_t)counts->faults);
	json_object_set_new(buses, can0.name, entry);
	json_object_set_new(call->reply, "buses", buses);
	return CONTROL_OK;
}

static const struct control_op ops[] = {
	{"buses", "address and counters of every CAN bus", run_buses},
	{0},
};

static enum control_result run_bus_off(struct control_call *call)
{
	int64_t hold_us = 0;

	if (!control_integer_or(call, "hold_us", 0, UINT32_MAX, &hold_us)) {
		return CONTROL_ERROR;
	}
	if (can0.type->is_real) {
		return control_fail(call, "the controller of %s is real: only it goes bus-off",
		                    can0.url);
	}
	can_bus_force_off(&can0, (uint32_t)hold_us);
	return CONTROL_OK;
}

static enum control_result run_fault(struct control_call *call)
{
	const char *kind;
	const char *direction = "both";
	int64_t rate_ppm = 0;

	if (!control_string(call, "kind", &kind) ||
	    (json_object_get(call->request, "direction") != NULL &&
	     !control_string(call, "direction", &direction))) {
		return CONTROL_ERROR;
	}
	if (strcmp(kind, "bus-off") == 0) {
		return run_bus_off(call);
	}
	if (can_bus_is_rated_fault(kind)) {
		if (!control_integer(call, "rate_ppm", 0, 1000000, &rate_ppm)) {
			return CONTROL_ERROR;
		}
	} else if (strcmp(kind, "none") != 0 && strcmp(kind, "gone") != 0) {
		return control_fail(call, "\"kind\" must be lost, flipped, doubled, reordered, "
		                          "gone, bus-off or none");
	}
	if (strcmp(direction, "rx") != 0 && strcmp(direction, "tx") != 0 &&
	    strcmp(direction, "both") != 0) {
		return control_fail(call, "\"direction\" must be rx, tx or both");
	}
	if (strcmp(kind, "none") == 0) {
		can_bus_end_faults(&can0);
	} else if (strcmp(kind, "gone") == 0) {
		can_bus_set_gone(&can0, true);
	} else {
		can_bus_set_rate(&can0, kind, strcmp(direction, "tx") != 0,
		                 strcmp(direction, "rx") != 0, (uint32_t)rate_ppm);
	}
	return CONTROL_OK;
}

static const struct control_fault faults[] = {
	{"can0",
         "kind: lost, flipped (an error on the bus), doubled, reordered, none; rate_ppm of the "
         "frames; direction: rx, tx, both; or kind: gone (no interface), bus-off; hold_us",
         run_fault},
	{0},
};

/* --- lock-step ------------------------------------------------------------------------------- */

static uint64_t received(void)
{
	return can0.kept.counts.rx_frames;
}

static void poke(void)
{
	if (can0.retry.running) {
		loop_timer_stop(&can0.retry);
		can0.type->start(&can0);
	}
}

static void release(uint64_t total)
{
	can_bus_release(&can0, total);
}

static void report(json_t *buses)
{
	json_t *entry;

	if (can0.type == &can_bus_none) {
		return;
	}
	entry = json_object();
	control_put_integer(entry, "rx_frames", (int64_t)can0.kept.counts.rx_frames);
	control_put_integer(entry, "tx_frames", (int64_t)can0.kept.counts.tx_frames);
	json_object_set_new(buses, can0.name, entry);
}

static struct lockstep_source lockstep_can0 = {
	.name = "can0",
	.received = received,
	.poke = poke,
	.release = release,
	.report = report,
};

/* --- start and end --------------------------------------------------------------------------- */

static int start(void)
{
	struct host_error error;
	char text[CAN_BUS_URL_MAX + 64];
	size_t size;
	const void *staged = carry_get("can0/staged", &size);

	/* Other people's frames come at other people's pace: no virtual time by accident. */
	if (can0.type == NULL &&
	    can_bus_parse(&can0, clock_is_virtual() ? "none" : "udp", &error) != 0) {
		return -1;
	}
	if (!carry_register("can0", &can0.kept, sizeof(can0.kept))) {
		prng_init(&can0.kept.prng, can0.name);
	}
	buffer_append(&can0.staged, staged, size, SIZE_MAX / 2);
	lockstep_add(&lockstep_can0);
	can0.type->start(&can0);
	describe(&can0, text, sizeof(text));
	if (!carry_is_reset() && can0.type != &can_bus_none) {
		host_say("can0 is %s", text);
	}
	return 0;
}

static void save(void)
{
	carry_put("can0/staged", buffer_bytes(&can0.staged), buffer_length(&can0.staged));
	if (can0.type->save != NULL) {
		can0.type->save(&can0);
	}
}

static void stop(void)
{
	if (can0.type->stop != NULL) {
		can0.type->stop(&can0);
	}
	loop_timer_stop(&can0.retry);
	buffer_free(&can0.staged);
	buffer_free(&can0.rx);
	free(can0.state);
	can0.state = NULL;
}

HOST_MODULE(can_module) = {
	.name = "CAN",
	.order = HOST_ORDER_WIRES + 2,
	.options = options,
	.ops = ops,
	.faults = faults,
	.start = start,
	.save = save,
	.stop = stop,
};
