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
	CPU_LOOK_MS = 10,
};

#define NS_PER_MS 1000000ull
#define NS_PER_S  1000000000ull

static bool is_virtual;
static bool is_controlled;
static uint64_t until_us = UINT64_MAX;
static uint64_t boot_us;

static uint64_t reading_us;   /* board time, when real: of the last reading of the host's clock */
static uint32_t reading_uses; /* how often it may still serve */

/* All in the host's time. */
static uint64_t looked_ns; /* at the clock */
static uint64_t wait_ns;   /* the end of the wait under way; 0: there is none */
static uint64_t cpu_looked_ns;
static uint64_t cpu_used_ns; /* the processor's time of this thread, then */
static uint64_t untold_ns;

/* The last time that was left out: what the host's clock read before, and how much was behind. */
static struct {
	uint64_t from_ns;
	uint64_t to_ns;
	uint64_t behind_ns;
} gap;

static struct {
	uint64_t virtual_us; /* board time, when virtual */
	uint64_t origin_ns;  /* host time of power-on, when real */
	uint64_t behind_ns;  /* left out and not made up for */
	uint64_t stops_ns;
	uint32_t stops;
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

static uint64_t read_ns(clockid_t clock)
{
	struct timespec now;

	clock_gettime(clock, &now);
	return (uint64_t)now.tv_sec * NS_PER_S + (uint64_t)now.tv_nsec;
}

uint64_t clock_host_ns(void)
{
	return read_ns(CLOCK_MONOTONIC);
}

/* --- when the host stands still ------------------------------------------------------------------
 */

/* The processor's time since it was last asked for, which was CPU_LOOK_MS before looked_ns or
 * later: so that little of it was used before. */
static uint64_t take_cpu_ns(uint64_t now_ns)
{
	const uint64_t before_ns = cpu_used_ns;

	cpu_used_ns = read_ns(CLOCK_THREAD_CPUTIME_ID);
	cpu_looked_ns = now_ns;
	return cpu_used_ns - before_ns;
}

/* The host comes late for what it was to do at due_ns. */
static void come_late(uint64_t due_ns, uint64_t now_ns)
{
	const uint64_t own_ns = take_cpu_ns(now_ns);
	const uint64_t late_ns = now_ns - due_ns;

	if (late_ns < own_ns + CLOCK_LATE_MS * NS_PER_MS) {
		return;
	}
	gap.from_ns = now_ns - (late_ns - own_ns);
	gap.to_ns = now_ns;
	gap.behind_ns = state.behind_ns;
	state.behind_ns += late_ns - own_ns;
	state.stops_ns += late_ns - own_ns;
	state.stops++;
	untold_ns += late_ns - own_ns;
}

/* The host's clock, after what it says of a host that stood still. Real time only. */
static uint64_t look_ns(void)
{
	const uint64_t now_ns = clock_host_ns();
	const uint64_t due_ns = wait_ns > looked_ns ? wait_ns : looked_ns;

	if (now_ns > due_ns && now_ns - due_ns > CLOCK_LATE_MS * NS_PER_MS) {
		come_late(due_ns, now_ns);
	} else {
		const uint64_t faster_ns = (now_ns - looked_ns) / CLOCK_MAKE_UP;

		state.behind_ns -= faster_ns < state.behind_ns ? faster_ns : state.behind_ns;
		if (now_ns - cpu_looked_ns > CPU_LOOK_MS * NS_PER_MS) {
			take_cpu_ns(now_ns);
		}
	}
	looked_ns = now_ns;
	return now_ns;
}

void clock_wait_begin(uint64_t until_ns)
{
	wait_ns = until_ns;
}

void clock_wait_end(void)
{
	if (!is_virtual) {
		look_ns();
	}
	wait_ns = 0;
}

struct clock_stops clock_stops_get(void)
{
	return (struct clock_stops){
		.count = state.stops,
		.total_us = state.stops_ns / 1000u,
		.behind_us = state.behind_ns / 1000u,
	};
}

uint64_t clock_take_stop_ms(void)
{
	const uint64_t stop_ms = untold_ns / NS_PER_MS;

	untold_ns = 0;
	return stop_ms >= CLOCK_TELL_MS ? stop_ms : 0;
}

/* --- board time ----------------------------------------------------------------------------------
 */

static uint64_t board_of_host_ns(uint64_t host_ns)
{
	uint64_t behind_ns = state.behind_ns;

	if (host_ns < gap.to_ns) {
		behind_ns = gap.behind_ns;
		host_ns = host_ns < gap.from_ns ? host_ns : gap.from_ns;
	}
	return host_ns > state.origin_ns + behind_ns ? host_ns - state.origin_ns - behind_ns : 0;
}

uint64_t clock_board_of_host_us(uint64_t host_ns)
{
	return board_of_host_ns(host_ns) / 1000u;
}

uint64_t clock_board_us(void)
{
	return is_virtual ? state.virtual_us : clock_board_of_host_us(look_ns());
}

uint64_t clock_host_until_ns(uint64_t board_us)
{
	const uint64_t now_us = clock_board_us();
	const uint64_t left_us = board_us > now_us ? board_us - now_us : 0;

	/* Too early does no harm: then the rest is waited for. */
	return (state.behind_ns > 0 ? left_us - left_us / CLOCK_MAKE_UP : left_us) * 1000u;
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
	return is_virtual ? (state.virtual_us - boot_us) * 1000u : board_of_host_ns(look_ns());
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
	looked_ns = clock_host_ns();
	take_cpu_ns(looked_ns);
	if (!carry_register("clock", &state, sizeof(state))) {
		state.origin_ns = looked_ns;
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
	.drives = true,
	.start = start,
};
