/* SPDX-License-Identifier: Apache-2.0 */
#include "can_frame_time.h"

#include <stdbool.h>

enum {
	BASE_BITS = 11,
	EXTENSION_BITS = 18,
	LENGTH_CODE_BITS = 4,
	CRC15_BITS = 15,
	CRC15_POLYNOMIAL = 0x4599,
	STUFF_AFTER = 5,
	DELIMITER_BITS = 1,
	/* ACK and its delimiter, end of frame, intermission */
	TAIL_BITS = 2 + 7 + 3,
	/* CAN FD: stuff count, checksum (17 bits up to 16 bytes, else 21), fixed stuff bits: one
	 * first, one after every 4. */
	STUFF_COUNT_BITS = 4,
	FD_SHORT_MAX = 16,
	FD_SHORT_CRC_BITS = STUFF_COUNT_BITS + 17 + 6,
	FD_LONG_CRC_BITS = STUFF_COUNT_BITS + 21 + 7,
};

/* The bits of a frame one after the other. */
struct writer {
	uint32_t count; /* stuff bits included */
	uint32_t same;  /* equal bits in a row at the end */
	bool last;
	bool stuffed; /* the last one is a stuff bit */
	uint16_t crc;
};

static void put_bit(struct writer *writer, bool bit)
{
	const bool invert = (((writer->crc >> (CRC15_BITS - 1)) & 1u) != 0) != bit;

	writer->crc = (uint16_t)((writer->crc << 1) & 0x7FFFu);
	if (invert) {
		writer->crc ^= CRC15_POLYNOMIAL;
	}
	writer->count++;
	writer->same = writer->same > 0 && bit == writer->last ? writer->same + 1 : 1;
	writer->last = bit;
	writer->stuffed = writer->same == STUFF_AFTER;
	if (writer->stuffed) {
		writer->count++;
		writer->last = !bit;
		writer->same = 1;
	}
}

static void put(struct writer *writer, uint32_t value, uint32_t bits)
{
	while (bits > 0) {
		bits--;
		put_bit(writer, ((value >> bits) & 1u) != 0);
	}
}

static uint32_t length_code(const struct can_host_frame *frame)
{
	static const uint8_t longer[] = {12, 16, 20, 24, 32, 48, 64};
	uint32_t code = CAN_HOST_CLASSIC_MAX + 1;

	if (frame->length <= CAN_HOST_CLASSIC_MAX) {
		return frame->length;
	}
	for (const uint8_t *at = longer; *at < frame->length && *at < CAN_HOST_DATA_MAX; at++) {
		code++;
	}
	return code;
}

/* Start of frame up to and with the bit behind the id that tells a remote frame (r1 in FD). */
static void put_id(struct writer *writer, const struct can_host_frame *frame)
{
	const bool remote = (frame->flags & CAN_HOST_REMOTE) != 0;

	put_bit(writer, false);
	if ((frame->flags & CAN_HOST_EXTENDED) != 0) {
		put(writer, frame->id >> EXTENSION_BITS, BASE_BITS);
		put(writer, 3, 2); /* SRR, IDE */
		put(writer, frame->id, EXTENSION_BITS);
		put_bit(writer, remote);
	} else {
		put(writer, frame->id, BASE_BITS);
		put_bit(writer, remote);
		put_bit(writer, false); /* IDE */
	}
}

static void put_data(struct writer *writer, const struct can_host_frame *frame)
{
	const uint32_t length = (frame->flags & CAN_HOST_REMOTE) != 0 ? 0 : frame->length;

	put(writer, length_code(frame), LENGTH_CODE_BITS);
	for (uint32_t i = 0; i < length && i < CAN_HOST_DATA_MAX; i++) {
		put(writer, frame->data[i], 8);
	}
}

static void count_fd(const struct can_host_frame *frame, struct can_frame_bits *bits)
{
	struct writer writer = {0};
	const bool switches = (frame->flags & CAN_HOST_BRS) != 0;
	uint32_t slow;
	uint32_t fast;

	put_id(&writer, frame);
	put(&writer, 2, 2); /* FDF, reserved */
	put_bit(&writer, switches);
	slow = writer.count;
	put_bit(&writer, (frame->flags & CAN_HOST_ESI) != 0);
	put_data(&writer, frame);
	/* After the last data bit comes a fixed stuff bit, in place of one that is due. */
	fast = writer.count - (writer.stuffed ? 1 : 0) - slow +
	       (frame->length <= FD_SHORT_MAX ? FD_SHORT_CRC_BITS : FD_LONG_CRC_BITS) +
	       DELIMITER_BITS;
	slow += TAIL_BITS;
	bits->nominal = switches ? slow : slow + fast;
	bits->data = switches ? fast : 0;
}

void can_frame_count_bits(const struct can_host_frame *frame, struct can_frame_bits *bits)
{
	struct writer writer = {0};

	if ((frame->flags & CAN_HOST_FD) != 0) {
		count_fd(frame, bits);
		return;
	}
	put_id(&writer, frame);
	/* r0, and before it r1 with an extended id */
	put(&writer, 0, (frame->flags & CAN_HOST_EXTENDED) != 0 ? 2 : 1);
	put_data(&writer, frame);
	put(&writer, writer.crc, CRC15_BITS);
	bits->nominal = writer.count + DELIMITER_BITS + TAIL_BITS;
	bits->data = 0;
}

uint64_t can_frame_time_ns(const struct can_host_frame *frame, uint32_t bitrate,
                           uint32_t bitrate_data)
{
	struct can_frame_bits bits;

	can_frame_count_bits(frame, &bits);
	return (bits.nominal * UINT64_C(1000000000) + bitrate - 1) / bitrate +
	       (bits.data * UINT64_C(1000000000) + bitrate_data - 1) / bitrate_data;
}

uint32_t can_frame_priority(const struct can_host_frame *frame)
{
	const uint32_t remote = (frame->flags & CAN_HOST_REMOTE) != 0;

	/* base id, SRR or RTR, IDE, extension, RTR: the order in which the bits are sent */
	if ((frame->flags & CAN_HOST_EXTENDED) != 0) {
		return frame->id >> EXTENSION_BITS << 21 | 3u << 19 | (frame->id & 0x3FFFFu) << 1 |
		       remote;
	}
	return frame->id << 21 | remote << 20;
}
