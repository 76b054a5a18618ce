/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The framer of a router: messages that no dialect has come out by the length that they claim, and
 * no verified frame is lost to that.
 */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

#define UNKNOWN_ID 0xABCDEF

/* A processor that QEMU translates takes minutes for what the host does in seconds. */
#define ROUNDS (IS_ENABLED(CONFIG_QEMU_TARGET) ? 20000 : 200000)

static struct mavlink_framer framer;

/* What has come out. */
static uint32_t verified;
static uint32_t opaque;
static uint8_t last[MAVLINK_FRAME_MAX];
static size_t last_length;

static void before(void *unused)
{
	(void)unused;
	mavlink_framer_init(&framer);
	framer.opaque = true;
	verified = 0;
	opaque = 0;
	last_length = 0;
}

ZTEST_SUITE(mavlink_opaque, NULL, NULL, before, NULL, NULL);

static void count(const struct mavlink_frame *frame)
{
	if (frame->message_id == UNKNOWN_ID) {
		opaque++;
	} else {
		verified++;
	}
	memcpy(last, frame->bytes, frame->length);
	last_length = frame->length;
}

static void feed(const uint8_t *bytes, size_t size, size_t chunk)
{
	struct mavlink_frame frame;

	while (size > 0) {
		const size_t taken =
			mavlink_framer_write(&framer, bytes, size < chunk ? size : chunk);

		zassert_true(taken > 0, "no room although drained");
		bytes += taken;
		size -= taken;
		while (mavlink_framer_next(&framer, &frame)) {
			count(&frame);
		}
	}
}

static void idle(void)
{
	struct mavlink_frame frame;

	while (mavlink_framer_idle(&framer, &frame)) {
		count(&frame);
		while (mavlink_framer_next(&framer, &frame)) {
			count(&frame);
		}
	}
}

/* An unknown message with that many bytes of payload, each fill. */
static size_t unknown(uint8_t *bytes, uint8_t length, uint8_t fill, bool is_signed)
{
	const struct mavlink_kind kind = {
		.id = UNKNOWN_ID, .crc_extra = 99, .min_length = length, .length = length};
	const struct mavlink_sender sender = {
		.version = 2, .system_id = 9, .component_id = 8, .has_signature = is_signed};
	uint8_t payload[MAVLINK_PAYLOAD_MAX];

	memset(payload, fill, sizeof(payload));

	const size_t built = mavlink_frame_build(bytes, &sender, &kind, payload);

	memset(bytes + built, 0x55, MAVLINK_SIGNATURE_BYTES);
	return built + (is_signed ? MAVLINK_SIGNATURE_BYTES : 0);
}

ZTEST(mavlink_opaque, test_an_unknown_message_comes_out_unchanged_whatever_its_length)
{
	uint8_t bytes[MAVLINK_FRAME_MAX];

	for (int length = 1; length <= 255; length++) {
		for (int is_signed = 0; is_signed < 2; is_signed++) {
			const size_t size = unknown(bytes, (uint8_t)length, 0x11, is_signed != 0);

			before(NULL);
			feed(bytes, size, 7);
			idle();
			zassert_equal(opaque, 1, "%d bytes", length);
			zassert_equal(last_length, size);
			zassert_mem_equal(last, bytes, size);
			zassert_equal(framer.stats.opaque_frames, 1);
			zassert_equal(framer.stats.skipped_bytes, 0);
		}
	}
}

ZTEST(mavlink_opaque, test_it_does_not_wait_when_nothing_within_could_be_a_frame)
{
	uint8_t bytes[MAVLINK_FRAME_MAX];

	feed(bytes, unknown(bytes, 100, 0x11, false), 1);
	zassert_equal(opaque, 1);
}

ZTEST(mavlink_opaque, test_version_1_as_well)
{
	/* The highest id that no dialect has; the checksum is anything. */
	const uint8_t bytes[] = {0xFE, 3, 0, 1, 1, 0, 1, 2, 3, 0x12, 0x34};
	uint8_t crc_extra;
	uint8_t frame[sizeof(bytes)];
	unsigned int id = 255;

	memcpy(frame, bytes, sizeof(bytes));
	while (mavlink_crc_extra(id, &crc_extra)) {
		id--;
	}
	frame[5] = (uint8_t)id;
	feed(frame, sizeof(frame), sizeof(frame));
	zassert_equal(framer.stats.opaque_frames, 1);
	zassert_mem_equal(last, frame, sizeof(frame));
}

