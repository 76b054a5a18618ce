/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the peers of fuzz_command send, each piece made of what comes next in the script. Lengths
 * are in bytes; 0: nothing comes of it.
 */
#ifndef PHAROS_FUZZ_COMMAND_PEERS_H_
#define PHAROS_FUZZ_COMMAND_PEERS_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/dronecan/transport.h"
#include "proto/mavlink/signing.h"
#include "threads/frames.h"

struct script {
	const uint8_t *at;
	const uint8_t *end;
};

/* The next byte; 0 behind the end. */
uint8_t script_take(struct script *script);
void script_take_bytes(struct script *script, uint8_t *to, size_t count);

/* A MAVLink message of a kind that the light knows, unsigned. */
size_t peer_message(struct script *script, uint8_t bytes[MAVLINK_FRAME_MAX]);

/* COMMAND_LONG to one of our components, unsigned. */
size_t peer_command(struct script *script, uint8_t bytes[MAVLINK_FRAME_MAX]);

/* The same, signed by somebody who has the key of own. *is_right: and not changed afterwards. */
size_t peer_signed_command(struct script *script, int64_t now_us, const struct mavlink_signing *own,
                           uint8_t bytes[MAVLINK_FRAME_MAX], bool *is_right);

/* Queues a DroneCAN transfer to the node at the peer; false: it has no room. */
bool peer_transfer(struct script *script, int64_t now_us, struct dronecan_transport *peer,
                   uint8_t node);

/* A classic frame of any id. */
void peer_can_frame(struct script *script, struct dronecan_frame *frame);

/* An IMC packet with a good checksum, to the id or to all; on the link `uart`, or `datagrams`. */
void peer_packet(struct script *script, uint16_t id, uint8_t uart, uint8_t datagrams,
                 struct imc_frame *frame);

#endif /* PHAROS_FUZZ_COMMAND_PEERS_H_ */
