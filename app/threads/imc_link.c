/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/imc_link.h"

#include <zephyr/kernel.h>

#include <pharos/drivers/datagram.h>

#include "threads/devices.h"
#include "threads/inbox.h"
#include "threads/startup.h"
#include "threads/uart_link.h"

static K_SEM_DEFINE(rx_ready, 0, 1);

static struct imc_link_stats stats;

static void count_sent(int error)
{
	if (error == 0) {
		stats.tx_datagrams++;
	} else {
		stats.tx_failed++;
	}
}

bool imc_link_has_datagrams(void)
{
	return startup_result(STARTUP_IMC_LINK) == 0;
}

void imc_link_send(const struct imc_route *route, const uint8_t *bytes, size_t length)
{
	const struct datagram_address to = {.ipv4 = route->address, .port = route->port};

	if (route->link < UART_LINKS_MAX) {
		(void)uart_link_send(route->link, bytes, length);
	} else if (imc_link_has_datagrams()) {
		count_sent(datagram_send(devices.imc_datagrams, &to, bytes, length));
	}
}

void imc_link_announce(int32_t scope, const uint8_t *bytes, size_t length)
{
	if (imc_link_has_datagrams()) {
		count_sent(datagram_announce(devices.imc_datagrams, (enum datagram_scope)scope,
		                             bytes, length));
	}
}

struct imc_link_stats imc_link_stats_get(void)
{
	const unsigned int key = irq_lock();
	const struct imc_link_stats copy = stats;

	irq_unlock(key);
	return copy;
}

/* --- thread ----------------------------------------------------------------------------------- */

static void on_datagrams(const struct device *dev, void *user_data)
{
	k_sem_give(&rx_ready);
}

/* Until there are no more. A datagram is one packet. */
static void drain(void)
{
	static uint8_t bytes[IMC_PACKET_MAX];
	struct datagram_address from;
	int size;

	while ((size = datagram_receive(devices.imc_datagrams, &from, bytes, sizeof(bytes))) >= 0) {
		const struct imc_route route = {
			.link = IMC_LINK_DATAGRAMS,
			.port = from.port,
			.address = from.ipv4,
		};
		size_t length;

		supervisor_report(SUPERVISOR_IMC_LINK);
		stats.rx_datagrams++;
		if (imc_verify(bytes, (size_t)size, &length) == IMC_OK) {
			inbox_post_imc(&route, bytes, length, SUPERVISOR_IMC_LINK);
		} else {
			stats.rx_malformed++;
		}
	}
}

void imc_link_run(void *p1, void *p2, void *p3)
{
	datagram_callback_set(devices.imc_datagrams, on_datagrams, NULL);
	for (;;) {
		drain();
		supervisor_report(SUPERVISOR_IMC_LINK);
		(void)k_sem_take(&rx_ready, K_MSEC(SUPERVISOR_REPORT_MS));
	}
}
