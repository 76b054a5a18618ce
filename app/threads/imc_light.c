/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/imc_light.h"

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/printk.h>

#include <pharos/drivers/datagram.h>

#include "proto/imc/endpoint.h"
#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/frames.h"
#include "threads/imc_link.h"
#include "threads/outputs.h"
#include "threads/uart_link.h"
#include "version.h"

LOG_MODULE_REGISTER(imc_node);

#define LOG_GAP_US (1 * US_PER_S)

#define SERVICES "imc+info://0.0.0.0/version/5.4.31;imc+udp://%u.%u.%u.%u:%u/"

static struct pharos_device *device;
static struct imc_endpoint endpoint;
static struct imc_outbox out;
static bool active;
static int64_t log_us; /* the next refusal of the node may be logged */
static int64_t actuation_log_us;

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

void imc_light_init(struct pharos_device *its)
{
	struct imc_endpoint_config config = {
		.id = (uint16_t)its->params.values[PARAM_IMC_ID],
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
	device = its;
	out.packets_count = 0;
	log_us = 0;
	actuation_log_us = 0;
	imc_endpoint_init(&endpoint, clock_now_us(), &config, device);
	imc_light_tell(&(struct device_effects){.reports = 1});
}

/* --- sending ---------------------------------------------------------------------------------- */

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

static void send(const struct imc_outbox_packet *packet)
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
		imc_link_announce(device->params.values[PARAM_IMC_ANNOUNCE], bytes, packet->length);
		break;
	}
}

void imc_light_flush(void)
{
	for (uint8_t i = 0; i < out.packets_count; i++) {
		send(&out.packets[i]);
	}
	out.packets_count = 0;
}

/* --- refusals --------------------------------------------------------------------------------- */

/* The node's, and those of the actuation service. */
static uint32_t refusals(void)
{
	return endpoint.stats.malformed + endpoint.node.stats.unknown_names +
	       endpoint.node.stats.params_refused;
}

static uint32_t actuation_refusals(void)
{
	const uint32_t *const outcomes = endpoint.actuation.stats.outcomes;

	return outcomes[IMC_ACTUATION_UNKNOWN] + outcomes[IMC_ACTUATION_OUT_OF_RANGE] +
	       outcomes[IMC_ACTUATION_REFUSED];
}

/* One line a second at most, of either: peers repeat themselves. */
static void log_refusal(void)
{
	const struct imc_packet *const packet = &endpoint.packet;

	if (clock_now_us() >= log_us) {
		log_us = clock_now_us() + LOG_GAP_US;
		LOG_WRN("%s of 0x%04x: unknown name, wrong value or malformed",
		        imc_type_find(packet->message.id)->name, packet->header.src);
	}
}

static const char *outcome_text(enum imc_actuation_outcome outcome)
{
	switch (outcome) {
	case IMC_ACTUATION_DONE:
		break;
	case IMC_ACTUATION_UNKNOWN:
		return "not on this board";
	case IMC_ACTUATION_OUT_OF_RANGE:
		return "out of range";
	case IMC_ACTUATION_REFUSED:
		return "refused";
	}
	return "done";
}

static void log_actuation_refusal(void)
{
	const struct imc_actuation_refusal *const refusal = &endpoint.actuation.refusal;

	if (clock_now_us() < actuation_log_us) {
		return;
	}
	actuation_log_us = clock_now_us() + LOG_GAP_US;
	if (refusal->name[0] != '\0') {
		LOG_WRN("%s '%s': %s", imc_type_find(refusal->id)->name, refusal->name,
		        outcome_text(refusal->outcome));
	} else {
		LOG_WRN("%s %u: %s", imc_type_find(refusal->id)->name, refusal->number,
		        outcome_text(refusal->outcome));
	}
}

/* --- what the command thread calls ------------------------------------------------------------ */

void imc_light_take(const struct imc_frame *frame)
{
	const uint32_t before = refusals();
	const uint32_t actuation_before = actuation_refusals();

	endpoint.actuation.gpio_inputs = outputs_read_inputs(&device->actuators);
	imc_endpoint_receive(&endpoint, clock_now_us(), &frame->route, frame->bytes, &out);
	if (refusals() != before) {
		log_refusal();
	}
	if (actuation_refusals() != actuation_before) {
		log_actuation_refusal();
	}
}

void imc_light_button(uint8_t button, bool pressed)
{
	if (active) {
		imc_endpoint_button(&endpoint, clock_now_us(), button, pressed, &out);
	}
}

void imc_light_tell(const struct device_effects *effects)
{
	if (active) {
		imc_endpoint_tell(&endpoint, clock_now_us(), effects, &out);
	}
}

void imc_light_step(void)
{
	if (imc_light_deadline_us() <= clock_now_us()) {
		imc_endpoint_step(&endpoint, clock_now_us(), &out);
	}
}

int64_t imc_light_deadline_us(void)
{
	return active ? imc_endpoint_deadline_us(&endpoint) : TIME_NEVER_US;
}

const struct imc_endpoint *imc_light_endpoint(void)
{
	return &endpoint;
}
