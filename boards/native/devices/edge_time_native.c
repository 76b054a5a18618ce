/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_edge_time

#include <zephyr/device.h>
#include <zephyr/toolchain.h>

#include <pharos/drivers/edge_time.h>

#include "devices/fault.h"
#include "host/clock.h"
#include "kernel/port.h"
#include "models/board.h"

static int64_t edge_time_native_get_us(const struct device *dev, const struct gpio_dt_spec *input)
{
	/* an error cannot be told here: the edge is as old as its interrupt */
	if (fault_pass(BOARD_CHIP_COUNTER) != 0) {
		return (int64_t)port_clock_now_us();
	}
	const int64_t us = board.edge_us[input->pin] - (int64_t)clock_boot_us();

	return us > 0 ? us : 0; /* an edge before this boot */
}

static int edge_time_native_init(const struct device *dev)
{
	return fault_start(BOARD_CHIP_COUNTER);
}

static const struct edge_time_driver_api edge_time_native_api = {
	.get_us = edge_time_native_get_us,
};

#define EDGE_TIME_NATIVE_DEFINE(inst)                                                              \
	DEVICE_DT_INST_DEFINE(inst, edge_time_native_init, NULL, NULL, NULL, PRE_KERNEL_1, 40,     \
	                      &edge_time_native_api);

DT_INST_FOREACH_STATUS_OKAY(EDGE_TIME_NATIVE_DEFINE)
