/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_wdt_timer

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/drivers/watchdog.h>
#include <zephyr/kernel.h>

#include <pharos/compat.h>

struct wdt_timer_data {
	struct k_timer timer;
	uint32_t timeout_ms; /* 0: none installed */
	bool running;
};

/* In the timer's interrupt. The application's fatal error handler makes all safe and resets. */
static void bite(struct k_timer *timer)
{
	k_panic();
}

static int wdt_timer_install(const struct device *dev, const struct wdt_timeout_cfg *config)
{
	struct wdt_timer_data *data = dev->data;

	if (data->running) {
		return -EBUSY;
	}
	if (data->timeout_ms != 0) {
		return -ENOMEM;
	}
	if (config->window.min != 0 || config->window.max == 0) {
		return -EINVAL;
	}
	if (config->callback != NULL) {
		return -ENOTSUP;
	}
	data->timeout_ms = config->window.max;
	return 0;
}

static int wdt_timer_setup(const struct device *dev, uint8_t options)
{
	struct wdt_timer_data *data = dev->data;

	if (data->running) {
		return -EBUSY;
	}
	if (data->timeout_ms == 0) {
		return -EINVAL;
	}
	data->running = true;
	k_timer_start(&data->timer, K_MSEC(data->timeout_ms), K_NO_WAIT);
	return 0;
}

static int wdt_timer_disable(const struct device *dev)
{
	struct wdt_timer_data *data = dev->data;

	if (!data->running) {
		return -EFAULT;
	}
	k_timer_stop(&data->timer);
	data->running = false;
	data->timeout_ms = 0;
	return 0;
}

static int wdt_timer_feed(const struct device *dev, int channel)
{
	struct wdt_timer_data *data = dev->data;

	if (channel != 0 || !data->running) {
		return -EINVAL;
	}
	k_timer_start(&data->timer, K_MSEC(data->timeout_ms), K_NO_WAIT);
	return 0;
}

static int wdt_timer_init(const struct device *dev)
{
	struct wdt_timer_data *data = dev->data;

	k_timer_init(&data->timer, bite, NULL);
	return 0;
}

static DEVICE_API(wdt, wdt_timer_api) = {
	.setup = wdt_timer_setup,
	.disable = wdt_timer_disable,
	.install_timeout = wdt_timer_install,
	.feed = wdt_timer_feed,
};

#define WDT_TIMER_DEFINE(inst)                                                                     \
	static struct wdt_timer_data wdt_timer_data_##inst;                                        \
	DEVICE_DT_INST_DEFINE(inst, wdt_timer_init, NULL, &wdt_timer_data_##inst, NULL,            \
	                      POST_KERNEL, CONFIG_KERNEL_INIT_PRIORITY_DEVICE, &wdt_timer_api);

DT_INST_FOREACH_STATUS_OKAY(WDT_TIMER_DEFINE)
