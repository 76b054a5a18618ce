/* SPDX-License-Identifier: Apache-2.0 */
/* Messages and digests are NIST's: FIPS 180-4's examples and SHA256ShortMsg of the CAVP. */
#include <string.h>

#include <zephyr/sys/util.h>
#include <zephyr/ztest.h>

#include "core/sha256.h"

ZTEST_SUITE(sha256, NULL, NULL, NULL, NULL, NULL);

/* In pieces of that size. */
static const char *hex_of(const char *message, size_t length, size_t piece)
{
	static char hex[2 * SHA256_BYTES + 1];
	struct sha256 sum;

	sha256_begin(&sum);
	for (size_t at = 0; at < length; at += piece) {
		sha256_add(&sum, message + at, MIN(piece, length - at));
	}

	const uint8_t *const digest = sha256_end(&sum);

	for (size_t i = 0; i < SHA256_BYTES; i++) {
		hex[2 * i] = "0123456789abcdef"[digest[i] >> 4];
		hex[2 * i + 1] = "0123456789abcdef"[digest[i] & 0xF];
	}
	return hex;
}

ZTEST(sha256, test_nothing)
{
	zassert_equal(strcmp(hex_of("", 0, 1),
	                     "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"),
	              0);
}

ZTEST(sha256, test_one_block)
{
	zassert_equal(strcmp(hex_of("abc", 3, 3),
	                     "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"),
	              0);
	zassert_equal(strcmp(hex_of("\xbd", 1, 1),
	                     "68325720aabd7c82f30f554b313d0570c95accbb7dc4b5aae11204c08ffe732b"),
	              0);
}

/* The length does not fit behind it. */
ZTEST(sha256, test_two_blocks_in_any_pieces)
{
	static const char message[] = "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq";

	for (size_t piece = 1; piece < sizeof(message); piece++) {
		zassert_equal(
			strcmp(hex_of(message, strlen(message), piece),
		               "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"),
			0);
	}
}

/* 112 bytes. */
ZTEST(sha256, test_longer)
{
	static const char message[] = "abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmn"
				      "hijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu";

	zassert_equal(strcmp(hex_of(message, strlen(message), 64),
	                     "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1"),
	              0);
}

ZTEST(sha256, test_a_million)
{
	char thousand[1000];
	struct sha256 sum;
	static const uint8_t expected[SHA256_BYTES] = {
		0xcd, 0xc7, 0x6e, 0x5c, 0x99, 0x14, 0xfb, 0x92, 0x81, 0xa1, 0xc7,
		0xe2, 0x84, 0xd7, 0x3e, 0x67, 0xf1, 0x80, 0x9a, 0x48, 0xa4, 0x97,
		0x20, 0x0e, 0x04, 0x6d, 0x39, 0xcc, 0xc7, 0x11, 0x2c, 0xd0,
	};

	memset(thousand, 'a', sizeof(thousand));
	sha256_begin(&sum);
	for (uint32_t i = 0; i < 1000; i++) {
		sha256_add(&sum, thousand, sizeof(thousand));
	}
	zassert_mem_equal(sha256_end(&sum), expected, sizeof(expected));
}
