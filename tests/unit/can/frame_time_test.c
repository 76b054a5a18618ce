/* SPDX-License-Identifier: Apache-2.0 */
/* Lengths of frames in bits, counted by hand from ISO 11898-1; the bits between frames (3)
 * included. */
#include "can_host/can_frame_time.h"

#include <zephyr/ztest.h>

ZTEST_SUITE(can_frame_time, NULL, NULL, NULL, NULL, NULL);

static struct can_frame_bits count(const struct can_host_frame *frame)
{
	struct can_frame_bits bits;

	can_frame_count_bits(frame, &bits);
	return bits;
}

ZTEST(can_frame_time, test_all_zero_standard_frame)
{
	/* Start, id, RTR, IDE, r0, length and a checksum of zeros: 34 zeros, so 6 stuff bits; then
	 * 13 bits that are never stuffed. */
	const struct can_host_frame frame = {.id = 0};

	zassert_equal(count(&frame).nominal, 34 + 6 + 13);
	zassert_equal(count(&frame).data, 0);
	zassert_equal(can_frame_time_ns(&frame, 1000000, 1000000), 53000);
	zassert_equal(can_frame_time_ns(&frame, 125000, 1000000), 424000);
}

ZTEST(can_frame_time, test_fd_without_switch)
{
	/* 14 zeros (2 stuff bits), FDF, 7 zeros (1 stuff bit); stuff count 4, checksum 17, fixed
	 * stuff bits 6, delimiter; then 12. */
	const struct can_host_frame frame = {.flags = CAN_HOST_FD};

	zassert_equal(count(&frame).nominal, 14 + 2 + 1 + 7 + 1 + 27 + 1 + 12);
	zassert_equal(count(&frame).data, 0);
}

ZTEST(can_frame_time, test_fd_with_switch)
{
	/* Up to BRS: 14 zeros (2 stuff bits), FDF, reserved, BRS. Fast: ESI and length, 5 zeros
	 * whose stuff bit is the first fixed one; 27; delimiter. */
	const struct can_host_frame frame = {.flags = CAN_HOST_FD | CAN_HOST_BRS};

	zassert_equal(count(&frame).nominal, 14 + 2 + 3 + 12);
	zassert_equal(count(&frame).data, 5 + 27 + 1);
	/* 31 us + 33 / 4 us */
	zassert_equal(can_frame_time_ns(&frame, 1000000, 4000000), 39250);
}

ZTEST(can_frame_time, test_long_fd_frames_have_the_long_checksum)
{
	struct can_host_frame frame = {.flags = CAN_HOST_FD | CAN_HOST_BRS, .length = 16};
	uint32_t shorter;

	/* Data 0x55…: no stuff bits in them. 4 bytes more, and 25 + 7 bits instead of 21 + 6. */
	for (size_t i = 0; i < CAN_HOST_DATA_MAX; i++) {
		frame.data[i] = 0x55;
	}
	shorter = count(&frame).data;
	frame.length = 20;
	zassert_equal(count(&frame).data - shorter, 32 + 5);
}

ZTEST(can_frame_time, test_bounds_of_classic_frames)
{
	/* Davis, Burns, Bril, Lukkien 2007: at most 55 + 10 s bits with a standard id, 80 + 10 s
	 * with an extended one; without stuff bits 47 + 8 s and 67 + 8 s. */
	uint32_t random = 1;

	for (int i = 0; i < 100000; i++) {
		struct can_host_frame frame = {0};
		const bool extended = (i & 1) != 0;
		uint32_t bits;

		random = random * 1664525u + 1013904223u;
		frame.id = extended ? random >> 3 : random >> 21;
		frame.flags = extended ? CAN_HOST_EXTENDED : 0;
		frame.length = (uint8_t)(i % 9);
		for (uint8_t k = 0; k < frame.length; k++) {
			frame.data[k] = (i & 2) != 0 ? (uint8_t)(random >> k) : 0x78;
		}
		bits = count(&frame).nominal;
		zassert_true(bits >= (extended ? 67u : 47u) + 8u * frame.length);
		zassert_true(bits <= (extended ? 80u : 55u) + 10u * frame.length);
	}
}

ZTEST(can_frame_time, test_priorities)
{
	const struct can_host_frame standard = {.id = 0x100};
	const struct can_host_frame remote = {.id = 0x100, .flags = CAN_HOST_REMOTE};
	const struct can_host_frame same_base = {.id = 0x100u << 18, .flags = CAN_HOST_EXTENDED};
	const struct can_host_frame next = {.id = 0x101};
	const struct can_host_frame longer = {.id = (0x100u << 18) + 1, .flags = CAN_HOST_EXTENDED};

	zassert_true(can_frame_priority(&standard) < can_frame_priority(&remote));
	zassert_true(can_frame_priority(&remote) < can_frame_priority(&same_base));
	zassert_true(can_frame_priority(&same_base) < can_frame_priority(&longer));
	zassert_true(can_frame_priority(&longer) < can_frame_priority(&next));
}
