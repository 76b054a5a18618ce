/* SPDX-License-Identifier: Apache-2.0 */
/* --protocol as straps (compatible "pharos,uart-strap"). */
#define DT_DRV_COMPAT pharos_uart_strap

#include <zephyr/device.h>
#include <zephyr/toolchain.h>

#include <pharos/drivers/strap.h>

#include "uart_host_wire.h"

BUILD_ASSERT(UART_HOST_PROTOCOL_OPEN == STRAP_OPEN, "passed on as it is");

static int uart_strap_get(const struct device *dev, enum strap strap)
{
	static const char *const wires[] = {
		[STRAP_UART0_PROTOCOL] = "uart0",
		[STRAP_UART1_PROTOCOL] = "uart1",
		[STRAP_UART2_PROTOCOL] = "uart2",
		[STRAP_UART3_PROTOCOL] = "uart3",
	};

	return uart_host_wire_protocol(uart_host_wire_find(wires[strap]));
}

static int uart_strap_init(const struct device *dev)
{
	return 0;
}

static const struct strap_driver_api uart_strap_api = {
	.get = uart_strap_get,
};

#define UART_STRAP_DEFINE(inst)                                                                    \
	DEVICE_DT_INST_DEFINE(inst, uart_strap_init, NULL, NULL, NULL, PRE_KERNEL_1, 40,           \
	                      &uart_strap_api);

DT_INST_FOREACH_STATUS_OKAY(UART_STRAP_DEFINE)
