/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a board fixes outside of its parameters, with a jumper or, on the native board, on its
 * command line. It exists where the devicetree has an alias strap0; elsewhere the device is NULL
 * and every strap is open.
 */
#ifndef PHAROS_DRIVERS_STRAP_H_
#define PHAROS_DRIVERS_STRAP_H_

#include <zephyr/device.h>

enum strap {
	STRAP_UART0_PROTOCOL, /* as the parameter UART0_PROTO, and so on */
	STRAP_UART1_PROTOCOL,
	STRAP_UART2_PROTOCOL,
	STRAP_UART3_PROTOCOL,
};

#define STRAP_OPEN (-1)

struct strap_driver_api {
	int (*get)(const struct device *dev, enum strap strap);
};

/* Its value, or STRAP_OPEN. Any context. dev may be NULL. */
static inline int strap_get(const struct device *dev, enum strap strap)
{
	return dev != NULL ? ((const struct strap_driver_api *)dev->api)->get(dev, strap)
	                   : STRAP_OPEN;
}

#endif
