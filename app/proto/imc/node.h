/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A node of an IMC network; sans-IO: Announce on datagram links, Heartbeat to every peer, entities
 * and their states, entity parameters over the parameter table, version.
 *
 * On a stream link where nobody has spoken yet, Heartbeats go to everyone, so that a peer that
 * waits to hear somebody does.
 *
 * Context: the thread that owns it, no locks inside.
 */
#ifndef PHAROS_PROTO_IMC_NODE_H
#define PHAROS_PROTO_IMC_NODE_H

#include "core/device.h"
#include "proto/imc/entities.h"
#include "proto/imc/outbox.h"
#include "proto/imc/peers.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * Texts are kept by reference and live as long as the node. stream_links: bit per link. services:
 * of the Announce, NULL: no datagram link, nothing is announced.
 */
struct imc_node_config {
	const char *name;
	const char *version;
	const char *services;
	uint8_t stream_links;
};

struct imc_node_stats {
	uint32_t requests;       /* that were answered */
	uint32_t unknown_names;  /* entities that we don't have */
	uint32_t params_refused; /* no such parameter, no number, or core/params refused it */
};

struct imc_node {
	struct imc_node_config config;
	struct pharos_device *device;
	struct imc_entities entities;
	struct imc_peers peers;
	struct imc_node_stats stats;
	int64_t heartbeat_us; /* the next one */
	int64_t announce_us;
	uint8_t list[IMC_LIST_MAX]; /* what a message that is being sent points at */
};

/* device: kept by reference. */
void imc_node_init(struct imc_node *self, int64_t now_us, const struct imc_node_config *config,
                   struct pharos_device *device);

/* A packet for us or for everyone. Others than the node's messages are ignored. Adds to *out. */
void imc_node_receive(struct imc_node *self, int64_t now_us, const struct imc_packet *packet,
                      struct imc_outbox *out);

/* At its deadline or before. Adds to *out. */
void imc_node_step(struct imc_node *self, int64_t now_us, struct imc_outbox *out);
int64_t imc_node_deadline_us(const struct imc_node *self);

/* param_service.c: QueryEntityParameters and SetEntityParameters. */
void imc_node_query_parameters(struct imc_node *self, const struct imc_packet *packet,
                               struct imc_outbox *out);
void imc_node_set_parameters(struct imc_node *self, int64_t now_us, const struct imc_packet *packet,
                             struct imc_outbox *out);

#endif
