/* SPDX-License-Identifier: Apache-2.0 */
#include "devices/bridge.h"

#include <stdio.h>
#include <string.h>

#include <zephyr/kernel.h>

#include "host/clock.h"
#include "host/helper.h"
#include "models/board.h"

struct search {
	const char *name;
	struct k_thread *found;
	char *names;
	size_t size;
	size_t used;
};

static void visit(const struct k_thread *thread, void *arg)
{
	struct search *search = arg;
	struct k_thread *self = (struct k_thread *)thread;
	const char *name = k_thread_name_get(self);

	if (name == NULL || name[0] == '\0') {
		return;
	}
	if (strcmp(name, search->name) == 0) {
		search->found = self;
	}
	if (search->used < search->size) {
		search->used +=
			(size_t)snprintf(search->names + search->used, search->size - search->used,
		                         "%s%s", search->used == 0 ? "" : ", ", name);
	}
}

bool bridge_stall_thread(const char *name, bool stalled, char *names, size_t size)
{
	struct search search = {.name = name, .names = names, .size = size};

	k_thread_foreach(visit, &search);
	if (search.found == NULL) {
		return false;
	}
	if (stalled) {
		k_thread_suspend(search.found);
	} else {
		k_thread_resume(search.found);
	}
	return true;
}

static struct pulse {
	struct k_timer timer;
	bool back;
} pulses[BOARD_LINE_COUNT];

static void pulse_end(struct k_timer *timer)
{
	const struct pulse *pulse = CONTAINER_OF(timer, struct pulse, timer);

	board_line_drive((int64_t)clock_board_us(), (uint32_t)(pulse - pulses), pulse->back);
}

void bridge_line_pulse(uint32_t line, bool level, uint32_t pulse_us)
{
	struct pulse *pulse = &pulses[line];

	bridge_line_pulse_stop(line);
	pulse->back = !level;
	k_timer_init(&pulse->timer, pulse_end, NULL);
	/* absolute: not a tick later, as a relative time-out would be */
	k_timer_start(
		&pulse->timer,
		K_TIMEOUT_ABS_TICKS(k_uptime_ticks() + (int64_t)k_us_to_ticks_ceil64(pulse_us)),
		K_NO_WAIT);
	board_line_drive((int64_t)clock_board_us(), line, level);
}

void bridge_line_pulse_stop(uint32_t line)
{
	if (pulses[line].timer.expiry_fn != NULL) {
		k_timer_stop(&pulses[line].timer);
	}
}

/* --- waiting for the host ------------------------------------------------------------------------
 */

struct wait {
	struct helper_job job;
	struct k_sem done;
	void (*work)(void *arg);
	void *arg;
};

static struct helper disk = {.name = "pharos-disk"};

/* On the helper's thread. */
static void run_work(struct helper_job *job)
{
	const struct wait *wait = CONTAINER_OF(job, struct wait, job);

	wait->work(wait->arg);
}

static void end_wait(struct helper_job *job)
{
	k_sem_give(&CONTAINER_OF(job, struct wait, job)->done);
}

void bridge_wait_for(void (*work)(void *arg), void *arg)
{
	struct wait wait = {.job = {.work = run_work, .done = end_wait}, .work = work, .arg = arg};

	if (clock_is_virtual() || k_is_in_isr()) {
		work(arg);
		return;
	}
	(void)k_sem_init(&wait.done, 0, 1);
	helper_submit(&disk, &wait.job);
	(void)k_sem_take(&wait.done, K_FOREVER);
}

void bridge_finish(void)
{
	(void)helper_finish(&disk, HELPER_FINISH_MS);
}
