/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What IMC wants sent: packets in their order. What an answer tells is in force before it leaves,
 * since the device's effects are performed first. Packets are encoded at once: nothing that a
 * message points at has to outlive the call.
 *
 * The endpoint begins each call's outbox; a service only adds to it.
 *
 * Context: the thread that owns it.
 */
#ifndef PHAROS_PROTO_IMC_OUTBOX_H
#define PHAROS_PROTO_IMC_OUTBOX_H

#include "proto/imc/codec.h"

#include <stdbool.h>
#include <stdint.h>

/* Where a packet came from, or goes: a link, and on a datagram link the other side's IPv4 address.
 */
struct imc_route {
	uint8_t link;
	uint16_t port;    /* 0: not a datagram link */
	uint32_t address; /* host byte order */
};

enum imc_to {
	IMC_TO_ROUTE,    /* route */
	IMC_TO_PEERS,    /* once to each route that a known peer is at */
	IMC_TO_ANNOUNCE, /* wherever datagrams are announced */
};

struct imc_outbox_packet {
	uint16_t offset; /* into bytes */
	uint16_t length;
	enum imc_to to;
	struct imc_route route;
};

struct imc_outbox {
	uint16_t src;            /* this device's id */
	double timestamp_s;      /* what packets are stamped with */
	struct imc_route origin; /* where the packet's sender hears answers */
	uint32_t unsent;         /* packets that found no room */
	uint8_t packets_count;
	uint16_t used;
	struct imc_outbox_packet packets[IMC_OUTBOX_PACKETS];
	uint8_t bytes[IMC_OUTBOX_BYTES];
};

/* Empties it. origin NULL: nobody is being answered. */
void imc_outbox_begin(struct imc_outbox *self, uint16_t src, double timestamp_s,
                      const struct imc_route *origin);

/* An answer from one of our entities to whoever sent the request, to where that hears it. */
void imc_outbox_reply(struct imc_outbox *self, const struct imc_packet *request, uint8_t src_ent,
                      const struct imc_message *message);

/* To everyone that we know: dst IMC_DST_ALL, dst_ent IMC_ENTITY_ALL. */
void imc_outbox_publish(struct imc_outbox *self, uint8_t src_ent,
                        const struct imc_message *message);

/* With any header (src and timestamp_s are filled in) to a route, or all (route NULL). */
void imc_outbox_send(struct imc_outbox *self, enum imc_to to, const struct imc_route *route,
                     const struct imc_header *header, const struct imc_message *message);

#endif
