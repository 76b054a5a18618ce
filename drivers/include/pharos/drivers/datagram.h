/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Datagrams between this device and others of a network, and announcements to all of them. It
 * exists where the devicetree has an alias for it (imc-datagrams0); elsewhere the device is NULL.
 * Addresses are IPv4, in the processor's byte order.
 */
#ifndef PHAROS_DRIVERS_DATAGRAM_H_
#define PHAROS_DRIVERS_DATAGRAM_H_

#include <errno.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/device.h>

struct datagram_address {
	uint32_t ipv4;
	uint16_t port;
};

/* Who hears an announcement. */
enum datagram_scope {
	DATAGRAM_SCOPE_HOST,
	DATAGRAM_SCOPE_BROADCAST,
	DATAGRAM_SCOPE_MULTICAST,
};

typedef void (*datagram_callback_t)(const struct device *dev, void *user_data);

struct datagram_driver_api {
	int (*own)(const struct device *dev, struct datagram_address *own);
	int (*receive)(const struct device *dev, struct datagram_address *from, uint8_t *bytes,
	               size_t room);
	int (*send)(const struct device *dev, const struct datagram_address *to,
	            const uint8_t *bytes, size_t length);
	int (*announce)(const struct device *dev, enum datagram_scope scope, const uint8_t *bytes,
	                size_t length);
	void (*callback_set)(const struct device *dev, datagram_callback_t callback,
	                     void *user_data);
};

/* Where others reach this device. 0; -ENODEV: there is no network. Any thread. */
static inline int datagram_own(const struct device *dev, struct datagram_address *own)
{
	return ((const struct datagram_driver_api *)dev->api)->own(dev, own);
}

/*
 * The oldest datagram that has come, announcements of others too. Its length, or -EAGAIN: there is
 * none. What is longer than room is dropped. One thread.
 */
static inline int datagram_receive(const struct device *dev, struct datagram_address *from,
                                   uint8_t *bytes, size_t room)
{
	return ((const struct datagram_driver_api *)dev->api)->receive(dev, from, bytes, room);
}

/* 0, or -errno: not sent. Any thread. */
static inline int datagram_send(const struct device *dev, const struct datagram_address *to,
                                const uint8_t *bytes, size_t length)
{
	return ((const struct datagram_driver_api *)dev->api)->send(dev, to, bytes, length);
}

/* The same, to everyone within scope that listens for announcements. */
static inline int datagram_announce(const struct device *dev, enum datagram_scope scope,
                                    const uint8_t *bytes, size_t length)
{
	return ((const struct datagram_driver_api *)dev->api)->announce(dev, scope, bytes, length);
}

/* Called in interrupt context when datagrams have come. */
static inline void datagram_callback_set(const struct device *dev, datagram_callback_t callback,
                                         void *user_data)
{
	((const struct datagram_driver_api *)dev->api)->callback_set(dev, callback, user_data);
}

#endif
