/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Another node with our node id; sans-IO. DroneCAN resolves nothing here, so the light says so:
 *
 *   NodeStatus from our id, whose uptime is not ours ---------------------------> a clash
 *   NodeStatus from our id -> GetNodeInfo to it -> an answer of another unique id -> a clash, named
 *
 * A bridge that sends our own frames back is neither. Nothing from our id for 10 s: it is over.
 *
 * While it lasts, GetNodeInfo is answered after a random while: two answers at once would destroy
 * each other on the wire, and whoever asks hears one of them each time.
 *
 * Context: the thread that owns it, no locks inside.
 */
#ifndef PHAROS_PROTO_DRONECAN_CLASH_H
#define PHAROS_PROTO_DRONECAN_CLASH_H

#include "proto/dronecan/allocation.h"
#include "proto/dronecan/transport.h"

#include <stdbool.h>
#include <stdint.h>

/* Readable by the owner; only the functions below write. */
struct dronecan_clash {
	bool on;
	bool is_named; /* unique_id: the other node's */
	uint8_t unique_id[DRONECAN_UNIQUE_ID_SIZE];

	int64_t heard_us;
	int64_t ask_us;    /* when to ask the other; TIME_NEVER_US: no need */
	int64_t asked_us;  /* when that was decided last */
	int64_t answer_us; /* when to answer `waiting`; TIME_NEVER_US: nobody waits */
	struct dronecan_transfer waiting; /* without data */
};

void dronecan_clash_init(struct dronecan_clash *self);

/* A NodeStatus or a response of GetNodeInfo that came from our own id; others: ignored. */
void dronecan_clash_receive(struct dronecan_clash *self, int64_t now_us,
                            struct dronecan_transport *transport, const uint8_t *unique_id,
                            const struct dronecan_transfer *transfer);

/* True: the answer to this GetNodeInfo is due later, out of dronecan_clash_step(). */
bool dronecan_clash_delays(struct dronecan_clash *self, int64_t now_us,
                           struct dronecan_transport *transport,
                           const struct dronecan_transfer *request);

/* At its deadline or before. True: self->waiting is to be answered now. */
bool dronecan_clash_step(struct dronecan_clash *self, int64_t now_us,
                         struct dronecan_transport *transport);
int64_t dronecan_clash_deadline_us(const struct dronecan_clash *self);

#endif
