/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/node.h"

#include <string.h>

#define SYSTEM_TYPE_MOBILE_SENSOR 7u
#define OWNER_NONE                0xFFFFu

void imc_node_init(struct imc_node *self, int64_t now_us, const struct imc_node_config *config,
                   struct pharos_device *device)
{
	memset(self, 0, sizeof(*self));
	self->config = *config;
	self->device = device;
	imc_entities_init(&self->entities);
	self->heartbeat_us = now_us;
	self->announce_us = config->services != NULL ? now_us : TIME_NEVER_US;
}

/* --- answers ---------------------------------------------------------------------------------- */

static struct imc_message state_of(const struct imc_node *self, enum imc_entity entity)
{
	const struct imc_entity_condition *const condition = &self->entities.conditions[entity];

	return (struct imc_message){
		.id = IMC_ENTITY_STATE,
		.entity_state =
			{
				.state = (uint8_t)condition->state,
				.description = imc_text_of(condition->description),
			},
	};
}

static struct imc_message info_of(enum imc_entity entity)
{
	return (struct imc_message){
		.id = IMC_ENTITY_INFO,
		.entity_info =
			{
				.id = (uint8_t)entity,
				.label = imc_text_of(imc_entity_name(entity)),
				.component = imc_text_of(imc_entity_component(entity)),
			},
	};
}

static void reply(struct imc_node *self, const struct imc_packet *request, enum imc_entity entity,
                  const struct imc_message *message, struct imc_outbox *out)
{
	self->stats.requests++;
	imc_outbox_reply(out, request, (uint8_t)entity, message);
}

/* From the entity that was asked, or from each when all were. */
static void tell_each(struct imc_node *self, const struct imc_packet *request,
                      struct imc_outbox *out)
{
	const uint8_t asked = request->header.dst_ent;

	for (uint8_t i = 0; i < IMC_ENTITY_COUNT; i++) {
		if (asked != i && asked != IMC_ENTITY_ALL) {
			continue;
		}
		const struct imc_message message =
			request->message.id == IMC_QUERY_ENTITY_STATE
				? state_of(self, (enum imc_entity)i)
				: (struct imc_message){
					  .id = IMC_ENTITY_ACTIVATION_STATE,
					  .entity_activation_state = {.state = IMC_ENTITY_ACTIVE},
				  };

		reply(self, request, (enum imc_entity)i, &message, out);
	}
}

/* The header says which entity is meant; when it says all of them, the field does. */
static void tell_info(struct imc_node *self, const struct imc_packet *request,
                      struct imc_outbox *out)
{
	const uint8_t entity = request->header.dst_ent != IMC_ENTITY_ALL
	                               ? request->header.dst_ent
	                               : request->message.query_entity_info.id;

	if (entity >= IMC_ENTITY_COUNT) {
		self->stats.unknown_names++;
		return;
	}
	const struct imc_message message = info_of((enum imc_entity)entity);

	reply(self, request, (enum imc_entity)entity, &message, out);
}

static void tell_list(struct imc_node *self, const struct imc_packet *request,
                      struct imc_outbox *out)
{
	size_t used = 0;

	_Static_assert(IMC_ENTITY_COUNT <= 12, "limits.h counts on it");
	_Static_assert(IMC_ENTITY_COUNT <= 100, "ids of two digits");
	_Static_assert(IMC_LIST_MAX >= IMC_ENTITY_COUNT * 32, "names of up to 28 characters");
	for (uint8_t i = 0; i < IMC_ENTITY_COUNT; i++) {
		const char *const name = imc_entity_name((enum imc_entity)i);
		const size_t length = strlen(name);

		if (i > 0) {
			self->list[used++] = ';';
		}
		memcpy(&self->list[used], name, length);
		used += length;
		self->list[used++] = '=';
		if (i >= 10) {
			self->list[used++] = (uint8_t)('0' + i / 10);
		}
		self->list[used++] = (uint8_t)('0' + i % 10);
	}
	const struct imc_message message = {
		.id = IMC_ENTITY_LIST,
		.entity_list =
			{
				.op = IMC_ENTITY_LIST_REPORT,
				.list = {.bytes = (const char *)self->list,
	                                 .length = (uint16_t)used},
			},
	};

	reply(self, request, IMC_ENTITY_SYSTEM, &message, out);
}

