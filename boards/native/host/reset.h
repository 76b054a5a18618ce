/* SPDX-License-Identifier: Apache-2.0 */
/* Why the board started. The values are those of Zephyr's hwinfo; a POSIX-free header for both
 * sides. */
#ifndef NATIVE_HOST_RESET_H_
#define NATIVE_HOST_RESET_H_

#include <stdint.h>

enum reset_cause {
	RESET_CAUSE_PIN = 1 << 0,
	RESET_CAUSE_SOFTWARE = 1 << 1,
	RESET_CAUSE_BROWNOUT = 1 << 2,
	RESET_CAUSE_POWER_ON = 1 << 3,
	RESET_CAUSE_WATCHDOG = 1 << 4,
	RESET_CAUSE_FAULT = 1 << 8, /* the processor gave up: an assertion, a fatal error */
};

/* Flags collected since they were last cleared. Power-on at first. */
uint32_t reset_causes(void);

void reset_causes_clear(void);

/* Why this boot came about, not affected by clearing: one flag. */
uint32_t reset_last_cause(void);

/* "watchdog"; "unknown" if it is none. */
const char *reset_cause_name(uint32_t cause);

/* The flag of that name; 0: there is none. */
uint32_t reset_cause_find(const char *name);

#endif
