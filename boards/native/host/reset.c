/* SPDX-License-Identifier: Apache-2.0 */
#include "host/reset.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/carry.h"
#include "host/crash.h"
#include "host/module.h"
#include "host/wire.h"
#include "kernel/port.h"

/* What memory without power becomes. */
#define NOINIT_LOST 0xA5

static const struct {
	enum reset_cause cause;
	const char *name;
} names[] = {
	{RESET_CAUSE_PIN, "pin"},           {RESET_CAUSE_SOFTWARE, "software"},
	{RESET_CAUSE_BROWNOUT, "brownout"}, {RESET_CAUSE_POWER_ON, "power-on"},
	{RESET_CAUSE_WATCHDOG, "watchdog"}, {RESET_CAUSE_FAULT, "fault"},
};

static struct {
	uint32_t last;
	uint32_t collected;
} state = {RESET_CAUSE_POWER_ON, RESET_CAUSE_POWER_ON};

/* The device's memory that a reset keeps: what is __noinit, if anything is. */
extern char noinit_start[] __asm__("__start_native_noinit") __attribute__((weak));
extern char noinit_end[] __asm__("__stop_native_noinit") __attribute__((weak));

static size_t noinit_size(void)
{
	return noinit_start == NULL ? 0 : (size_t)(noinit_end - noinit_start);
}

uint32_t reset_causes(void)
{
	return state.collected;
}

void reset_causes_clear(void)
{
	state.collected = 0;
}

uint32_t reset_last_cause(void)
{
	return state.last;
}

const char *reset_cause_name(uint32_t cause)
{
	for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
		if ((uint32_t)names[i].cause == cause) {
			return names[i].name;
		}
	}
	return "unknown";
}

uint32_t reset_cause_find(const char *name)
{
	for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
		if (strcmp(names[i].name, name) == 0) {
			return names[i].cause;
		}
	}
	return 0;
}

_Noreturn void port_reset(uint32_t cause)
{
	host_off();
	port_trace("reset", reset_cause_name(cause), (int64_t)cause);
	if (cause == RESET_CAUSE_POWER_ON || cause == RESET_CAUSE_BROWNOUT) {
		memset(noinit_start, NOINIT_LOST, noinit_size());
	}
	state.last = cause;
	state.collected |= cause;
	wires_flush();
	carry_exec();
}

_Noreturn void port_exit(int status)
{
	static bool ending;

	/* A fault while ending must not start over. */
	if (!ending) {
		ending = true;
		host_off();
		wires_flush();
		host_stop();
	}
	exit(status);
}

static int start(void)
{
	carry_register("reset", &state, sizeof(state));
	if (noinit_size() > 0 && !carry_register("noinit", noinit_start, noinit_size())) {
		memset(noinit_start, NOINIT_LOST, noinit_size());
	}
	return 0;
}

HOST_MODULE(reset_module) = {
	.name = "reset",
	.order = HOST_ORDER_BASE,
	.start = start,
};
