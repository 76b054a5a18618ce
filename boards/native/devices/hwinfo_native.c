/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <string.h>

#include <zephyr/drivers/hwinfo.h>

#include "host/device_id.h"
#include "host/reset.h"

_Static_assert(RESET_PIN == RESET_CAUSE_PIN && RESET_SOFTWARE == RESET_CAUSE_SOFTWARE &&
                       RESET_BROWNOUT == RESET_CAUSE_BROWNOUT &&
                       RESET_POR == RESET_CAUSE_POWER_ON &&
                       RESET_WATCHDOG == RESET_CAUSE_WATCHDOG &&
                       RESET_CPU_LOCKUP == RESET_CAUSE_FAULT,
               "host/reset.h has hwinfo's values");

ssize_t hwinfo_get_device_id(uint8_t *buffer, size_t length)
{
	const uint64_t id = device_id();
	const size_t n = length < sizeof(id) ? length : sizeof(id);

	memcpy(buffer, &id, n);
	return (ssize_t)n;
}

int hwinfo_get_reset_cause(uint32_t *cause)
{
	*cause = reset_causes();
	return 0;
}

int hwinfo_clear_reset_cause(void)
{
	reset_causes_clear();
	return 0;
}

int hwinfo_get_supported_reset_cause(uint32_t *supported)
{
	*supported = RESET_PIN | RESET_SOFTWARE | RESET_BROWNOUT | RESET_POR | RESET_WATCHDOG |
	             RESET_CPU_LOCKUP;
	return 0;
}
