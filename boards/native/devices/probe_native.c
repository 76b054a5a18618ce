/* SPDX-License-Identifier: Apache-2.0 */
#define DT_DRV_COMPAT pharos_probe

#include <zephyr/device.h>
#include <zephyr/toolchain.h>

#include <pharos/drivers/probe.h>

#include "host/clock.h"
#include "models/board.h"

BUILD_ASSERT((unsigned int)PROBE_COMMAND == BOARD_PROBE_COMMAND, "as models/board.h says");
BUILD_ASSERT(PROBE_COUNT <= BOARD_PROBE_COUNT, "the board keeps every channel");

static void probe_native_set(const struct device *dev, enum probe_channel channel, int64_t value)
{
	board_probe((int64_t)clock_board_us(), channel, value);
}

static int probe_native_init(const struct device *dev)
{
	return 0;
}

static const struct probe_driver_api probe_native_api = {
	.set = probe_native_set,
};

#define PROBE_NATIVE_DEFINE(inst)                                                                  \
	DEVICE_DT_INST_DEFINE(inst, probe_native_init, NULL, NULL, NULL, PRE_KERNEL_1, 40,         \
	                      &probe_native_api);

DT_INST_FOREACH_STATUS_OKAY(PROBE_NATIVE_DEFINE)
