/* SPDX-License-Identifier: Apache-2.0 */
/* The control operations of the host itself: hello, ops, wires, fault, reset, quit. */
#include <string.h>

#include "host/carry.h"
#include "host/clock.h"
#include "host/console.h"
#include "host/control.h"
#include "host/module.h"
#include "host/prng.h"
#include "host/reset.h"
#include "host/wire.h"
#include "kernel/port.h"

static bool reset_reply_due; /* carried */

static enum control_result run_hello(struct control_call *call)
{
	control_put_string(call->reply, "name", "pharos");
	control_put_string(call->reply, "version", PHAROS_VERSION);
	control_put_string(call->reply, "time", clock_is_virtual() ? "virtual" : "real");
	control_put_integer(call->reply, "seed", (int64_t)prng_seed());
	control_put_integer(call->reply, "now_us", (int64_t)clock_board_us());
	control_put_integer(call->reply, "boot_us", (int64_t)clock_boot_us());
	control_put_string(call->reply, "reset_cause", reset_cause_name(reset_last_cause()));
	return CONTROL_OK;
}

static void list(json_t *to, const char *key, const char *name, const char *help)
{
	json_t *entry = json_object();

	control_put_string(entry, key, name);
	control_put_string(entry, "help", help);
	json_array_append_new(to, entry);
}

static enum control_result run_ops(struct control_call *call)
{
	size_t count;
	const struct host_module *const *modules = host_modules(&count);
	json_t *ops = json_array();
	json_t *faults = json_array();

	for (size_t i = 0; i < count; i++) {
		const struct control_op *op = modules[i]->ops;
		const struct control_fault *fault = modules[i]->faults;

		for (; op != NULL && op->name != NULL; op++) {
			list(ops, "op", op->name, op->help);
		}
		for (; fault != NULL && fault->device != NULL; fault++) {
			list(faults, "device", fault->device, fault->help);
		}
	}
	json_object_set_new(call->reply, "ops", ops);
	json_object_set_new(call->reply, "faults", faults);
	return CONTROL_OK;
}

static enum control_result run_wires(struct control_call *call)
{
	json_t *wires = json_object();
	const struct wire *wire;

	for (size_t i = 0; (wire = wire_at(i)) != NULL; i++) {
		const struct wire_counts *counts = &wire->kept.counts;
		char text[WIRE_URL_MAX + 64];
		json_t *entry = json_object();

		wire_describe(wire, text, sizeof(text));
		control_put_string(entry, "address", text);
		control_put_integer(entry, "rx_bytes", (int64_t)counts->rx_bytes);
		control_put_integer(entry, "tx_bytes", (int64_t)counts->tx_bytes);
		control_put_integer(entry, "rx_datagrams", (int64_t)counts->rx_datagrams);
		control_put_integer(entry, "tx_datagrams", (int64_t)counts->tx_datagrams);
		control_put_integer(entry, "tx_drops", (int64_t)counts->tx_drops);
		control_put_integer(entry, "errors", (int64_t)counts->errors);
		control_put_integer(entry, "reconnects", (int64_t)counts->reconnects);
		control_put_integer(entry, "faults", (int64_t)counts->faults);
		json_object_set_new(wires, wire->name, entry);
	}
	json_object_set_new(call->reply, "wires", wires);
	return CONTROL_OK;
}

static enum control_result run_host(struct control_call *call)
{
	struct clock_stops stops;

	control_put_integer(call->reply, "now_us", (int64_t)clock_board_us());
	stops = clock_stops_get();
	control_put_integer(call->reply, "stops", stops.count);
	control_put_integer(call->reply, "stopped_us", (int64_t)stops.total_us);
	control_put_integer(call->reply, "behind_us", (int64_t)stops.behind_us);
	control_put_integer(call->reply, "dropped_lines", (int64_t)console_dropped());
	return CONTROL_OK;
}

static enum control_result run_reset(struct control_call *call)
{
	const char *name = "pin";
	uint32_t cause;

	if (json_object_get(call->request, "cause") != NULL &&
	    !control_string(call, "cause", &name)) {
		return CONTROL_ERROR;
	}
	cause = reset_cause_find(name);
	if (cause == 0) {
		return control_fail(call, "\"cause\" must be pin, software, brownout, power-on, "
		                          "watchdog or fault");
	}
	reset_reply_due = true;
	port_reset(cause);
}

