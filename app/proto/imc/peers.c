/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/peers.h"

static struct imc_peer *find(struct imc_peers *self, uint16_t id, uint8_t link)
{
	for (uint8_t i = 0; i < self->count; i++) {
		if (self->peers[i].id == id && self->peers[i].route.link == link) {
			return &self->peers[i];
		}
	}
	return NULL;
}

void imc_peers_heard(struct imc_peers *self, int64_t now_us, uint16_t id,
                     const struct imc_route *route, bool announced)
{
	struct imc_peer *peer = find(self, id, route->link);

	if (peer == NULL) {
		if (self->count == IMC_PEERS_MAX) {
			self->refused++;
			return;
		}
		peer = &self->peers[self->count++];
		*peer = (struct imc_peer){.id = id, .route = *route};
	}
	peer->heard_us = now_us;
	if (announced || !peer->announced) {
		peer->route = *route;
		peer->announced = announced;
	}
}

const struct imc_route *imc_peers_answer_route(const struct imc_peers *self, uint16_t id,
                                               const struct imc_route *from)
{
	for (uint8_t i = 0; i < self->count; i++) {
		const struct imc_peer *const peer = &self->peers[i];

		if (peer->id == id && peer->route.link == from->link && peer->announced) {
			return &peer->route;
		}
	}
	return from;
}

void imc_peers_step(struct imc_peers *self, int64_t now_us)
{
	uint8_t kept = 0;

	for (uint8_t i = 0; i < self->count; i++) {
		if (now_us - self->peers[i].heard_us < IMC_PEER_SILENCE_US) {
			self->peers[kept++] = self->peers[i];
		}
	}
	self->count = kept;
}

bool imc_peers_on_link(const struct imc_peers *self, uint8_t link)
{
	for (uint8_t i = 0; i < self->count; i++) {
		if (self->peers[i].route.link == link) {
			return true;
		}
	}
	return false;
}

static bool same_route(const struct imc_route *a, const struct imc_route *b)
{
	return a->link == b->link && a->port == b->port && a->address == b->address;
}

bool imc_peers_is_first(const struct imc_peers *self, uint8_t index)
{
	for (uint8_t i = 0; i < index; i++) {
		if (same_route(&self->peers[i].route, &self->peers[index].route)) {
			return false;
		}
	}
	return true;
}
