/* SPDX-License-Identifier: Apache-2.0 */
/* What the processor does when no thread is ready: the one place where the host's world comes in.
 */
#include "host/clock.h"
#include "host/control.h"
#include "host/lockstep.h"
#include "host/loop.h"
#include "host/module.h"
#include "host/say.h"
#include "host/wire.h"
#include "kernel/port.h"

enum {
	JUMPS_PER_POLL = 4096
};

static void tell_up(void)
{
	static bool told;

	if (!told) {
		told = true;
		host_up();
	}
}

static void idle_real(uint64_t deadline_us)
{
	uint64_t stop_ms;

	wires_flush();
	tell_up();
	if (control_run_one()) {
		return;
	}
	stop_ms = clock_take_stop_ms();
	if (stop_ms > 0) {
		host_say("host stood still for %.1f s", (double)stop_ms / 1000.0);
	}
	if (clock_board_us() >= clock_until_us()) {
		port_exit(0);
	}
	if (deadline_us > clock_until_us()) {
		deadline_us = clock_until_us();
	}
	if (deadline_us == UINT64_MAX) {
		loop_poll(-1);
	} else {
		loop_poll((int64_t)clock_host_until_ns(deadline_us));
	}
}

/* Virtual time that nobody controls: as fast as it goes. */
static void idle_free(uint64_t deadline_us)
{
	static uint32_t jumps;

	if (++jumps % JUMPS_PER_POLL == 0) {
		wires_flush();
		loop_poll(0);
	}
	if (deadline_us >= clock_until_us()) {
		clock_jump(clock_until_us());
		port_exit(0);
	}
	if (deadline_us != UINT64_MAX) {
		clock_jump(deadline_us);
		return;
	}
	wires_flush();
	if (loop_sources() == 0) {
		static const char text[] =
			"pharos: every thread waits for ever, and so does time\n";

		port_console_write(text, sizeof(text) - 1);
		port_exit(1);
	}
	loop_poll(-1);
}

void port_idle(uint64_t deadline_us)
{
	const uint64_t board_us =
		deadline_us == UINT64_MAX ? UINT64_MAX : clock_boot_us() + deadline_us;

	if (loop_interrupted()) {
		port_exit(0);
	}
	if (!clock_is_virtual()) {
		clock_stale();
		idle_real(board_us);
		clock_stale();
	} else if (board_us > clock_board_us()) {
		if (clock_is_lockstep()) {
			tell_up();
			lockstep_idle(board_us);
		} else {
			idle_free(board_us);
		}
	}
}
