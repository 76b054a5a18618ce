/* SPDX-License-Identifier: Apache-2.0 */
/* Resets the board; both types do the same here. Any context. */
#ifndef ZEPHYR_SYS_REBOOT_H_
#define ZEPHYR_SYS_REBOOT_H_

#include <zephyr/toolchain.h>

#define SYS_REBOOT_WARM 0
#define SYS_REBOOT_COLD 1

FUNC_NORETURN void sys_reboot(int type);

#endif
