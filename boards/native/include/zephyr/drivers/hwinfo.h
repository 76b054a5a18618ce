/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Hardware information, by Zephyr's names: why the board was reset.
 *
 * Causes collect until they are cleared, so that one that is read late is not lost.
 */
#ifndef ZEPHYR_DRIVERS_HWINFO_H_
#define ZEPHYR_DRIVERS_HWINFO_H_

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include <zephyr/sys/util.h>

#define RESET_PIN            BIT(0)
#define RESET_SOFTWARE       BIT(1)
#define RESET_BROWNOUT       BIT(2)
#define RESET_POR            BIT(3)
#define RESET_WATCHDOG       BIT(4)
#define RESET_DEBUG          BIT(5)
#define RESET_SECURITY       BIT(6)
#define RESET_LOW_POWER_WAKE BIT(7)
#define RESET_CPU_LOCKUP     BIT(8)

/* Up to `length` bytes that tell this board from others; how many. Native: derived from --seed. */
ssize_t hwinfo_get_device_id(uint8_t *buffer, size_t length);

/* 0; *cause: RESET_… flags. Any context. */
int hwinfo_get_reset_cause(uint32_t *cause);

int hwinfo_clear_reset_cause(void);

int hwinfo_get_supported_reset_cause(uint32_t *supported);

#endif
