/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/supervisor.h"

#include <errno.h>

#include <zephyr/drivers/watchdog.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/atomic.h>
#include <zephyr/sys/reboot.h>

#include <pharos/drivers/light.h>

#include "threads/devices.h"
#include "threads/reset_cause.h"
#include "threads/startup.h"

LOG_MODULE_REGISTER(supervisor);

/* Uptime of each thread's last report in ms, never 0; 0: not watched. */
static atomic_t reported_ms[SUPERVISOR_WATCHES];
/* Bit per watch that has reported since it is watched. */
static atomic_t have_reported;
static int watchdog_channel;
static uint32_t watchdog_ms;

static const char *const names[SUPERVISOR_WATCHES] = {
	[SUPERVISOR_START] = "start-up",        [SUPERVISOR_THERMAL] = "thermal",
	[SUPERVISOR_COMMAND] = "command",       [SUPERVISOR_UART_LINK0] = "uart_link0",
	[SUPERVISOR_UART_LINK1] = "uart_link1", [SUPERVISOR_UART_LINK2] = "uart_link2",
	[SUPERVISOR_UART_LINK3] = "uart_link3", [SUPERVISOR_CAN_LINK] = "can_link",
	[SUPERVISOR_IMC_LINK] = "imc_link",
};

_Static_assert(SUPERVISOR_WATCHES <= 32, "a bit each");

/* --- watchdog --------------------------------------------------------------------------------- */

/* A driver that starts it at boot, as STM32's from Zephyr 4.2 on, takes no second time-out. */
static bool runs_already(int error)
{
	return error == -ENOMEM || error == -EBUSY;
}

static int arm(void)
{
	const struct wdt_timeout_cfg config = {
		.window = {.min = 0, .max = SUPERVISOR_WATCHDOG_MS},
		.flags = WDT_FLAG_RESET_SOC,
	};
	const int channel = wdt_install_timeout(devices.watchdog, &config);

	if (runs_already(channel)) {
		watchdog_channel = 0;
		watchdog_ms = SUPERVISOR_RUNNING_MS;
		return wdt_feed(devices.watchdog, watchdog_channel);
	}
	watchdog_channel = channel;
	watchdog_ms = SUPERVISOR_WATCHDOG_MS;
	return channel < 0 ? channel : wdt_setup(devices.watchdog, WDT_OPT_PAUSE_HALTED_BY_DBG);
}

static void start_watchdog(void)
{
	const int error = device_is_ready(devices.watchdog) ? arm() : -ENODEV;

	startup_done(STARTUP_WATCHDOG, error);
	if (error != 0) {
		watchdog_ms = 0;
		return;
	}
	LOG_INF("watchdog: %u ms%s", watchdog_ms,
	        watchdog_ms == SUPERVISOR_WATCHDOG_MS ? "" : ", it ran before");
}

uint32_t supervisor_watchdog_ms(void)
{
	return watchdog_ms;
}

/* --- watches ---------------------------------------------------------------------------------- */

static void stamp(enum supervisor_watch watch)
{
	atomic_set(&reported_ms[watch], (atomic_val_t)(k_uptime_get_32() | 1u));
}

void supervisor_watch(enum supervisor_watch watch)
{
	atomic_and(&have_reported, ~BIT(watch));
	stamp(watch);
}

void supervisor_unwatch(enum supervisor_watch watch)
{
	atomic_set(&reported_ms[watch], 0);
}

void supervisor_report(enum supervisor_watch watch)
{
	if (atomic_get(&reported_ms[watch]) != 0) {
		atomic_or(&have_reported, BIT(watch));
		stamp(watch);
	}
}

int32_t supervisor_age_ms(enum supervisor_watch watch)
{
	const uint32_t reported = (uint32_t)atomic_get(&reported_ms[watch]);

	return reported == 0 ? -1 : MAX(0, (int32_t)(k_uptime_get_32() - reported));
}

bool supervisor_all_report(void)
{
	for (int watch = 0; watch < SUPERVISOR_WATCHES; watch++) {
		const int32_t age_ms = supervisor_age_ms((enum supervisor_watch)watch);

		if (age_ms > SUPERVISOR_LIMIT_MS ||
		    (age_ms >= 0 && (atomic_get(&have_reported) & BIT(watch)) == 0)) {
			return false;
		}
	}
	return true;
}

/* --- thread ----------------------------------------------------------------------------------- */

static bool all_well(void)
{
	bool all = true;

	for (int watch = 0; watch < SUPERVISOR_WATCHES; watch++) {
		const int32_t age_ms = supervisor_age_ms((enum supervisor_watch)watch);

		if (age_ms > SUPERVISOR_LIMIT_MS) {
			LOG_ERR("thread %s stalled: no report for %d ms", names[watch], age_ms);
			reset_cause_blame(names[watch]);
			all = false;
		}
	}
	if (all) {
		reset_cause_blame(NULL);
	}
	return all;
}

static uint32_t period_ms(void)
{
	const uint32_t quarter_ms = watchdog_ms / 4;

	return quarter_ms == 0 ? SUPERVISOR_PERIOD_MS : MIN(quarter_ms, SUPERVISOR_PERIOD_MS);
}

/* What a watchdog would do, as late as it would. */
static void bite_instead(int64_t well_ms)
{
	if (watchdog_ms == 0 && k_uptime_get() - well_ms > SUPERVISOR_WATCHDOG_MS) {
		light_off_now(devices.light);
		sys_reboot(SYS_REBOOT_COLD);
	}
}

void supervisor_run(void *p1, void *p2, void *p3)
{
	start_watchdog();
	int64_t well_ms = k_uptime_get();

	for (;;) {
		if (!all_well()) {
			bite_instead(well_ms);
		} else {
			well_ms = k_uptime_get();
			if (watchdog_ms != 0) {
				wdt_feed(devices.watchdog, watchdog_channel);
			}
		}
		k_msleep((int32_t)period_ms());
	}
}
