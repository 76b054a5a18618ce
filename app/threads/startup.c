/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/startup.h"

#include <errno.h>

#include <zephyr/logging/log.h>
#include <zephyr/sys/util.h>

LOG_MODULE_REGISTER(startup);

/* One thread writes each; a reader sees an old result or the new one. */
static volatile int16_t results[STARTUP_STEPS] = {[0 ... STARTUP_STEPS - 1] = STARTUP_PENDING};

static const char *const names[STARTUP_STEPS] = {
	[STARTUP_WATCHDOG] = "watchdog",
	[STARTUP_LIGHT] = "light",
	[STARTUP_SENSOR] = "sensor",
	[STARTUP_STORAGE] = "storage",
	[STARTUP_SYNC] = "sync input",
	[STARTUP_EDGE_TIME] = "edge time",
	[STARTUP_STRAP] = "straps",
	[STARTUP_UART_LINK0] = "uart0",
	[STARTUP_UART_LINK1] = "uart1",
	[STARTUP_UART_LINK2] = "uart2",
	[STARTUP_UART_LINK3] = "uart3",
	[STARTUP_CAN_LINK] = "can0",
	[STARTUP_IMC_LINK] = "imc",
	[STARTUP_SERVOS] = "servos",
	[STARTUP_DRIVER_FAULT] = "driver fault",
	[STARTUP_BUTTON] = "button",
};

void startup_done(enum startup_step step, int result)
{
	results[step] = (int16_t)result;
	if (result < 0) {
		LOG_ERR("%s: error %d", names[step], result);
	}
}

int startup_device(enum startup_step step, const struct device *device)
{
	int result = STARTUP_ABSENT;

	if (device != NULL) {
		result = device_is_ready(device) ? 0 : -ENODEV;
	}
	startup_done(step, result);
	return result;
}

int startup_result(enum startup_step step)
{
	return results[step];
}

enum startup_step startup_failed(enum startup_step from)
{
	while (from < STARTUP_STEPS && results[from] >= 0) {
		from++;
	}
	return from;
}

bool startup_is_whole(void)
{
	for (int step = 0; step < STARTUP_STEPS; step++) {
		if (results[step] != 0 && results[step] != STARTUP_ABSENT) {
			return false;
		}
	}
	return true;
}

bool startup_allows_light(void)
{
	return results[STARTUP_WATCHDOG] == 0 && results[STARTUP_LIGHT] == 0;
}

const char *startup_name(enum startup_step step)
{
	return names[step];
}