/* The kernel has started: the reply to the reset before is due. */
static void up(void)
{
	json_t *reply;

	if (!reset_reply_due) {
		return;
	}
	reset_reply_due = false;
	reply = json_object();
	control_put_integer(reply, "now_us", (int64_t)clock_board_us());
	control_put_string(reply, "reset_cause", reset_cause_name(reset_last_cause()));
	control_reply(reply, NULL);
}

static enum control_result run_quit(struct control_call *call)
{
	(void)call;
	control_quit();
	return CONTROL_OK;
}

/* --- faults --------------------------------------------------------------------------------------
 */

static bool set_fault(struct wire_fault *fault, const char *kind, uint32_t rate_ppm)
{
	if (strcmp(kind, "none") == 0) {
		*fault = (struct wire_fault){0};
	} else if (strcmp(kind, "lost") == 0) {
		fault->lost_ppm = rate_ppm;
	} else if (strcmp(kind, "flipped") == 0) {
		fault->flipped_ppm = rate_ppm;
	} else if (strcmp(kind, "doubled") == 0) {
		fault->doubled_ppm = rate_ppm;
	} else {
		return false;
	}
	return true;
}

static enum control_result run_wire_fault(struct control_call *call, struct wire *wire)
{
	const char *kind;
	const char *direction = "both";
	int64_t rate_ppm = 0;
	struct wire_fault unused;

	if (!control_string(call, "kind", &kind) ||
	    (json_object_get(call->request, "direction") != NULL &&
	     !control_string(call, "direction", &direction))) {
		return CONTROL_ERROR;
	}
	if (!set_fault(&unused, kind, 0)) {
		return control_fail(call, "\"kind\" must be lost, flipped, doubled or none");
	}
	if (strcmp(kind, "none") != 0 &&
	    !control_integer(call, "rate_ppm", 0, 1000000, &rate_ppm)) {
		return CONTROL_ERROR;
	}
	if (strcmp(direction, "rx") != 0 && strcmp(direction, "tx") != 0 &&
	    strcmp(direction, "both") != 0) {
		return control_fail(call, "\"direction\" must be rx, tx or both");
	}
	if (strcmp(direction, "tx") != 0) {
		set_fault(&wire->kept.rx_fault, kind, (uint32_t)rate_ppm);
	}
	if (strcmp(direction, "rx") != 0) {
		set_fault(&wire->kept.tx_fault, kind, (uint32_t)rate_ppm);
	}
	return CONTROL_OK;
}

static enum control_result run_fault(struct control_call *call)
{
	size_t count;
	const struct host_module *const *modules = host_modules(&count);
	const char *device;
	struct wire *wire;

	if (!control_string(call, "device", &device)) {
		return CONTROL_ERROR;
	}
	wire = wire_find(device);
	if (wire != NULL) {
		return run_wire_fault(call, wire);
	}
	for (size_t i = 0; i < count; i++) {
		const struct control_fault *fault = modules[i]->faults;

		for (; fault != NULL && fault->device != NULL; fault++) {
			if (strcmp(fault->device, device) == 0) {
				return fault->run(call);
			}
		}
	}
	return control_fail(call, "no device \"%.60s\" takes faults; {\"op\":\"ops\"} lists those",
	                    device);
}

static const struct control_op ops[] = {
	{"hello", "name, version, kind of time, seed, board time, cause of the last reset",
         run_hello},
	{"ops", "all operations, and all devices that take faults", run_ops},
	{"wires", "address and counters of every wire", run_wires},
	{"host",
         "how long the host has stood still and what is to be made up for; lines it dropped",
         run_host},
	{"fault", "device, kind, and what that device takes: injects a fault; kind none ends it",
         run_fault},
	{"reset", "cause (pin): resets the board; the reply comes when it is up again", run_reset},
	{"quit", "ends the process with status 0", run_quit},
	{0},
};

static int start(void)
{
	carry_register("control/reset", &reset_reply_due, sizeof(reset_reply_due));
	return 0;
}

/* A UART's faults are found by its name; listed here once, for the reader of `ops`. */
static enum control_result run_no_wire(struct control_call *call)
{
	return control_fail(call,
	                    "\"device\" must be the name of a wire; {\"op\":\"wires\"} lists them");
}

static const struct control_fault faults[] = {
	{"uart",
         "(uart0 … uart3, console) kind: lost, flipped, doubled, none; rate_ppm of the bytes; "
         "direction: rx, tx, both",
         run_no_wire},
	{0},
};

HOST_MODULE(control_ops_module) = {
	.name = "control-ops",
	.order = HOST_ORDER_CONTROL - 1,
	.ops = ops,
	.faults = faults,
	.start = start,
	.up = up,
};
