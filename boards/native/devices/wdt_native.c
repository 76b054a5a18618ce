/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_wdt_native

#include <errno.h>
#include <stdbool.h>

#include <zephyr/device.h>
#include <zephyr/drivers/watchdog.h>
#include <zephyr/kernel.h>

#include "devices/fault.h"
#include "devices/wdt_native.h"
#include "host/reset.h"
#include "kernel/port.h"

#define CHANNELS_MAX 4
#define BOOT_MS      100 /* as IWDG_STM32_INITIAL_TIMEOUT */

struct wdt_native_channel {
	struct k_timer timer;
	uint32_t max_ms;
	wdt_callback_t callback;
	const struct device *dev;
};

struct wdt_native_data {
	struct wdt_native_channel channels[CHANNELS_MAX];
	int count;
	bool running;
	bool at_boot; /* by its driver */
};

static struct wdt_native_data wdt_native_data;

/* Interrupt context. */
static void bite(struct k_timer *timer)
{
	const struct wdt_native_channel *channel =
		CONTAINER_OF(timer, struct wdt_native_channel, timer);
	const struct wdt_native_data *data = channel->dev->data;

	if (channel->callback != NULL) {
		channel->callback(channel->dev, (int)(channel - data->channels));
	}
	port_reset(RESET_CAUSE_WATCHDOG);
}

static int install(const struct device *dev, const struct wdt_timeout_cfg *cfg)
{
	struct wdt_native_data *data = dev->data;
	struct wdt_native_channel *channel;

	if (data->running) {
		return data->at_boot ? -ENOMEM : -EBUSY; /* as STM32's IWDG, and as others */
	}
	if (cfg->window.max == 0) {
		return -EINVAL;
	}
	if (cfg->window.min != 0 || cfg->flags == WDT_FLAG_RESET_NONE) {
		return -ENOTSUP;
	}
	if (data->count == CHANNELS_MAX) {
		return -ENOMEM;
	}
	channel = &data->channels[data->count];
	channel->max_ms = cfg->window.max;
	channel->callback = cfg->callback;
	channel->dev = dev;
	k_timer_init(&channel->timer, bite, NULL);
	return data->count++;
}

static int wdt_native_install_timeout(const struct device *dev, const struct wdt_timeout_cfg *cfg)
{
	const int fault = fault_pass(BOARD_CHIP_WATCHDOG);

	return fault != 0 ? fault : install(dev, cfg);
}

static void restart(struct wdt_native_channel *channel)
{
	k_timer_start(&channel->timer, K_MSEC(channel->max_ms), K_NO_WAIT);
}

static int wdt_native_setup(const struct device *dev, uint8_t options)
{
	struct wdt_native_data *data = dev->data;

	if ((options & ~WDT_OPT_PAUSE_HALTED_BY_DBG) != 0) {
		return -ENOTSUP;
	}
	if (data->running) {
		return -EBUSY;
	}
	data->running = true;
	for (int i = 0; i < data->count; i++) {
		restart(&data->channels[i]);
	}
	return 0;
}

static int wdt_native_disable(const struct device *dev)
{
	struct wdt_native_data *data = dev->data;

	if (!data->running) {
		return -EFAULT;
	}
	for (int i = 0; i < data->count; i++) {
		k_timer_stop(&data->channels[i].timer);
	}
	data->running = false;
	data->count = 0;
	return 0;
}

static int wdt_native_feed(const struct device *dev, int channel_id)
{
	struct wdt_native_data *data = dev->data;
	const int fault = fault_pass(BOARD_CHIP_WATCHDOG);

	if (fault != 0) {
		return fault;
	}
	if (!data->running || channel_id < 0 || channel_id >= data->count) {
		return -EINVAL;
	}
	restart(&data->channels[channel_id]);
	return 0;
}

/* The driver's own time-out, from the first instant on. */
static int start_at_boot(const struct device *dev)
{
	const struct wdt_timeout_cfg boot = {
		.window = {.max = BOOT_MS},
		.flags = WDT_FLAG_RESET_SOC,
	};
	struct wdt_native_data *data = dev->data;
	int rc = install(dev, &boot);

	if (rc >= 0) {
		rc = wdt_native_setup(dev, 0);
		data->at_boot = true;
	}
	return rc;
}

uint64_t wdt_native_bite_us(void)
{
	const struct wdt_native_data *const data = &wdt_native_data;
	uint64_t bite_us = UINT64_MAX;

	for (int i = 0; data->running && i < data->count; i++) {
		bite_us =
			MIN(bite_us, port_clock_now_us() +
		                             k_ticks_to_us_ceil64((uint64_t)k_timer_remaining_ticks(
						     &data->channels[i].timer)));
	}
	return bite_us;
}

static int wdt_native_init(const struct device *dev)
{
	const int error = fault_start(BOARD_CHIP_WATCHDOG);

	return error == 0 && board.watchdog_at_boot ? start_at_boot(dev) : error;
}

static const struct wdt_driver_api wdt_native_api = {
	.setup = wdt_native_setup,
	.disable = wdt_native_disable,
	.install_timeout = wdt_native_install_timeout,
	.feed = wdt_native_feed,
};

BUILD_ASSERT(DT_NUM_INST_STATUS_OKAY(DT_DRV_COMPAT) == 1, "the board has one watchdog");

DEVICE_DT_INST_DEFINE(0, wdt_native_init, NULL, &wdt_native_data, NULL, POST_KERNEL, 40,
                      &wdt_native_api);
