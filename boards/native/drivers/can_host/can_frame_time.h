/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How long a frame occupies a CAN bus, from its bits (ISO 11898-1): header, data, checksum, the
 * stuff bits that this very frame needs, acknowledgement, end of frame and the three bits between
 * frames.
 *
 * CAN FD with bit-rate switch: the bits after BRS up to the checksum's delimiter are the data
 * phase's.
 */
#ifndef CAN_FRAME_TIME_H_
#define CAN_FRAME_TIME_H_

#include <stdint.h>

#include "can_host_bus.h"

struct can_frame_bits {
	uint32_t nominal; /* at the arbitration phase's bit rate */
	uint32_t data;    /* at the data phase's */
};

void can_frame_count_bits(const struct can_host_frame *frame, struct can_frame_bits *bits);

/* Rounded up. Bit rates > 0. */
uint64_t can_frame_time_ns(const struct can_host_frame *frame, uint32_t bitrate,
                           uint32_t bitrate_data);

/* What bus arbitration compares: the lower one wins. */
uint32_t can_frame_priority(const struct can_host_frame *frame);

#endif
