/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the shell's commands say alike.
 */
#ifndef PHAROS_THREADS_SHELL_SAY_H
#define PHAROS_THREADS_SHELL_SAY_H

#include <stdint.h>

#include <zephyr/shell/shell.h>

#include "core/device.h"

#define PPM_PER_PERCENT_DECIMALS 4 /* 1 % = 10 000 ppm */
#define US_DECIMALS              6
#define MDEG_DECIMALS            3

/* Who the shell is to the device. */
extern const struct device_who shell_who;

/* "label  12.5 unit", without trailing zeros. */
void say_fixed(const struct shell *sh, const char *label, int64_t value, unsigned int decimals,
               const char *unit);

/* Says "ok", or that the device refused; status: the command that tells who is in command. result
 * ACCEPTED, EXCLUDED, OUTRANKED. Returns the command's 0 or -errno.
 */
int say_result(const struct shell *sh, enum device_result result, const char *status);

#endif
