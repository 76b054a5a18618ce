/* SPDX-License-Identifier: Apache-2.0 */
/* Streams of golden packets, cut and disturbed: what arrived whole is found. */
#include "proto/imc/stream.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "vectors/imc_vectors.h"

#define VECTORS ARRAY_SIZE(imc_vectors)

static struct imc_stream stream;
static struct imc_stream_packet found;
static uint8_t bytes[65536];
static size_t length;
static size_t expected; /* the vector that comes next */
static bool big;        /* and its byte order: little and big take turns */

static void before(void *fixture)
{
	imc_stream_init(&stream);
	length = 0;
	expected = 0;
	big = false;
}

ZTEST_SUITE(imc_stream, NULL, NULL, before, NULL, NULL);

static void append(const void *data, size_t size)
{
	zassert_true(length + size <= sizeof(bytes));
	memcpy(bytes + length, data, size);
	length += size;
}

/* Small differences from run to run would be hard to repeat: the same numbers every time. */
static uint8_t noise(uint32_t *state)
{
	*state = *state * 1664525u + 1013904223u;
	return (uint8_t)(*state >> 24);
}

/* All vectors, little and big in turns, each behind so many bytes of noise. */
static void append_vectors(size_t first, size_t count, size_t noises)
{
	uint32_t state = 1;

	for (size_t i = first; i < first + count; i++) {
		for (size_t k = 0; k < noises; k++) {
			const uint8_t byte = noise(&state);

			append(&byte, 1);
		}
		append((i - first) % 2 == 0 ? imc_vectors[i].little : imc_vectors[i].big,
		       imc_vectors[i].length);
	}
}

static void check(void)
{
	const struct imc_vector *const vector = &imc_vectors[expected];

	zassert_true(expected < VECTORS, "one too many");
	zassert_equal(found.length, vector->length, "%s", vector->name);
	zassert_mem_equal(found.bytes, big ? vector->big : vector->little, vector->length, "%s",
	                  vector->name);
	expected++;
	big = !big;
}

static void take_all(void)
{
	while (imc_stream_next(&stream, &found)) {
		check();
	}
}

static void feed(const uint8_t *from, size_t size)
{
	for (size_t used = 0; used < size;) {
		const size_t taken = imc_stream_write(&stream, from + used, size - used);

		zassert_true(taken > 0, "it always goes on");
		used += taken;
		take_all();
	}
}

static void go_idle(void)
{
	while (imc_stream_idle(&stream, &found)) {
		check();
		take_all();
	}
}

ZTEST(imc_stream, test_all_vectors_in_one_write)
{
	append_vectors(0, VECTORS, 0);
	feed(bytes, length);
	zassert_equal(expected, VECTORS);
	zassert_equal(stream.stats.packets, VECTORS);
	zassert_equal(stream.stats.skipped_bytes, 0);
	zassert_false(imc_stream_pending(&stream));
}

ZTEST(imc_stream, test_all_vectors_byte_by_byte)
{
	append_vectors(0, VECTORS, 0);
	for (size_t i = 0; i < length; i++) {
		feed(bytes + i, 1);
	}
	zassert_equal(expected, VECTORS);
	zassert_equal(stream.stats.skipped_bytes, 0);
}

ZTEST(imc_stream, test_two_chunks_cut_at_every_byte)
{
	append_vectors(0, VECTORS, 0);
	for (size_t cut = 0; cut <= length; cut++) {
		imc_stream_init(&stream);
		expected = 0;
		big = false;
		feed(bytes, cut);
		feed(bytes + cut, length - cut);
		zassert_equal(expected, VECTORS, "cut at %zu", cut);
	}
}

ZTEST(imc_stream, test_noise_between_packets_costs_none)
{
	static const size_t amounts[] = {1, 2, 7, 19, 20, 21, 100};

	for (size_t i = 0; i < ARRAY_SIZE(amounts); i++) {
		before(NULL);
		append_vectors(0, VECTORS, amounts[i]);
		feed(bytes, length);
		go_idle();
		zassert_equal(expected, VECTORS, "%zu bytes of noise", amounts[i]);
		zassert_equal(stream.stats.skipped_bytes, VECTORS * amounts[i]);
	}
}

/* The beginning of a packet is lost at every byte: the next one is found. */
ZTEST(imc_stream, test_what_follows_a_cut_off_packet_is_found)
{
	for (size_t i = 0; i + 1 < VECTORS; i++) {
		const struct imc_vector *const cut = &imc_vectors[i];
		const size_t step = cut->length > 300 ? 41 : 1;

		for (size_t from = 1; from < cut->length; from += step) {
			before(NULL);
			append(cut->little + from, cut->length - from);
			append(imc_vectors[i + 1].little, imc_vectors[i + 1].length);
			expected = i + 1;
			feed(bytes, length);
			go_idle();
			zassert_equal(expected, i + 2, "%s from byte %zu", cut->name, from);
		}
	}
}

