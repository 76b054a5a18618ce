/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libFuzzer: datagrams of the user-space CAN bus.
 *
 * Input: a byte of options (bit 0: make magic and CRC right, or nothing would get past them), then
 * the datagram. Invariants: nothing is read out of bounds (sanitizers); a refused datagram leaves
 * the frame as it was; an accepted one is a valid frame, whose bits can be counted, and which is
 * written again as the same datagram but for flags that mean nothing.
 */
#include <string.h>

#include "can_host/can_frame_time.h"
#include "can_udp/can_udp_frame.h"

#include "check.h"

#define AT_FLAGS 4u

/* CRC16-CCITT bit by bit: not the decoder's own way. */
static void make_right(uint8_t *datagram, size_t length)
{
	uint32_t crc = 0xFFFF;

	for (size_t i = AT_FLAGS; i < length; i++) {
		crc ^= (uint32_t)datagram[i] << 8;
		for (int bit = 0; bit < 8; bit++) {
			crc = (crc & 0x8000u) != 0 ? (crc << 1) ^ 0x1021u : crc << 1;
		}
	}
	datagram[0] = 0x34;
	datagram[1] = 0x29;
	datagram[2] = (uint8_t)crc;
	datagram[3] = (uint8_t)(crc >> 8);
}

static void check_frame(const struct can_host_frame *frame)
{
	struct can_frame_bits bits;

	CHECK(frame->id <= ((frame->flags & CAN_HOST_EXTENDED) != 0 ? CAN_HOST_EXT_ID_MAX
	                                                            : CAN_HOST_STD_ID_MAX));
	CHECK(frame->length <=
	      ((frame->flags & CAN_HOST_FD) != 0 ? CAN_HOST_DATA_MAX : CAN_HOST_CLASSIC_MAX));
	can_frame_count_bits(frame, &bits);
	/* 64 bytes, stuffed after every fourth bit, and all that is around them */
	CHECK(bits.nominal >= 29 && bits.nominal + bits.data <= 64 * 10 + 128);
	CHECK(can_frame_time_ns(frame, 1000000, 8000000) > 0);
	CHECK(((frame->flags & CAN_HOST_EXTENDED) != 0) ==
	      ((can_frame_priority(frame) >> 19 & 1u) != 0));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	struct can_host_frame frame;
	struct can_host_frame untouched;
	uint8_t datagram[256];
	uint8_t again[CAN_UDP_MAX];
	size_t length;

	if (size < 1) {
		return 0;
	}
	length = size - 1 < sizeof(datagram) ? size - 1 : sizeof(datagram);
	memcpy(datagram, data + 1, length);
	if ((data[0] & 1u) != 0 && length >= CAN_UDP_HEADER) {
		make_right(datagram, length);
	}
	memset(&frame, 0xA5, sizeof(frame));
	untouched = frame;
	if (!can_udp_decode(datagram, length, &frame)) {
		CHECK(memcmp(&frame, &untouched, sizeof(frame)) == 0);
		return 0;
	}
	check_frame(&frame);
	datagram[AT_FLAGS] &= 1u;
	datagram[AT_FLAGS + 1] = 0;
	make_right(datagram, length);
	CHECK(can_udp_encode(&frame, again) == length);
	CHECK(memcmp(again, datagram, length) == 0);
	return 0;
}