ZTEST(mavlink_opaque, test_a_header_that_claims_more_than_comes_swallows_nothing)
{
	/* As in framer_test: 200 bytes claimed, none come. */
	const uint8_t start[] = {0xFD, 200, 0, 0, 1, 2, 3, 0xEF, 0xCD, 0xAB};

	feed(start, sizeof(start), 1);
	feed(COMMAND_ON_V2, sizeof(COMMAND_ON_V2), 1);
	zassert_equal(verified, 1, "found as soon as its last byte is there");
	zassert_equal(opaque, 0);
	zassert_equal(framer.stats.skipped_bytes, sizeof(start));
}

ZTEST(mavlink_opaque, test_a_header_that_claims_part_of_a_good_frame_swallows_nothing)
{
	uint8_t start[] = {0xFD, 0, 0, 0, 1, 2, 3, 0xEF, 0xCD, 0xAB};

	/* It ends somewhere within the good frame, or behind it; bytes come in any pieces. */
	for (unsigned int claimed = 0; claimed < 2 * sizeof(COMMAND_ON_V2); claimed++) {
		for (size_t chunk = 1; chunk < 60; chunk += 7) {
			before(NULL);
			start[1] = (uint8_t)claimed;
			feed(start, sizeof(start), chunk);
			feed(COMMAND_ON_V2, sizeof(COMMAND_ON_V2), chunk);
			idle();
			/* Claims of 0 bytes end before the good frame begins. */
			zassert_equal(verified, 1, "claims %u, chunks of %u", claimed,
			              (unsigned int)chunk);
		}
	}
}

ZTEST(mavlink_opaque, test_good_and_unknown_frames_in_turn_all_come_out)
{
	static uint8_t stream[64 * (MAVLINK_FRAME_MAX + sizeof(COMMAND_ON_V2))];
	size_t size = 0;

	for (unsigned int i = 0; i < 64; i++) {
		/* Payloads full of what looks like a start of either version. */
		static const uint8_t fills[] = {0x11, 0xFD, 0xFE};

		size += unknown(stream + size, (uint8_t)(1 + i * 3), fills[i % 3], i % 2 != 0);
		memcpy(stream + size, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
		size += sizeof(COMMAND_ON_V2);
	}
	for (size_t chunk = 1; chunk < 700; chunk += 13) {
		before(NULL);
		feed(stream, size, chunk);
		idle();
		zassert_equal(verified, 64, "chunks of %u", (unsigned int)chunk);
		zassert_equal(opaque, 64, "chunks of %u", (unsigned int)chunk);
		zassert_equal(framer.stats.skipped_bytes, 0);
	}
}

ZTEST(mavlink_opaque, test_noise_costs_no_good_frame)
{
	static uint8_t stream[50 * (sizeof(COMMAND_ON_V2) + 40)];
	uint32_t state = 2463534242u; /* xorshift32, Marsaglia 2003 */

	for (int round = 0; round < 200; round++) {
		size_t size = 0;

		for (int i = 0; i < 50; i++) {
			state ^= state << 13;
			state ^= state >> 17;
			state ^= state << 5;
			for (uint32_t k = state % 40; k > 0; k--) {
				state ^= state << 13;
				state ^= state >> 17;
				state ^= state << 5;
				stream[size++] = (state & 3) == 0
				                         ? (uint8_t)(0xFD + (state >> 2 & 1))
				                         : (uint8_t)(state >> 8);
			}
			memcpy(stream + size, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
			size += sizeof(COMMAND_ON_V2);
		}
		before(NULL);
		feed(stream, size, 1 + state % 600);
		idle();
		/* Noise may come out as unknown messages, but no good frame is lost within one. */
		zassert_equal(framer.stats.frames - framer.stats.opaque_frames, 50, "round %d",
		              round);
	}
}

ZTEST(mavlink_opaque, test_there_is_always_room_for_more)
{
	struct mavlink_frame frame;
	uint32_t state = 88172645u;

	for (int i = 0; i < ROUNDS; i++) {
		state ^= state << 13;
		state ^= state >> 17;
		state ^= state << 5;

		const uint8_t byte = (state & 1) == 0 ? 0xFE : (uint8_t)(state >> 8);

		zassert_equal(mavlink_framer_write(&framer, &byte, 1), 1);
		while (mavlink_framer_next(&framer, &frame)) {
		}
	}
}
