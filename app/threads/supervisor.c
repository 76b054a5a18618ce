/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/supervisor.h"

#include <zephyr/drivers/watchdog.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/atomic.h>

#include "threads/devices.h"
#include "threads/firmware.h"
#include "threads/reset_cause.h"

LOG_MODULE_REGISTER(supervisor);

/* Uptime of each thread's last report in ms, never 0; 0: has not reported yet. */
static atomic_t reported_ms[SUPERVISOR_WATCHES];
static int watchdog_channel;

static const char *const names[SUPERVISOR_WATCHES] = {
	[SUPERVISOR_THERMAL] = "thermal",       [SUPERVISOR_COMMAND] = "command",
	[SUPERVISOR_UART_LINK0] = "uart_link0", [SUPERVISOR_UART_LINK1] = "uart_link1",
	[SUPERVISOR_UART_LINK2] = "uart_link2", [SUPERVISOR_UART_LINK3] = "uart_link3",
	[SUPERVISOR_CAN_LINK] = "can_link",     [SUPERVISOR_IMC_LINK] = "imc_link",
};

const char *supervisor_name(enum supervisor_watch watch)
{
	return names[watch];
}

int supervisor_init(void)
{
	const struct wdt_timeout_cfg config = {
		.window = {.min = 0, .max = SUPERVISOR_WATCHDOG_MS},
		.flags = WDT_FLAG_RESET_SOC,
	};

	watchdog_channel = wdt_install_timeout(devices.watchdog, &config);
	if (watchdog_channel < 0) {
		return watchdog_channel;
	}
	return wdt_setup(devices.watchdog, WDT_OPT_PAUSE_HALTED_BY_DBG);
}

void supervisor_report(enum supervisor_watch watch)
{
	atomic_set(&reported_ms[watch], (atomic_val_t)(k_uptime_get_32() | 1u));
}

int32_t supervisor_age_ms(enum supervisor_watch watch)
{
	const uint32_t reported = (uint32_t)atomic_get(&reported_ms[watch]);

	return reported == 0 ? -1 : MAX(0, (int32_t)(k_uptime_get_32() - reported));
}

static bool all_report(void)
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
	return all;
}

void supervisor_run(void *p1, void *p2, void *p3)
{
	bool has_confirmed = false;

	for (;;) {
		if (all_report()) {
			wdt_feed(devices.watchdog, watchdog_channel);
			if (!has_confirmed && k_uptime_get_32() >= SUPERVISOR_CONFIRM_MS) {
				has_confirmed = true;
				firmware_confirm();
			}
		}
		k_msleep(SUPERVISOR_PERIOD_MS);
	}
}
