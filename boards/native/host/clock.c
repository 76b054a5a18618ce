/* SPDX-License-Identifier: Apache-2.0 */
#include "host/clock.h"

#include <inttypes.h>
#include <string.h>
#include <time.h>

#include "host/carry.h"
#include "host/module.h"
#include "kernel/port.h"

enum {
	/* Resets of a board whose clock stands still: beyond this, it will never get anywhere. */
	RESETS_MAX = 100,
	/* Readings of the kernel's clock that one of the host's serves: so that a thread which
	   polls the clock sees it move. */
	READINGS_MAX = 64,
};

static bool is_virtual;
static bool is_controlled;
static uint64_t until_us = UINT64_MAX;
static uint64_t boot_us;

static uint64_t reading_us;   /* board time, when real: of the last reading of the host's clock */
static uint32_t reading_uses; /* how often it may still serve */

static struct {
	uint64_t virtual_us; /* board time, when virtual */
	uint64_t origin_ns;  /* host time of power-on, when real */
	uint64_t last_boot_us;
	uint32_t resets; /* at this board time */
} state;

bool clock_is_virtual(void)
{
	return is_virtual;
}

bool clock_is_lockstep(void)
{
	return is_virtual && is_controlled;
}

void clock_control(void)
{
	is_controlled = true;
}

uint64_t clock_until_us(void)
{
	return until_us;
}

uint64_t clock_host_ns(void)
{
	struct timespec now;

	clock_gettime(CLOCK_MONOTONIC, &now);
	return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

uint64_t clock_board_of_host_us(uint64_t host_ns)
{
	return host_ns > state.origin_ns ? (host_ns - state.origin_ns) / 1000u : 0;
}

uint64_t clock_board_us(void)
{
	return is_virtual ? state.virtual_us : clock_board_of_host_us(clock_host_ns());
}

uint64_t clock_boot_us(void)
{
	return boot_us;
}

void clock_jump(uint64_t us)
{
	if (us > state.virtual_us) {
		state.virtual_us = us;
	}
}

void clock_stale(void)
{
	reading_uses = 0;
}

/* A reading costs as much as a context switch, and no time passes while code runs. */
uint64_t port_clock_now_us(void)
{
	if (is_virtual) {
		return state.virtual_us - boot_us;
	}
	if (reading_uses == 0) {
		reading_us = clock_board_us();
		reading_uses = READINGS_MAX;
	}
	reading_uses--;
	return reading_us - boot_us;
}

uint64_t port_cycles(void)
{
	return is_virtual ? (state.virtual_us - boot_us) * 1000u : clock_host_ns();
}

void port_clock_busy_wait(uint64_t wait_until_us)
{
	if (is_virtual) {
		clock_jump(boot_us + wait_until_us);
		return;
	}
	while (clock_board_us() - boot_us < wait_until_us) {
	}
	clock_stale();
}

static int parse_time(const char *value, struct host_error *error)
{
	if (strcmp(value, "real") != 0 && strcmp(value, "virtual") != 0) {
		return host_error_set(error, "\"%.60s\" is neither real nor virtual", value);
	}
	is_virtual = strcmp(value, "virtual") == 0;
	return 0;
}

static int parse_until(const char *value, struct host_error *error)
{
	return parse_duration_us(value, &until_us, error);
}

static int start(void)
{
	if (!carry_register("clock", &state, sizeof(state))) {
		state.origin_ns = clock_host_ns();
		return 0;
	}
	boot_us = clock_board_us();
	state.resets = boot_us == state.last_boot_us ? state.resets + 1 : 0;
	state.last_boot_us = boot_us;
	if (state.resets > RESETS_MAX) {
		fprintf(stderr, "pharos: %d resets at %" PRIu64 " us: it never gets further\n",
		        RESETS_MAX, boot_us);
		return -1;
	}
	return 0;
}

static const struct host_option options[] = {
	{"time", "real|virtual",
         "real (default): the host's clock. virtual: time jumps to the next\n"
         "event; with --control it stands still until told to advance",
         parse_time},
	{"until", "DURATION", "end at this board time: 500ms, 2s, 10min, 24h", parse_until},
	{0},
};

HOST_MODULE(clock_module) = {
	.name = "time",
	.order = HOST_ORDER_BASE,
	.options = options,
	.start = start,
};
