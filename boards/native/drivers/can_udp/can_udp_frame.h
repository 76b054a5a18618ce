/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A CAN frame in a UDP datagram, as ArduPilot's simulator sends it on its multicast CAN. Little
 * endian: magic u16 0x2934; CRC16-CCITT (seed 0xFFFF) u16 over all that follows; flags u16, bit 0:
 * FD; id u32, bit 31: extended, bit 30: remote frame, bit 29: error frame; then the data.
 *
 * Nothing in it tells the bit-rate switch: FD frames count as switched.
 */
#ifndef CAN_UDP_FRAME_H_
#define CAN_UDP_FRAME_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "../can_host/can_host_bus.h"

enum {
	CAN_UDP_HEADER = 10,
	CAN_UDP_MAX = CAN_UDP_HEADER + CAN_HOST_DATA_MAX,
};

/* How many bytes of the datagram it took. The frame is a valid one. */
size_t can_udp_encode(const struct can_host_frame *frame, uint8_t datagram[CAN_UDP_MAX]);

/*
 * False: it is none: shorter than a header, longer than the longest; other magic; wrong CRC; more
 * than 8 bytes in a classic frame; a number of bytes that no length code has; a standard id above
 * 0x7FF; a remote frame with FD; an error frame. Then *frame is unchanged.
 */
bool can_udp_decode(const uint8_t *datagram, size_t length, struct can_host_frame *frame);

#endif
