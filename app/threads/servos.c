/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/servos.h"

#include <zephyr/device.h>
#include <zephyr/logging/log.h>

#include <pharos/drivers/servo.h>

#include "threads/clock.h"
#include "threads/devices.h"

LOG_MODULE_REGISTER(servos);

static uint32_t errors;

bool servos_ready(void)
{
	const struct device *const servos[] = {devices.servo_pan, devices.servo_tilt};

	for (size_t i = 0; i < ARRAY_SIZE(servos); i++) {
		if (servos[i] == NULL) {
			return false;
		}
		if (!device_is_ready(servos[i])) {
			LOG_ERR("%s is not ready; no gimbal", servos[i]->name);
			return false;
		}
	}
	return true;
}

void servos_move(struct pharos_device *device)
{
	const uint32_t *const pulse_ns = device->gimbal.pulse_ns;
	const int pan = servo_set_pulse(devices.servo_pan, pulse_ns[GIMBAL_PAN]);
	const int tilt = servo_set_pulse(devices.servo_tilt, pulse_ns[GIMBAL_TILT]);
	const int error = pan != 0 ? pan : tilt;

	errors += error != 0 ? 1 : 0;
	if (!pharos_device_report_servos(device, clock_now_us(), error != 0)) {
		return;
	}
	if (error != 0) {
		LOG_ERR("cannot drive the servos: error %d", error);
	} else {
		LOG_INF("the servos can be driven again");
	}
}

uint32_t servos_errors(void)
{
	return errors;
}
