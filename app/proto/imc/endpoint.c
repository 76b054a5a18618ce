/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/endpoint.h"

#include "proto/imc/seconds.h"

#include <string.h>

/* 2001-09-09: earlier timestamps come from devices without a calendar, like this one. */
#define UNIX_PLAUSIBLE_US (1000000000 * (int64_t)US_PER_S)

void imc_endpoint_init(struct imc_endpoint *self, int64_t now_us,
                       const struct imc_endpoint_config *config, struct pharos_device *device)
{
	memset(self, 0, sizeof(*self));
	self->id = config->id;
	imc_node_init(&self->node, now_us, &config->node, device);
	imc_actuation_init(&self->actuation, device);
}

/* --- who is there ----------------------------------------------------------------------------- */

/* Takes a number of at most max off the text. */
static bool take_number(struct imc_text *text, uint32_t max, uint32_t *number)
{
	uint16_t digits = 0;

	*number = 0;
	while (text->length > 0 && text->bytes[0] >= '0' && text->bytes[0] <= '9' && digits < 5) {
		*number = 10 * *number + (uint32_t)(text->bytes[0] - '0');
		text->bytes++;
		text->length--;
		digits++;
	}
	return digits > 0 && *number <= max;
}

static bool take_string(struct imc_text *text, const char *string)
{
	const size_t length = strlen(string);

	if (text->length < length || memcmp(text->bytes, string, length) != 0) {
		return false;
	}
	text->bytes += length;
	text->length = (uint16_t)(text->length - length);
	return true;
}

/* "imc+udp://127.0.0.1:6002/" at the beginning of the text. */
static bool take_udp_service(struct imc_text *text, struct imc_route *route)
{
	uint32_t number;

	if (!take_string(text, "imc+udp://")) {
		return false;
	}
	route->address = 0;
	for (int i = 0; i < 4; i++) {
		if ((i > 0 && !take_string(text, ".")) || !take_number(text, UINT8_MAX, &number)) {
			return false;
		}
		route->address = route->address << 8 | number;
	}
	if (!take_string(text, ":") || !take_number(text, UINT16_MAX, &number) || number == 0) {
		return false;
	}
	route->port = (uint16_t)number;
	return true;
}

/*
 * Where the announcer wants its datagrams: of the addresses that it lists, the one that the
 * announcement came from; else that address with the first port.
 */
static bool announced_route(const struct imc_text *services, const struct imc_route *from,
                            struct imc_route *route)
{
	struct imc_text rest = *services;
	bool found = false;

	while (rest.length > 0) {
		struct imc_route service = {.link = from->link};

		if (take_udp_service(&rest, &service)) {
			if (!found || service.address == from->address) {
				*route = service;
			}
			if (service.address == from->address) {
				return true;
			}
			found = true;
		}
		while (rest.length > 0 && !take_string(&rest, ";")) {
			rest.bytes++;
			rest.length--;
		}
	}
	if (found) {
		route->address = from->address;
	}
	return found;
}

static void note_peer(struct imc_endpoint *self, int64_t now_us, const struct imc_route *from)
{
	const struct imc_packet *const packet = &self->packet;
	struct imc_route route = *from;
	const bool announced = packet->message.id == IMC_ANNOUNCE && from->port != 0 &&
	                       announced_route(&packet->message.announce.services, from, &route);

	imc_peers_heard(&self->node.peers, now_us, packet->header.src, &route, announced);
}

static void note_time(struct imc_endpoint *self, int64_t now_us)
{
	int64_t unix_us;

	if (imc_seconds_to_us(self->packet.header.timestamp_s, &unix_us) &&
	    unix_us >= UNIX_PLAUSIBLE_US) {
		self->unix_offset_us = unix_us - now_us;
	}
}

/* Somebody who may command is there. Other sensors, such as a second light, never do. */
static void note_commander(struct imc_endpoint *self, int64_t now_us)
{
	static const struct device_who who = {.way = SECURITY_WAY_IMC};
	const uint16_t src = self->packet.header.src;

	if (self->packet.message.id == IMC_HEARTBEAT &&
	    (src < IMC_ID_SENSORS_FIRST || src > IMC_ID_SENSORS_LAST)) {
		pharos_device_heard(self->node.device, now_us, &who);
	}
}

