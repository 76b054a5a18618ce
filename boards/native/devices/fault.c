/* SPDX-License-Identifier: Apache-2.0 */
#include "devices/fault.h"

#include <errno.h>
#include <string.h>

#include <zephyr/kernel.h>

#include "devices/wdt_native.h"
#include "host/reset.h"
#include "kernel/port.h"

static bool may_sleep(void)
{
	return native_cpu.isr_depth == 0 && !native_cpu.irq_locked;
}

static void wait_us(uint32_t us)
{
	if (may_sleep()) {
		k_usleep((int32_t)us);
	} else {
		k_busy_wait(us);
	}
}

static void wait_for_ever(void)
{
	if (!may_sleep()) {
		const uint64_t bite_us = wdt_native_bite_us();

		if (bite_us == UINT64_MAX) {
			port_console_write("the CPU hangs, and no watchdog runs\n", 36);
			port_exit(1);
		}
		port_clock_busy_wait(bite_us);
		port_reset(RESET_CAUSE_WATCHDOG);
	}
	for (;;) {
		k_sleep(K_FOREVER);
	}
}

enum board_chip fault_chip(const char *name)
{
	uint32_t chip = 0;

	while (chip < BOARD_CHIP_COUNT && strcmp(board_chip_name(chip), name) != 0) {
		chip++;
	}
	return (enum board_chip)chip;
}

int fault_pass(enum board_chip chip)
{
	const struct board_fault *const fault = fault_of(chip);

	switch (fault->kind) {
	case BOARD_FAULT_NONE:
		return 0;
	case BOARD_FAULT_ERROR:
		return -EIO;
	case BOARD_FAULT_LATE:
		wait_us(fault->delay_us);
		return 0;
	case BOARD_FAULT_NEVER:
		wait_for_ever();
	}
	return 0;
}

int fault_start(enum board_chip chip)
{
	return fault_of(chip)->kind == BOARD_FAULT_ERROR ? -EIO : 0;
}