/* Its end is lost at every byte: the next ones are found, once enough has come or it is quiet. */
ZTEST(imc_stream, test_what_follows_an_unfinished_packet_is_found)
{
	for (size_t i = 0; i + 1 < VECTORS; i++) {
		const struct imc_vector *const cut = &imc_vectors[i];
		const size_t step = cut->length > 300 ? 41 : 1;

		for (size_t until = 0; until < cut->length; until += step) {
			before(NULL);
			append(cut->big, until);
			append(imc_vectors[i + 1].little, imc_vectors[i + 1].length);
			expected = i + 1;
			feed(bytes, length);
			go_idle();
			zassert_equal(expected, i + 2, "%s until byte %zu", cut->name, until);
		}
	}
}

/* IMC facts: "a false sync claiming 65535 bytes must not stall the link". Not even for an idle. */
ZTEST(imc_stream, test_a_claim_beyond_the_cap_is_not_waited_for)
{
	static const uint8_t claim[IMC_HEADER_SIZE] = {0x54, 0xFE, 0x3A, 0x01, 0xFF, 0xFF};
	static const uint8_t claim_big[IMC_HEADER_SIZE] = {0xFE, 0x54, 0x01, 0x3A, 0xFF, 0xFF};

	append(claim, sizeof(claim));
	append(imc_vectors[0].little, imc_vectors[0].length);
	append(claim_big, sizeof(claim_big));
	append(imc_vectors[1].big, imc_vectors[1].length);
	feed(bytes, length);
	zassert_equal(expected, 2);
	zassert_equal(stream.stats.too_long, 2);
	zassert_equal(stream.stats.skipped_bytes, 2 * IMC_HEADER_SIZE);
}

/* A claim within the cap is waited for; a busy line brings that many bytes, a quiet one is idle. */
ZTEST(imc_stream, test_a_claim_within_the_cap_costs_nothing)
{
	uint8_t claim[IMC_HEADER_SIZE] = {0x54, 0xFE, 0x3A, 0x01};

	claim[4] = (uint8_t)IMC_PAYLOAD_MAX;
	claim[5] = (uint8_t)(IMC_PAYLOAD_MAX >> 8);
	append(claim, sizeof(claim));
	append(imc_vectors[0].little, imc_vectors[0].length);
	feed(bytes, length);
	zassert_equal(expected, 0, "it may still come");
	zassert_true(imc_stream_pending(&stream));
	go_idle();
	zassert_equal(expected, 1);

	before(NULL);
	append(claim, sizeof(claim));
	append_vectors(0, VECTORS, 0);
	feed(bytes, length);
	zassert_equal(expected, VECTORS, "no silence, and nothing lost");
	zassert_equal(stream.stats.checksum_errors, 1);
}

/* What a message of somebody else carries is not searched for packets. */
ZTEST(imc_stream, test_a_packet_inside_an_unknown_one_is_not_taken)
{
	uint8_t outer[IMC_HEADER_SIZE] = {0x54, 0xFE, 0xE7, 0xFD}; /* id 64999 */
	const struct imc_vector *const inner = &imc_vectors[0];
	uint8_t crc[IMC_FOOTER_SIZE];

	outer[4] = (uint8_t)inner->length;
	append(outer, sizeof(outer));
	append(inner->little, inner->length);
	crc[0] = (uint8_t)imc_checksum(bytes, length);
	crc[1] = (uint8_t)(imc_checksum(bytes, length) >> 8);
	append(crc, sizeof(crc));
	zassert_equal(imc_stream_write(&stream, bytes, length), length);
	zassert_true(imc_stream_next(&stream, &found));
	zassert_equal(found.length, length);
	zassert_false(imc_stream_next(&stream, &found));
}

/* Given bytes only when it has as many as it wanted, it finds each packet with its last byte. */
ZTEST(imc_stream, test_with_fewer_bytes_than_wanted_there_is_no_packet)
{
	static struct imc_stream patient;
	struct imc_stream_packet packet;

	for (size_t noises = 0; noises < 30; noises++) {
		size_t given = 0;

		before(NULL);
		imc_stream_init(&patient);
		append_vectors(0, VECTORS, noises);
		for (size_t come = 1; come <= length; come++) {
			const size_t wanted = imc_stream_wanted(&patient);

			zassert_true(wanted >= 1 && wanted <= IMC_PACKET_MAX);
			feed(bytes + come - 1, 1);
			while (come - given >= wanted && given < come) {
				given += imc_stream_write(&patient, bytes + given, come - given);
				while (imc_stream_next(&patient, &packet)) {
				}
			}
			zassert_equal(patient.stats.packets, stream.stats.packets, "byte %zu",
			              come);
		}
		zassert_true(expected > 0);
	}
}

ZTEST(imc_stream, test_wanted_is_what_a_packet_has_left)
{
	const struct imc_vector *const vector = &imc_vectors[0];

	zassert_equal(imc_stream_wanted(&stream), 22, "header and footer");
	feed(vector->little, 19);
	zassert_equal(imc_stream_wanted(&stream), 3);
	feed(vector->little + 19, 1);
	zassert_equal(imc_stream_wanted(&stream), vector->length - 20u);
}

ZTEST(imc_stream, test_idle_without_a_packet_changes_nothing)
{
	const struct imc_vector *const vector = &imc_vectors[0];

	feed(vector->little, vector->length - 1);
	zassert_false(imc_stream_idle(&stream, &found));
	zassert_true(imc_stream_pending(&stream));
	feed(vector->little + vector->length - 1, 1);
	zassert_equal(expected, 1);
}
