/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Links carry MAVLink frames and know no meaning: UARTs, and the tunnels over CAN. A frame received
 * on a UART goes to the command thread in a buffer of the pool; a frame sent is copied whole into
 * the link's queue, or refused and counted. Nothing is sent to a tunnel that nobody has opened.
 *
 * Frames of others that are forwarded never stand before our own: on a UART they have a queue of
 * their own, which is sent from while the other is empty; in a tunnel, half of the buffer. What has
 * no room there is dropped and counted.
 */
#ifndef PHAROS_THREADS_LINK_H
#define PHAROS_THREADS_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "proto/mavlink/framer.h"
#include "threads/limits.h"

struct link_frame {
	uint8_t link; /* 0…LINKS_MAX - 1 */
	uint16_t length;
	uint8_t bytes[MAVLINK_FRAME_MAX];
};

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

/*
 * frame: 1…MAVLINK_FRAME_MAX bytes, sent as one write. Command thread only. 0; -ENODEV: no such
 * link; -ENOBUFS: the queue is full, counted.
 */
int link_send(uint8_t link, const uint8_t *frame, size_t length);

/* The same, for a frame of others. Not without CONFIG_PHAROS_ROUTING. */
int link_forward(uint8_t link, const uint8_t *frame, size_t length);

/* Whether frames that can't be verified are received too, to be forwarded. Likewise. */
void link_set_opaque(bool opaque);
/* Any thread. */
bool link_is_opaque(void);

/* Bit per link that is always there: this board's UARTs that speak MAVLink. Tunnels come and go. */
uint32_t link_mask(void);

/* Bytes a second that a link carries; 0: not known. */
uint32_t link_rate(uint8_t link);

/* Counters of a link. Any thread. -ENODEV: no such link. */
int link_stats_get(uint8_t link, struct link_stats *stats);

/* Short name of a link, "uart0", "tunnel0", … */
const char *link_name(uint8_t link);

/* Gives a received frame's buffer back to the pool. Command thread only. */
void link_frame_free(struct link_frame *frame);

#endif
