/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/trial.h"

#include <zephyr/kernel.h>

#include "threads/firmware.h"
#include "threads/startup.h"
#include "threads/supervisor.h"
#include "threads/thermal.h"

static void look(struct k_work *work)
{
	if (startup_is_whole() && supervisor_all_report() && thermal_thread_has_sampled()) {
		firmware_confirm();
	} else {
		k_work_reschedule(k_work_delayable_from_work(work), K_MSEC(SUPERVISOR_PERIOD_MS));
	}
}

static K_WORK_DELAYABLE_DEFINE(trial, look);

void trial_start(void)
{
	k_work_reschedule(&trial, K_MSEC(TRIAL_MS));
}
