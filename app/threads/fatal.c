/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When the firmware finds itself broken: the lamp off at that instant, then a reset.
 */
#include <zephyr/fatal.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/logging/log_ctrl.h>
#include <zephyr/sys/printk.h>
#include <zephyr/sys/reboot.h>

#include <pharos/compat.h>
#include <pharos/drivers/light.h>

#include "core/assert.h"
#include "threads/devices.h"

void k_sys_fatal_error_handler(unsigned int reason, const struct arch_esf *esf)
{
	light_off_now(devices.light);
	LOG_PANIC();
	printk("fatal error %u: lamp off, reset\n", reason);
	sys_reboot(SYS_REBOOT_COLD);
	CODE_UNREACHABLE;
}

void pharos_assert_failed(const char *file, int line)
{
	light_off_now(devices.light);
	printk("assertion failed: %s:%d\n", file, line);
	k_panic();
	CODE_UNREACHABLE;
}
