/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/links.h"

#include <errno.h>

#include <zephyr/sys/util.h>

#include "threads/tunnel_link.h"
#include "threads/uart_link.h"

int links_send(uint8_t link, const uint8_t *frame, size_t length)
{
	if (link < TUNNEL_LINK0) {
		return uart_link_send(link, frame, length);
	}
	return link < LINKS_MAX ? tunnel_link_send(link - TUNNEL_LINK0, frame, length) : -ENODEV;
}

#ifdef CONFIG_PHAROS_ROUTING
int links_forward(uint8_t link, const uint8_t *frame, size_t length)
{
	if (link < TUNNEL_LINK0) {
		return uart_link_forward(link, frame, length);
	}
	return link < LINKS_MAX ? tunnel_link_forward(link - TUNNEL_LINK0, frame, length) : -ENODEV;
}
#endif

uint32_t links_mask(void)
{
	uint32_t mask = 0;

	for (uint8_t link = 0; link < UART_LINKS_MAX; link++) {
		mask |= uart_link_protocol(link) == UART_PROTOCOL_MAVLINK ? BIT(link) : 0;
	}
	return mask;
}

uint32_t links_rate(uint8_t link)
{
	return link < TUNNEL_LINK0 ? uart_link_rate(link) : TUNNEL_RATE;
}

int links_stats_get(uint8_t link, struct link_stats *stats)
{
	if (link < TUNNEL_LINK0) {
		return uart_link_stats_get(link, stats);
	}
	return link < LINKS_MAX ? tunnel_link_stats_get(link - TUNNEL_LINK0, stats) : -ENODEV;
}

const char *links_name(uint8_t link)
{
	static const char *const uarts[] = {"uart0", "uart1", "uart2", "uart3"};
	static const char *const tunnels[] = {"tunnel0", "tunnel1", "tunnel2", "tunnel3"};

	_Static_assert(UART_LINKS_MAX <= ARRAY_SIZE(uarts), "every UART has a name");
	_Static_assert(TUNNEL_LINKS_MAX <= ARRAY_SIZE(tunnels), "every tunnel has a name");
	return link < TUNNEL_LINK0 ? uarts[link] : tunnels[link - TUNNEL_LINK0];
}
