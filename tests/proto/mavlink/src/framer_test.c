/* SPDX-License-Identifier: Apache-2.0 */
/* The framer: any chunks, noise, false starts; every good frame that can survive does. */
#include "fixture.h"

#include "vectors/mavlink_frames.h"

static struct mavlink_framer framer;

static void before(void *unused)
{
	(void)unused;
	mavlink_framer_init(&framer);
}

ZTEST_SUITE(mavlink_framer, NULL, NULL, before, NULL, NULL);

/* Feeds bytes in chunks; counts frames, and checks that they are of the expected length. */
static uint32_t feed(const uint8_t *bytes, size_t count, size_t chunk)
{
	struct mavlink_frame frame;
	uint32_t frames = 0;

	while (count > 0) {
		const size_t offered = count < chunk ? count : chunk;
		const size_t taken = mavlink_framer_write(&framer, bytes, offered);

		zassert_true(taken > 0, "no room although drained");
		bytes += taken;
		count -= taken;
		while (mavlink_framer_next(&framer, &frame)) {
			frames++;
		}
	}
	return frames;
}

static uint32_t drain_idle(void)
{
	struct mavlink_frame frame;
	uint32_t frames = 0;

	while (mavlink_framer_idle(&framer, &frame)) {
		frames++;
		while (mavlink_framer_next(&framer, &frame)) {
			frames++;
		}
	}
	return frames;
}

/* xorshift32, Marsaglia 2003: the same numbers in every run. */
static uint32_t random_next(uint32_t *state)
{
	*state ^= *state << 13;
	*state ^= *state >> 17;
	*state ^= *state << 5;
	return *state;
}

