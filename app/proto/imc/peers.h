/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who has been heard in the last IMC_PEER_SILENCE_US, and where. A vehicle on two links is two
 * peers. The table is fixed: while it is full, newcomers have no place, so that nobody who floods
 * it can displace the vehicle.
 *
 * Context: the thread that owns it.
 */
#ifndef PHAROS_PROTO_IMC_PEERS_H
#define PHAROS_PROTO_IMC_PEERS_H

#include "proto/imc/outbox.h"

#include <stdbool.h>
#include <stdint.h>

struct imc_peer {
	uint16_t id;
	bool announced; /* route is what it announced, and packets from elsewhere don't change it */
	struct imc_route route;
	int64_t heard_us;
};

struct imc_peers {
	uint8_t count;
	struct imc_peer peers[IMC_PEERS_MAX];
	uint32_t refused; /* times that there was no place */
};

/* A packet came from there; announced: route is the address that it asks for. */
void imc_peers_heard(struct imc_peers *self, int64_t now_us, uint16_t id,
                     const struct imc_route *route, bool announced);

/* Where answers to a packet go that came from `from`: to the address that its sender has announced,
 * else there.
 */
const struct imc_route *imc_peers_answer_route(const struct imc_peers *self, uint16_t id,
                                               const struct imc_route *from);

/* Drops those that have been silent for too long. */
void imc_peers_step(struct imc_peers *self, int64_t now_us);

/* Is somebody known on this link? */
bool imc_peers_on_link(const struct imc_peers *self, uint8_t link);

/* Does no earlier peer have the same route? What goes to all peers goes to these. */
bool imc_peers_is_first(const struct imc_peers *self, uint8_t index);

#endif
