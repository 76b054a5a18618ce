/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/outbox.h"

void imc_outbox_begin(struct imc_outbox *self, uint16_t src, double timestamp_s,
                      const struct imc_route *origin)
{
	static const struct imc_route nowhere;

	self->src = src;
	self->timestamp_s = timestamp_s;
	self->origin = origin != NULL ? *origin : nowhere;
	self->unsent = 0;
	self->packets_count = 0;
	self->used = 0;
}

void imc_outbox_send(struct imc_outbox *self, enum imc_to to, const struct imc_route *route,
                     const struct imc_header *header, const struct imc_message *message)
{
	struct imc_outbox_packet *const place = &self->packets[self->packets_count];
	struct imc_packet packet = {.header = *header, .message = *message};
	size_t length = 0;

	packet.header.src = self->src;
	packet.header.timestamp_s = self->timestamp_s;
	if (self->packets_count < IMC_OUTBOX_PACKETS) {
		length = imc_encode(&packet, self->bytes + self->used,
		                    IMC_OUTBOX_BYTES - self->used);
	}
	if (length == 0) {
		self->unsent++;
		return;
	}
	*place = (struct imc_outbox_packet){
		.offset = self->used,
		.length = (uint16_t)length,
		.to = to,
		.route = route != NULL ? *route : (struct imc_route){0},
	};
	self->packets_count++;
	self->used = (uint16_t)(self->used + length);
}

void imc_outbox_reply(struct imc_outbox *self, const struct imc_packet *request, uint8_t src_ent,
                      const struct imc_message *message)
{
	const struct imc_header header = {
		.src_ent = src_ent,
		.dst = request->header.src,
		.dst_ent = request->header.src_ent,
	};

	imc_outbox_send(self, IMC_TO_ROUTE, &self->origin, &header, message);
}

void imc_outbox_publish(struct imc_outbox *self, uint8_t src_ent, const struct imc_message *message)
{
	const struct imc_header header = {
		.src_ent = src_ent,
		.dst = IMC_DST_ALL,
		.dst_ent = IMC_ENTITY_ALL,
	};

	imc_outbox_send(self, IMC_TO_PEERS, NULL, &header, message);
}
