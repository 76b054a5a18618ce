/* SPDX-License-Identifier: Apache-2.0 */
/* Datagrams over UDP of the host (compatible "pharos,imc-udp"). */
#define DT_DRV_COMPAT pharos_imc_udp

#include <errno.h>

#include <native/irq.h>
#include <zephyr/device.h>
#include <zephyr/toolchain.h>

#include <pharos/drivers/datagram.h>

#include "devices/fault.h"
#include "imc_udp.h"

BUILD_ASSERT((unsigned int)IMC_UDP_HOST == DATAGRAM_SCOPE_HOST &&
                     (unsigned int)IMC_UDP_BROADCAST == DATAGRAM_SCOPE_BROADCAST &&
                     (unsigned int)IMC_UDP_MULTICAST == DATAGRAM_SCOPE_MULTICAST,
             "passed on as it is");

struct imc_udp_data {
	struct native_irq irq;
	datagram_callback_t callback;
	void *user_data;
};

static void isr(void *arg)
{
	const struct device *const dev = arg;
	const struct imc_udp_data *const data = dev->data;

	if (data->callback != NULL) {
		data->callback(dev, data->user_data);
	}
}

static void on_rx(void *arg)
{
	const struct device *const dev = arg;
	struct imc_udp_data *const data = dev->data;

	native_irq_raise(&data->irq);
}

static int own(const struct device *dev, struct datagram_address *own)
{
	struct imc_udp_address address;

	if (!imc_udp_own(&address)) {
		return -ENODEV;
	}
	*own = (struct datagram_address){.ipv4 = address.ipv4, .port = address.port};
	return 0;
}

static int receive(const struct device *dev, struct datagram_address *from, uint8_t *bytes,
                   size_t room)
{
	struct imc_udp_address address;
	const int length = imc_udp_receive(&address, bytes, room);

	if (fault_of(BOARD_CHIP_IMC)->kind == BOARD_FAULT_NEVER) {
		return -EAGAIN;
	}
	if (length >= 0) {
		*from = (struct datagram_address){.ipv4 = address.ipv4, .port = address.port};
	}
	return length;
}

/* A silent network takes everything and delivers nothing. */
static int pass(void)
{
	return fault_of(BOARD_CHIP_IMC)->kind == BOARD_FAULT_NEVER ? -ENETDOWN
	                                                           : fault_pass(BOARD_CHIP_IMC);
}

static int send(const struct device *dev, const struct datagram_address *to, const uint8_t *bytes,
                size_t length)
{
	const struct imc_udp_address address = {.ipv4 = to->ipv4, .port = to->port};
	const int fault = pass();

	return fault != 0 ? fault : imc_udp_send(&address, bytes, length);
}

static int announce(const struct device *dev, enum datagram_scope scope, const uint8_t *bytes,
                    size_t length)
{
	const int fault = pass();

	return fault != 0 ? fault : imc_udp_announce((enum imc_udp_scope)scope, bytes, length);
}

static void callback_set(const struct device *dev, datagram_callback_t callback, void *user_data)
{
	struct imc_udp_data *const data = dev->data;

	data->callback = callback;
	data->user_data = user_data;
}

static const struct datagram_driver_api api = {
	.own = own,
	.receive = receive,
	.send = send,
	.announce = announce,
	.callback_set = callback_set,
};

static int init(const struct device *dev)
{
	struct imc_udp_data *const data = dev->data;

	if (fault_start(BOARD_CHIP_IMC) != 0) {
		return -EIO;
	}
	data->irq = (struct native_irq){.isr = isr, .arg = (void *)(uintptr_t)dev};
	imc_udp_open(on_rx, (void *)(uintptr_t)dev);
	return 0;
}

#define IMC_UDP_DEFINE(inst)                                                                       \
	static struct imc_udp_data imc_udp_data_##inst;                                            \
	DEVICE_DT_INST_DEFINE(inst, init, NULL, &imc_udp_data_##inst, NULL, PRE_KERNEL_1,          \
	                      CONFIG_KERNEL_INIT_PRIORITY_DEVICE, &api);

DT_INST_FOREACH_STATUS_OKAY(IMC_UDP_DEFINE)
