/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the links of MAVLink have in common. They carry frames and know no meaning: UARTs, and the
 * tunnels over CAN. A frame sent is copied whole into the link's queue, or refused and counted.
 * Nothing is sent to a tunnel that nobody has opened.
 *
 * Frames of others that are forwarded never stand before our own: on a UART they have a queue of
 * their own, which is sent from while the other is empty; in a tunnel, half of the buffer. What has
 * no room there is dropped and counted.
 */
#ifndef PHAROS_THREADS_LINK_H
#define PHAROS_THREADS_LINK_H

#include <stdbool.h>
#include <stdint.h>

#include "proto/mavlink/framer.h"

/* What did not become a frame. */
struct link_framing_stats {
	uint32_t crc_errors;
	uint32_t resyncs;
	uint32_t skipped_bytes;
};

struct link_stats {
	uint32_t rx_bytes;
	uint32_t rx_frames;
	uint32_t rx_overruns; /* times the receive ring was full, or the hardware said so */
	uint32_t rx_errors;   /* framing, parity, noise, break */
	uint32_t tx_frames;
	uint32_t tx_bytes;
	uint32_t tx_dropped; /* frames refused because the queue was full */
	uint32_t forwarded;  /* of others; counted in tx_frames as well once they are sent */
	uint32_t forward_dropped;
	struct link_framing_stats framing;
};

static inline struct link_framing_stats link_framing_of(const struct mavlink_framer_stats *framer)
{
	return (struct link_framing_stats){
		.crc_errors = framer->crc_errors,
		.resyncs = framer->resyncs,
		.skipped_bytes = framer->skipped_bytes,
	};
}

/* Whether frames that can't be verified are received too, to be forwarded. Set by the command
 * thread; any thread.
 */
void link_set_opaque(bool opaque);
bool link_is_opaque(void);

#endif
