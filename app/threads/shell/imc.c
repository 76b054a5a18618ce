/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command for the IMC node: imc.
 */
#include <errno.h>

#include <zephyr/kernel.h>
#include <zephyr/shell/shell.h>

#include "proto/imc/endpoint.h"
#include "threads/clock.h"
#include "threads/imc_light.h"
#include "threads/imc_link.h"
#include "threads/links.h"
#include "threads/shell/call.h"
#include "threads/uart_link.h"

/* What the shell's thread prints, as it was in the command thread. */
struct status {
	uint16_t id;
	int64_t now_us;
	struct imc_endpoint_stats endpoint;
	struct imc_node_stats node;
	struct imc_peers peers;
};

static int copy_status(struct pharos_device *device, void *argument)
{
	const struct imc_endpoint *const endpoint = imc_light_endpoint();
	struct status *const status = argument;

	status->id = endpoint->id;
	status->now_us = clock_now_us();
	status->endpoint = endpoint->stats;
	status->node = endpoint->node.stats;
	status->peers = endpoint->node.peers;
	return 0;
}

static void print_peer(const struct shell *sh, const struct imc_peer *peer, int64_t now_us)
{
	const uint32_t address = peer->route.address;
	const unsigned int age_ms = (unsigned int)((now_us - peer->heard_us) / US_PER_MS);

	if (peer->route.link == IMC_LINK_DATAGRAMS) {
		shell_print(sh, "0x%04x        %u.%u.%u.%u:%u, %u ms ago", peer->id, address >> 24,
		            address >> 16 & UINT8_MAX, address >> 8 & UINT8_MAX,
		            address & UINT8_MAX, peer->route.port, age_ms);
	} else {
		shell_print(sh, "0x%04x        %s, %u ms ago", peer->id,
		            links_name(peer->route.link), age_ms);
	}
}

static int cmd_imc(const struct shell *sh, size_t argc, char **argv)
{
	const struct imc_link_stats link = imc_link_stats_get();
	struct status now;

	if (!shell_call(sh, copy_status, &now, NULL)) {
		return -EAGAIN;
	}
	shell_print(sh, "%-14s0x%04x", "id", now.id);
	for (uint8_t number = 0; number < UART_LINKS_MAX; number++) {
		if (uart_link_protocol(number) == UART_PROTOCOL_IMC) {
			shell_print(sh, "%-14sspeaks IMC", links_name(number));
		}
	}
	shell_print(sh, "%-14srx %u, malformed %u; tx %u, failed %u", "datagrams",
	            link.rx_datagrams, link.rx_malformed, link.tx_datagrams, link.tx_failed);
	shell_print(sh, "%-14srx %u, tx %u, no room %u", "packets", now.endpoint.packets,
	            now.endpoint.sent, now.endpoint.unsent);
	shell_print(sh, "%-14sunknown %u, malformed %u, for others %u, own %u", "ignored",
	            now.endpoint.unknown_ids, now.endpoint.malformed, now.endpoint.not_for_us,
	            now.endpoint.own);
	shell_print(sh, "%-14s%u answered; unknown names %u, parameters refused %u", "requests",
	            now.node.requests, now.node.unknown_names, now.node.params_refused);
	shell_print(sh, "%-14s%u, of %u; refused %u", "peers", now.peers.count, IMC_PEERS_MAX,
	            now.peers.refused);
	for (uint8_t i = 0; i < now.peers.count; i++) {
		print_peer(sh, &now.peers.peers[i], now.now_us);
	}
	return 0;
}

SHELL_CMD_ARG_REGISTER(imc, NULL, "The IMC node and its peers", cmd_imc, 1, 0);
