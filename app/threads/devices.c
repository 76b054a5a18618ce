/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/devices.h"

#include <zephyr/devicetree.h>
#include <zephyr/sys/util.h>

#include "threads/startup.h"

#ifdef CONFIG_PHAROS_FIRMWARE_UPDATE
#include <zephyr/storage/flash_map.h>
#endif

#ifdef CONFIG_CAN
#define CAN_LINK DEVICE_DT_GET_OR_NULL(DT_ALIAS(can_link0))
#else
#define CAN_LINK NULL
#endif

#ifdef CONFIG_PHAROS_IMC
#define IMC_DATAGRAMS DEVICE_DT_GET_OR_NULL(DT_ALIAS(imc_datagrams0))
#else
#define IMC_DATAGRAMS NULL
#endif

#define UART_LINK(i_, _) DEVICE_DT_GET_OR_NULL(DT_ALIAS(uart_link##i_))
#define UART_BAUD(i_, _) DT_PROP_OR(DT_ALIAS(uart_link##i_), current_speed, 0)

_Static_assert(UART_LINKS_MAX > 3 || !DT_NODE_EXISTS(DT_ALIAS(uart_link3)), "every UART is used");
_Static_assert(UART_LINKS_MAX > 2 || !DT_NODE_EXISTS(DT_ALIAS(uart_link2)), "every UART is used");
_Static_assert(UART_LINKS_MAX > 1 || !DT_NODE_EXISTS(DT_ALIAS(uart_link1)), "every UART is used");

const struct devices devices = {
	.light = DEVICE_DT_GET(DT_ALIAS(light0)),
	.thermistor = DEVICE_DT_GET(DT_ALIAS(thermistor0)),
	.watchdog = DEVICE_DT_GET(DT_ALIAS(watchdog0)),
#ifdef CONFIG_PHAROS_GIMBAL
	.servo_pan = DEVICE_DT_GET_OR_NULL(DT_ALIAS(servo_pan)),
	.servo_tilt = DEVICE_DT_GET_OR_NULL(DT_ALIAS(servo_tilt)),
#endif
	.probe = DEVICE_DT_GET_OR_NULL(DT_ALIAS(probe0)),
	.can_link = CAN_LINK,
	.edge_time = DEVICE_DT_GET_OR_NULL(DT_ALIAS(edge_time0)),
	.imc_datagrams = IMC_DATAGRAMS,
	.strap = DEVICE_DT_GET_OR_NULL(DT_ALIAS(strap0)),
	.uart_links = {LISTIFY(UART_LINKS_MAX, UART_LINK, (, ))},
	.uart_bauds = {LISTIFY(UART_LINKS_MAX, UART_BAUD, (, ))},
	.sync_input = GPIO_DT_SPEC_GET_OR(DT_ALIAS(sync_input), gpios, {0}),
	.button = GPIO_DT_SPEC_GET_OR(DT_ALIAS(button0), gpios, {0}),
	.driver_fault = GPIO_DT_SPEC_GET_OR(DT_ALIAS(driver_fault), gpios, {0}),
};

#ifdef CONFIG_PHAROS_IMC
#define GPIO_OR_NONE(alias_) GPIO_DT_SPEC_GET_OR(DT_ALIAS(alias_), gpios, {0})
#define PWM_OR_NONE(alias_)                                                                        \
	COND_CODE_1(DT_NODE_EXISTS(DT_ALIAS(alias_)), (PWM_DT_SPEC_GET(DT_ALIAS(alias_))), ({0}))

#ifdef CONFIG_AUXDISPLAY
#define DISPLAY DEVICE_DT_GET_OR_NULL(DT_ALIAS(display0))
#else
#define DISPLAY NULL
#endif

const struct actuator_devices actuator_devices = {
	.power = {GPIO_OR_NONE(power_lamp), GPIO_OR_NONE(power_gimbal), GPIO_OR_NONE(power_camera),
                  GPIO_OR_NONE(power_aux)},
	.gpio_outputs = {GPIO_OR_NONE(gpio_out0), GPIO_OR_NONE(gpio_out1)},
	.gpio_inputs = {GPIO_OR_NONE(gpio_in0), GPIO_OR_NONE(gpio_in1)},
	.pwms = {PWM_OR_NONE(aux_pwm0), PWM_OR_NONE(aux_pwm1)},
	.leds = {PWM_OR_NONE(led_status), PWM_OR_NONE(led_signal)},
	.thruster = PWM_OR_NONE(thruster0),
	.focus_in = GPIO_OR_NONE(focus_in),
	.focus_out = GPIO_OR_NONE(focus_out),
	.display = DISPLAY,
};
#endif

#ifdef CONFIG_PHAROS_FIRMWARE_UPDATE
uint8_t devices_update_slot(void)
{
	return FIXED_PARTITION_ID(slot1_partition);
}

uint32_t devices_update_slot_size(void)
{
	return FIXED_PARTITION_SIZE(slot1_partition);
}
#endif

static void start_servos(void)
{
	if (startup_device(STARTUP_SERVOS, devices.servo_pan) == 0) {
		(void)startup_device(STARTUP_SERVOS, devices.servo_tilt);
	}
}

void devices_start(void)
{
	(void)startup_device(STARTUP_LIGHT, devices.light);
	(void)startup_device(STARTUP_SENSOR, devices.thermistor);
	(void)startup_device(STARTUP_SYNC, devices.sync_input.port);
	(void)startup_device(STARTUP_EDGE_TIME, devices.edge_time);
	(void)startup_device(STARTUP_STRAP, devices.strap);
	for (int i = 0; i <= STARTUP_UART_LINK3 - STARTUP_UART_LINK0; i++) {
		(void)startup_device(STARTUP_UART_LINK0 + i,
		                     i < UART_LINKS_MAX ? devices.uart_links[i] : NULL);
	}
	(void)startup_device(STARTUP_CAN_LINK, devices.can_link);
	(void)startup_device(STARTUP_IMC_LINK, devices.imc_datagrams);
	start_servos();
	(void)startup_device(STARTUP_DRIVER_FAULT, devices.driver_fault.port);
	(void)startup_device(STARTUP_BUTTON, devices.button.port);
}
