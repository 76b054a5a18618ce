/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/imc_node.h"

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/printk.h>

#include <pharos/drivers/datagram.h>

#include "proto/imc/endpoint.h"
#include "threads/actuation.h"
#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/imc_link.h"
#include "threads/uart_link.h"
#include "version.h"

LOG_MODULE_REGISTER(imc_node);

#define LOG_GAP_US (1 * US_PER_S)

#define SERVICES "imc+info://0.0.0.0/version/5.4.31;imc+udp://%u.%u.%u.%u:%u/"

static struct imc_endpoint endpoint;
static struct imc_outbox out;
static bool active;
static int64_t log_us; /* the next refusal may be logged */

/* How others reach us; NULL: no datagrams, nothing to announce. */
static const char *services(void)
{
	static char text[sizeof(SERVICES) + 5 * sizeof("65535")];
	struct datagram_address own;

	if (!imc_link_has_datagrams() || datagram_own(devices.imc_datagrams, &own) != 0) {
		return NULL;
	}
	snprintk(text, sizeof(text), SERVICES, (unsigned int)(own.ipv4 >> 24),
	         (unsigned int)(own.ipv4 >> 16 & UINT8_MAX),
	         (unsigned int)(own.ipv4 >> 8 & UINT8_MAX), (unsigned int)(own.ipv4 & UINT8_MAX),
	         own.port);
	return text;
}

void imc_node_start(struct command *command)
{
	struct imc_endpoint_config config = {
		.id = (uint16_t)command->params.values[PARAM_IMC_ID],
		.node =
			{
				.name = CONFIG_PHAROS_IMC_NAME,
				.version = PHAROS_VERSION,
				.services = services(),
			},
	};

	for (uint8_t link = 0; link < UART_LINKS_MAX; link++) {
		if (uart_link_protocol(link) == UART_PROTOCOL_IMC) {
			config.node.stream_links |= (uint8_t)BIT(link);
		}
	}
	active = config.node.services != NULL || config.node.stream_links != 0;
	imc_endpoint_init(&endpoint, clock_now_us(), &config, &command->params);
	imc_endpoint_attach(&endpoint, actuation_start(command));
}

/* --- performing ------------------------------------------------------------------------------- */

static void perform_action(struct command *command, const struct imc_action *action)
{
	switch (action->kind) {
	case IMC_ACTION_ACTUATE:
		actuation_perform(command);
		break;
	case IMC_ACTION_PARAMS_CHANGED:
		command_params_changed(command, &action->changed);
		break;
	case IMC_ACTION_HEARD:
		arbiter_heard(&command->arbiter, clock_now_us(), ARBITER_SOURCE_IMC);
		break;
	}
}

/* Peers that share a route, as those behind a TCP server do, share a packet. */
static void send_to_peers(const uint8_t *bytes, size_t length)
{
	const struct imc_peers *const peers = &endpoint.node.peers;

	for (uint8_t i = 0; i < peers->count; i++) {
		if (imc_peers_is_first(peers, i)) {
			imc_link_send(&peers->peers[i].route, bytes, length);
		}
	}
}

static void send(struct command *command, const struct imc_outbox_packet *packet)
{
	const uint8_t *const bytes = &out.bytes[packet->offset];

	switch (packet->to) {
	case IMC_TO_ROUTE:
		imc_link_send(&packet->route, bytes, packet->length);
		break;
	case IMC_TO_PEERS:
		send_to_peers(bytes, packet->length);
		break;
	case IMC_TO_ANNOUNCE:
		imc_link_announce(command->params.values[PARAM_IMC_ANNOUNCE], bytes,
		                  packet->length);
		break;
	}
}

static void perform(struct command *command)
{
	for (uint8_t i = 0; i < out.actions_count; i++) {
		perform_action(command, &out.actions[i]);
	}
	for (uint8_t i = 0; i < out.packets_count; i++) {
		send(command, &out.packets[i]);
	}
}

/* --- what the command thread calls ------------------------------------------------------------ */

/* The node's; those of the actuation service are logged there. */
static uint32_t refusals(void)
{
	return endpoint.stats.malformed + endpoint.node.stats.unknown_names +
	       endpoint.node.stats.params_refused;
}

static void log_refusal(void)
{
	const struct imc_packet *const packet = &endpoint.packet;

	if (clock_now_us() >= log_us) {
		log_us = clock_now_us() + LOG_GAP_US;
		LOG_WRN("%s of 0x%04x: unknown name, wrong value or malformed",
		        imc_type_find(packet->message.id)->name, packet->header.src);
	}
}

void imc_node_take(struct command *command, struct imc_frame *frame)
{
	const uint32_t before = refusals();

	actuation_sample();
	imc_endpoint_receive(&endpoint, clock_now_us(), &frame->route, frame->bytes, &out);
	if (refusals() != before) {
		log_refusal();
	}
	perform(command);
	imc_link_frame_free(frame);
}

void imc_node_button(struct command *command, uint8_t button, bool pressed)
{
	if (active) {
		imc_endpoint_button(&endpoint, clock_now_us(), button, pressed, &out);
		perform(command);
	}
}

void imc_node_poll(struct command *command)
{
	if (imc_node_due_us() <= clock_now_us()) {
		imc_endpoint_step(&endpoint, clock_now_us(), &out);
		perform(command);
	}
}

int64_t imc_node_due_us(void)
{
	return active ? imc_endpoint_deadline_us(&endpoint) : TIME_NEVER_US;
}

void imc_node_report(const struct illuminator *illuminator)
{
	if (active) {
		imc_endpoint_report(&endpoint, illuminator);
	}
}

const struct imc_endpoint *imc_node_endpoint(void)
{
	return &endpoint;
}