/* --- packets ---------------------------------------------------------------------------------- */

static void begin(struct imc_endpoint *self, int64_t now_us, const struct imc_route *origin,
                  struct imc_outbox *out)
{
	imc_outbox_begin(out, self->id, imc_seconds_from_us(now_us + self->unix_offset_us), origin);
}

static void finish(struct imc_endpoint *self, const struct imc_outbox *out)
{
	self->stats.sent += out->packets_count;
	self->stats.unsent += out->unsent;
}

/* A good packet of one of our messages from somebody else; false: counted, and done with. */
static bool accept(struct imc_endpoint *self, const uint8_t *bytes)
{
	const enum imc_result result = imc_parse(bytes, &self->packet);

	self->stats.packets++;
	if (result == IMC_UNKNOWN_ID) {
		self->stats.unknown_ids++;
	} else if (result != IMC_OK) {
		self->stats.malformed++;
	}
	if (self->packet.header.src == self->id) {
		self->stats.own++;
		return false;
	}
	return result == IMC_OK;
}

static bool is_for_us(const struct imc_endpoint *self)
{
	const struct imc_header *const header = &self->packet.header;

	return (header->dst == self->id || header->dst == IMC_DST_ALL) &&
	       (header->dst_ent < IMC_ENTITY_COUNT || header->dst_ent == IMC_ENTITY_ALL);
}

void imc_endpoint_receive(struct imc_endpoint *self, int64_t now_us, const struct imc_route *route,
                          const uint8_t *bytes, struct imc_outbox *out)
{
	begin(self, now_us, route, out);
	if (!accept(self, bytes)) {
		return;
	}
	note_peer(self, now_us, route);
	out->origin = *imc_peers_answer_route(&self->node.peers, self->packet.header.src, route);
	if (self->packet.message.id == IMC_ANNOUNCE || self->packet.message.id == IMC_HEARTBEAT) {
		note_time(self, now_us);
		note_commander(self, now_us);
		return;
	}
	if (!is_for_us(self)) {
		self->stats.not_for_us++;
		return;
	}
	imc_node_receive(&self->node, now_us, &self->packet, out);
	imc_actuation_receive(&self->actuation, now_us, &self->packet, out);
	finish(self, out);
}

void imc_endpoint_step(struct imc_endpoint *self, int64_t now_us, struct imc_outbox *out)
{
	begin(self, now_us, NULL, out);
	imc_node_step(&self->node, now_us, out);
	if (imc_actuation_deadline_us(&self->actuation) <= now_us) {
		imc_actuation_step(&self->actuation, now_us);
	}
	finish(self, out);
}

void imc_endpoint_button(struct imc_endpoint *self, int64_t now_us, uint8_t button, bool pressed,
                         struct imc_outbox *out)
{
	begin(self, now_us, NULL, out);
	imc_actuation_button(button, pressed, out);
	finish(self, out);
}

int64_t imc_endpoint_deadline_us(const struct imc_endpoint *self)
{
	const int64_t node_us = imc_node_deadline_us(&self->node);
	const int64_t actuation_us = imc_actuation_deadline_us(&self->actuation);

	return (actuation_us < node_us) ? actuation_us : node_us;
}

void imc_endpoint_tell(struct imc_endpoint *self, int64_t now_us,
                       const struct device_effects *effects, struct imc_outbox *out)
{
	if ((effects->statuses | effects->reports) != 0) {
		imc_entities_report(&self->node.entities, &self->node.device->lamps[0].illuminator);
	}
	if (!effects->has_shutdown) {
		return;
	}
	if (out->packets_count == 0) {
		begin(self, now_us, NULL, out);
	}

	self->stats.sent -= out->packets_count; /* are counted once more */
	self->stats.unsent -= out->unsent;
	imc_actuation_tell(&effects->shutdown, out);
	finish(self, out);
}
