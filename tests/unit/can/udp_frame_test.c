/* SPDX-License-Identifier: Apache-2.0 */
/* The user-space bus's framing. */
#include "can_udp/can_udp_frame.h"

#include <string.h>

#include <zephyr/ztest.h>

ZTEST_SUITE(can_udp_frame, NULL, NULL, NULL, NULL, NULL);

/* FD, extended id 0x1ABCDE, data 00…0B, as ArduPilot's framing has it. */
static const uint8_t vector[] = {0x34, 0x29, 0xF8, 0x64, 0x01, 0x00, 0xDE, 0xBC, 0x1A, 0x80, 0x00,
                                 0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x08, 0x09, 0x0A, 0x0B};

ZTEST(can_udp_frame, test_vector_is_read)
{
	struct can_host_frame frame;

	zassert_true(can_udp_decode(vector, sizeof(vector), &frame));
	zassert_equal(frame.id, 0x1ABCDE);
	zassert_equal(frame.flags, CAN_HOST_EXTENDED | CAN_HOST_FD | CAN_HOST_BRS);
	zassert_equal(frame.length, 12);
	zassert_mem_equal(frame.data, "\0\1\2\3\4\5\6\7\10\11\12\13", 12);
}

ZTEST(can_udp_frame, test_vector_is_written)
{
	struct can_host_frame frame = {
		.id = 0x1ABCDE, .flags = CAN_HOST_EXTENDED | CAN_HOST_FD, .length = 12};
	uint8_t datagram[CAN_UDP_MAX];

	memcpy(frame.data, "\0\1\2\3\4\5\6\7\10\11\12\13", 12);
	zassert_equal(can_udp_encode(&frame, datagram), sizeof(vector));
	zassert_mem_equal(datagram, vector, sizeof(vector));
}

ZTEST(can_udp_frame, test_any_flipped_bit_is_noticed)
{
	for (size_t bit = 0; bit < 8 * sizeof(vector); bit++) {
		uint8_t datagram[sizeof(vector)];
		struct can_host_frame frame;

		memcpy(datagram, vector, sizeof(vector));
		datagram[bit / 8] ^= (uint8_t)(1u << (bit % 8));
		zassert_false(can_udp_decode(datagram, sizeof(datagram), &frame), "bit %zu", bit);
	}
}

ZTEST(can_udp_frame, test_any_cut_is_noticed)
{
	struct can_host_frame frame;

	for (size_t length = 0; length < sizeof(vector); length++) {
		zassert_false(can_udp_decode(vector, length, &frame), "%zu bytes", length);
	}
}

/* Written by the encoder, which does not ask whether a frame is valid. */
static bool survives(uint32_t id, uint8_t flags, uint8_t length)
{
	const struct can_host_frame frame = {.id = id, .flags = flags, .length = length};
	uint8_t datagram[CAN_UDP_MAX];
	struct can_host_frame read;

	return can_udp_decode(datagram, can_udp_encode(&frame, datagram), &read);
}

ZTEST(can_udp_frame, test_what_is_no_frame)
{
	zassert_true(survives(0x7FF, 0, 8));
	zassert_false(survives(0x7FF, 0, 12)); /* longer than classic */
	zassert_true(survives(0x7FF, CAN_HOST_FD, 64));
	zassert_false(survives(0x7FF, CAN_HOST_FD, 63)); /* no such length code */
	zassert_false(survives(0x800, 0, 0));            /* no standard id */
	zassert_true(survives(0x800, CAN_HOST_EXTENDED, 0));
	zassert_true(survives(1, CAN_HOST_REMOTE, 0));
	zassert_false(survives(1, CAN_HOST_REMOTE | CAN_HOST_FD, 0));
	zassert_false(survives(1u << 29, CAN_HOST_EXTENDED, 0)); /* an error frame */
}