ZTEST(mavlink_framer, test_versions_and_signed_frames_pass_whole)
{
	struct mavlink_frame frame;

	mavlink_framer_write(&framer, COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
	mavlink_framer_write(&framer, HEARTBEAT_SIGNED, sizeof(HEARTBEAT_SIGNED));
	mavlink_framer_write(&framer, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
	zassert_true(mavlink_framer_next(&framer, &frame));
	zassert_equal(frame.length, sizeof(COMMAND_ON_V1));
	zassert_mem_equal(frame.bytes, COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
	zassert_true(mavlink_framer_next(&framer, &frame));
	zassert_equal(frame.length, sizeof(HEARTBEAT_SIGNED));
	zassert_mem_equal(frame.bytes, HEARTBEAT_SIGNED, sizeof(HEARTBEAT_SIGNED));
	zassert_true(mavlink_framer_next(&framer, &frame));
	zassert_mem_equal(frame.bytes, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
	zassert_false(mavlink_framer_next(&framer, &frame));
	zassert_false(mavlink_framer_pending(&framer));
	zassert_equal(framer.stats.frames, 3);
	zassert_equal(framer.stats.skipped_bytes, 0);
	zassert_equal(framer.stats.resyncs, 0);
}

ZTEST(mavlink_framer, test_every_chunk_size_gives_the_same)
{
	static uint8_t stream[20 * (sizeof(COMMAND_ON_V2) + sizeof(COMMAND_ON_V1))];
	size_t used = 0;

	for (int i = 0; i < 20; i++) {
		memcpy(stream + used, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
		used += sizeof(COMMAND_ON_V2);
		memcpy(stream + used, COMMAND_ON_V1, sizeof(COMMAND_ON_V1));
		used += sizeof(COMMAND_ON_V1);
	}
	for (size_t chunk = 1; chunk <= used; chunk++) {
		mavlink_framer_init(&framer);
		zassert_equal(feed(stream, used, chunk), 40, "chunks of %u", (unsigned int)chunk);
		zassert_equal(framer.stats.skipped_bytes, 0);
	}
}

ZTEST(mavlink_framer, test_ten_wrong_length_bytes_in_a_hundred_cost_ten_frames)
{
	static uint8_t stream[100 * sizeof(COMMAND_ON_V2)];

	/* Each wrong length claims more or fewer bytes than there are: reference, "Traps". */
	for (int wrong = 0; wrong < 256; wrong++) {
		if (wrong == COMMAND_ON_V2[1]) {
			continue;
		}
		for (int i = 0; i < 100; i++) {
			uint8_t *const at = stream + i * sizeof(COMMAND_ON_V2);

			memcpy(at, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
			if (i % 10 == 5) {
				at[1] = (uint8_t)wrong;
			}
		}
		mavlink_framer_init(&framer);

		const uint32_t frames = feed(stream, sizeof(stream), 97) + drain_idle();

		zassert_equal(frames, 90, "length %d: %u frames", wrong, (unsigned int)frames);
		zassert_equal(framer.stats.resyncs, 10);
		zassert_equal(framer.stats.skipped_bytes, 10 * sizeof(COMMAND_ON_V2));
	}
}

ZTEST(mavlink_framer, test_noise_between_frames_costs_no_frame)
{
	static uint8_t stream[50 * (sizeof(COMMAND_ON_V2) + 40)];
	uint32_t state = 2463534242u;

	for (int round = 0; round < 200; round++) {
		size_t used = 0;

		for (int i = 0; i < 50; i++) {
			const uint32_t noise = random_next(&state) % 40;

			for (uint32_t k = 0; k < noise; k++) {
				const uint32_t r = random_next(&state);

				/* Every fourth byte of noise looks like a start. */
				stream[used++] = (r & 3) == 0 ? (uint8_t)(0xFD + (r >> 2 & 1))
				                              : (uint8_t)(r >> 8);
			}
			memcpy(stream + used, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
			used += sizeof(COMMAND_ON_V2);
		}
		mavlink_framer_init(&framer);

		const uint32_t chunk = 1 + random_next(&state) % 600;

		zassert_equal(feed(stream, used, chunk) + drain_idle(), 50, "round %d", round);
	}
}

ZTEST(mavlink_framer, test_random_cuts_cost_only_the_frames_they_hit)
{
	static uint8_t stream[60 * sizeof(COMMAND_ON_V2)];
	uint32_t state = 88172645u;

	for (int round = 0; round < 200; round++) {
		uint32_t whole = 0;
		size_t used = 0;

		for (int i = 0; i < 60; i++) {
			const uint32_t r = random_next(&state);
			const uint8_t *piece = COMMAND_ON_V2;
			size_t length = sizeof(COMMAND_ON_V2);

			/* Ends are of another frame, so that no end completes a beginning. */
			if (r % 8 == 0) {
				length = (r >> 12) % length;
			} else if (r % 8 == 1) {
				const size_t from = 8 + (r >> 12) % (length - 8);

				piece = COMMAND_CONFIGURE + from;
				length = sizeof(COMMAND_CONFIGURE) - from;
			} else {
				whole++;
			}
			memcpy(stream + used, piece, length);
			used += length;
		}
		mavlink_framer_init(&framer);
		zassert_equal(feed(stream, used, 1 + random_next(&state) % 300) + drain_idle(),
		              whole, "round %d", round);
	}
}

ZTEST(mavlink_framer, test_one_flipped_bit_costs_one_frame)
{
	static uint8_t stream[3 * sizeof(COMMAND_ON_V2)];

	for (size_t bit = 0; bit < sizeof(COMMAND_ON_V2) * 8; bit++) {
		for (int i = 0; i < 3; i++) {
			memcpy(stream + i * sizeof(COMMAND_ON_V2), COMMAND_ON_V2,
			       sizeof(COMMAND_ON_V2));
		}
		stream[sizeof(COMMAND_ON_V2) + bit / 8] ^= (uint8_t)(1u << bit % 8);
		mavlink_framer_init(&framer);
		zassert_equal(feed(stream, sizeof(stream), sizeof(stream)) + drain_idle(), 2,
		              "bit %u", (unsigned int)bit);
	}
}

ZTEST(mavlink_framer, test_unknown_id_does_not_swallow_the_next_frame)
{
	/* Id 0xFFFFFF is in no dialect; the header claims 200 bytes. */
	const uint8_t unknown[] = {0xFD, 200, 0, 0, 1, 2, 3, 0xFF, 0xFF, 0xFF};
	static uint8_t stream[sizeof(unknown) + sizeof(COMMAND_ON_V2)];

	memcpy(stream, unknown, sizeof(unknown));
	memcpy(stream + sizeof(unknown), COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
	zassert_equal(feed(stream, sizeof(stream), 1), 1);
	zassert_equal(framer.stats.unknown_ids, 1);
	zassert_equal(framer.stats.crc_errors, 0);
	zassert_equal(framer.stats.skipped_bytes, sizeof(unknown));
}

ZTEST(mavlink_framer, test_unknown_incompatibility_flag_is_no_frame)
{
	const uint8_t extra = 152; /* COMMAND_LONG, mavlink.io */
	uint8_t bytes[sizeof(COMMAND_ON_V2)];
	const size_t body = sizeof(bytes) - 2;

	for (uint8_t flag = 0; flag <= 2; flag += 2) {
		memcpy(bytes, COMMAND_ON_V2, sizeof(bytes));
		bytes[2] = flag;

		/* A good checksum: the flag alone decides. */
		const uint16_t crc =
			mavlink_checksum(&extra, 1, mavlink_checksum(bytes + 1, body - 1, 0xFFFF));

		bytes[body] = (uint8_t)crc;
		bytes[body + 1] = (uint8_t)(crc >> 8);
		mavlink_framer_init(&framer);
		zassert_equal(feed(bytes, sizeof(bytes), sizeof(bytes)), flag == 0 ? 1 : 0);
		zassert_equal(framer.stats.skipped_bytes, flag == 0 ? 0 : sizeof(bytes));
	}
}

ZTEST(mavlink_framer, test_idle_line_gives_up_a_length_that_never_comes)
{
	const uint8_t start[] = {0xFD, 255, 0, 0, 0, 1, 1, 0, 0, 0}; /* 267 bytes, 10 come */
	struct mavlink_frame frame;

	zassert_equal(feed(start, sizeof(start), sizeof(start)), 0);
	zassert_equal(feed(COMMAND_ON_V2, sizeof(COMMAND_ON_V2), 1), 0);
	zassert_true(mavlink_framer_pending(&framer));
	zassert_true(mavlink_framer_idle(&framer, &frame));
	zassert_mem_equal(frame.bytes, COMMAND_ON_V2, sizeof(COMMAND_ON_V2));
	zassert_false(mavlink_framer_pending(&framer));
}

ZTEST(mavlink_framer, test_idle_line_keeps_a_frame_that_is_still_coming)
{
	struct mavlink_frame frame;

	zassert_equal(feed(COMMAND_ON_V2, 20, 20), 0);
	zassert_false(mavlink_framer_idle(&framer, &frame));
	zassert_equal(feed(COMMAND_ON_V2 + 20, sizeof(COMMAND_ON_V2) - 20, 5), 1);
	zassert_equal(framer.stats.skipped_bytes, 0);
}

/*
 * Noise, false starts, cut frames and whole ones, byte by byte: a framer that gets them only when
 * it has as many as it wanted finds every frame with the same byte as one that gets each at once.
 */
static void check_wanted(const uint8_t *bytes, size_t count, bool opaque)
{
	static struct mavlink_framer patient;
	struct mavlink_frame frame;
	size_t given = 0;

	mavlink_framer_init(&framer);
	mavlink_framer_init(&patient);
	framer.opaque = opaque;
	patient.opaque = opaque;
	for (size_t come = 1; come <= count; come++) {
		const size_t wanted = mavlink_framer_wanted(&patient);

		zassert_true(wanted >= 1 && wanted <= MAVLINK_FRAME_MAX);
		feed(bytes + come - 1, 1, 1);
		if (come - given >= wanted) {
			zassert_equal(mavlink_framer_write(&patient, bytes + given, come - given),
			              come - given);
			given = come;
			while (mavlink_framer_next(&patient, &frame)) {
			}
		}
		zassert_equal(patient.stats.frames, framer.stats.frames, "byte %u",
		              (unsigned int)come);
	}
	zassert_true(framer.stats.frames > 0);
}

ZTEST(mavlink_framer, test_with_fewer_bytes_than_wanted_there_is_no_frame)
{
	static uint8_t stream[40 * (sizeof(HEARTBEAT_SIGNED) + sizeof(COMMAND_ON_V2) + 12)];
	uint32_t state = 362436069u;

	for (int round = 0; round < 20; round++) {
		size_t used = 0;

		for (int i = 0; i < 40; i++) {
			for (uint32_t k = random_next(&state) % 12; k > 0; k--) {
				const uint32_t r = random_next(&state);

				stream[used++] = r % 2 == 0 ? (uint8_t)(0xFD + (r >> 1 & 1))
				                            : (uint8_t)(r >> 8 & 3);
			}
			const uint32_t r = random_next(&state);
			const uint8_t *const frame = r % 3 == 0   ? COMMAND_ON_V1
			                             : r % 3 == 1 ? COMMAND_ON_V2
			                                          : HEARTBEAT_SIGNED;
			const size_t length = r % 3 == 0   ? sizeof(COMMAND_ON_V1)
			                      : r % 3 == 1 ? sizeof(COMMAND_ON_V2)
			                                   : sizeof(HEARTBEAT_SIGNED);
			/* whole, without what may be a signature, or somewhere */
			const size_t cuts[] = {length, length, length - MAVLINK_SIGNATURE_BYTES,
			                       (r >> 10) % length};
			const size_t cut = cuts[r >> 8 & 3];

			memcpy(stream + used, frame, cut);
			used += cut;
		}
		check_wanted(stream, used, false);
		check_wanted(stream, used, true);
	}
}

ZTEST(mavlink_framer, test_wanted_is_what_a_frame_has_left)
{
	/* MAVLink 2: flags with the third byte, the id with the tenth, then the claimed length. */
	zassert_equal(mavlink_framer_wanted(&framer), 8,
	              "the shortest of all: version 1, no payload");
	feed(COMMAND_ON_V2, 1, 1);
	zassert_equal(mavlink_framer_wanted(&framer), 2);
	feed(COMMAND_ON_V2 + 1, 2, 1);
	zassert_equal(mavlink_framer_wanted(&framer), 7);
	feed(COMMAND_ON_V2 + 3, 7, 1);
	zassert_equal(mavlink_framer_wanted(&framer), sizeof(COMMAND_ON_V2) - 10);
	zassert_equal(feed(COMMAND_ON_V2 + 10, sizeof(COMMAND_ON_V2) - 10, 1), 1);
	feed(COMMAND_ON_V1, 2, 1);
	zassert_equal(mavlink_framer_wanted(&framer), 4, "version 1: the id with the sixth");
	feed(COMMAND_ON_V1 + 2, 4, 1);
	zassert_equal(mavlink_framer_wanted(&framer), sizeof(COMMAND_ON_V1) - 6);
	feed(COMMAND_ON_V1 + 6, sizeof(COMMAND_ON_V1) - 6, 1);
	feed(HEARTBEAT_SIGNED, sizeof(HEARTBEAT_SIGNED), 1);
	zassert_equal(mavlink_framer_wanted(&framer), 1, "it may show that this was no signature");
}

ZTEST(mavlink_framer, test_there_is_room_for_a_frame_when_drained)
{
	static const uint8_t most[MAVLINK_FRAME_MAX];
	struct mavlink_frame frame;

	for (int i = 0; i < 5000; i++) {
		struct mavlink_framer probe = framer;
		const uint8_t byte = (uint8_t)(i % 7 == 0 ? 0xFD : i);

		zassert_equal(mavlink_framer_write(&probe, most, sizeof(most)), sizeof(most));
		zassert_equal(mavlink_framer_write(&framer, &byte, 1), 1);
		while (mavlink_framer_next(&framer, &frame)) {
		}
	}
}