static void tell_version(struct imc_node *self, const struct imc_packet *request,
                         struct imc_outbox *out)
{
	const struct imc_message message = {
		.id = IMC_VERSION_INFO,
		.version_info =
			{
				.op = IMC_VERSION_REPLY,
				.version = imc_text_of(self->config.version),
				.description = imc_text_of(self->config.name),
			},
	};

	reply(self, request, IMC_ENTITY_SYSTEM, &message, out);
}

void imc_node_receive(struct imc_node *self, int64_t now_us, const struct imc_packet *packet,
                      struct imc_outbox *out)
{
	switch (packet->message.id) {
	case IMC_QUERY_ENTITY_STATE:
	case IMC_QUERY_ENTITY_ACTIVATION_STATE:
		tell_each(self, packet, out);
		break;
	case IMC_QUERY_ENTITY_INFO:
		tell_info(self, packet, out);
		break;
	case IMC_ENTITY_LIST:
		if (packet->message.entity_list.op == IMC_ENTITY_LIST_QUERY) {
			tell_list(self, packet, out);
		}
		break;
	case IMC_VERSION_INFO:
		if (packet->message.version_info.op == IMC_VERSION_REQUEST) {
			tell_version(self, packet, out);
		}
		break;
	case IMC_QUERY_ENTITY_PARAMETERS:
		imc_node_query_parameters(self, packet, out);
		break;
	case IMC_SET_ENTITY_PARAMETERS:
		imc_node_set_parameters(self, now_us, packet, out);
		break;
	default:
		break; /* everything else is for others, or for nobody here */
	}
}

/* --- on its own ------------------------------------------------------------------------------- */

static void send_heartbeat(const struct imc_route *route, uint16_t dst, struct imc_outbox *out)
{
	const struct imc_message message = {.id = IMC_HEARTBEAT};
	const struct imc_header header = {.dst = dst, .dst_ent = IMC_ENTITY_ALL};

	imc_outbox_send(out, IMC_TO_ROUTE, route, &header, &message);
}

static void send_heartbeats(struct imc_node *self, struct imc_outbox *out)
{
	for (uint8_t i = 0; i < self->peers.count; i++) {
		send_heartbeat(&self->peers.peers[i].route, self->peers.peers[i].id, out);
	}
	for (uint8_t link = 0; link < IMC_STREAM_LINKS; link++) {
		const struct imc_route route = {.link = link};

		if ((self->config.stream_links & 1u << link) != 0 &&
		    !imc_peers_on_link(&self->peers, link)) {
			send_heartbeat(&route, IMC_DST_ALL, out);
		}
	}
}

static void send_announce(const struct imc_node *self, struct imc_outbox *out)
{
	const struct imc_header header = {.dst = 0, .dst_ent = IMC_ENTITY_ALL};
	const struct imc_message message = {
		.id = IMC_ANNOUNCE,
		.announce =
			{
				.sys_name = imc_text_of(self->config.name),
				.sys_type = SYSTEM_TYPE_MOBILE_SENSOR,
				.owner = OWNER_NONE,
				.services = imc_text_of(self->config.services),
			},
	};

	imc_outbox_send(out, IMC_TO_ANNOUNCE, NULL, &header, &message);
}

static void send_changed_states(struct imc_node *self, struct imc_outbox *out)
{
	for (uint8_t i = 0; i < IMC_ENTITY_COUNT; i++) {
		if ((self->entities.changed & 1u << i) != 0) {
			const struct imc_message message = state_of(self, (enum imc_entity)i);

			imc_outbox_publish(out, i, &message);
		}
	}
	self->entities.changed = 0;
}

/* From due to due, and not in a burst after a pause. */
static int64_t next_us(int64_t due_us, int64_t now_us, int64_t period_us)
{
	return due_us + period_us > now_us ? due_us + period_us : now_us + period_us;
}

void imc_node_step(struct imc_node *self, int64_t now_us, struct imc_outbox *out)
{
	imc_peers_step(&self->peers, now_us);
	if (self->announce_us <= now_us) {
		self->announce_us = next_us(self->announce_us, now_us, IMC_ANNOUNCE_US);
		send_announce(self, out);
	}
	if (self->heartbeat_us <= now_us) {
		self->heartbeat_us = next_us(self->heartbeat_us, now_us, IMC_HEARTBEAT_US);
		send_heartbeats(self, out);
	}
	send_changed_states(self, out);
}

int64_t imc_node_deadline_us(const struct imc_node *self)
{
	if (self->entities.changed != 0) {
		return 0;
	}
	return self->announce_us < self->heartbeat_us ? self->announce_us : self->heartbeat_us;
}
