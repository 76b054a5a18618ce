/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include <zephyr/device.h>
#include <zephyr/sys/iterable_sections.h>

void device_init_result(const struct device *dev, int rc)
{
	const int error = rc < 0 ? -rc : rc;

	dev->state->init_res = (uint8_t)(error > UINT8_MAX ? UINT8_MAX : error);
	dev->state->initialized = true;
}

bool device_is_ready(const struct device *dev)
{
	return dev != NULL && dev->state->initialized && dev->state->init_res == 0;
}

const struct device *device_get_binding(const char *name)
{
	STRUCT_SECTION_FOREACH(device, dev) {
		if (device_is_ready(dev) && strcmp(dev->name, name) == 0) {
			return dev;
		}
	}
	return NULL;
}
