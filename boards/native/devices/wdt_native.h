/* SPDX-License-Identifier: Apache-2.0 */
#ifndef NATIVE_DEVICES_WDT_NATIVE_H_
#define NATIVE_DEVICES_WDT_NATIVE_H_

#include <stdint.h>

/* Time since this boot when the watchdog bites unless it is fed; UINT64_MAX: it does not run. */
uint64_t wdt_native_bite_us(void);

#endif
