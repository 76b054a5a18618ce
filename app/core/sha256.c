/* SPDX-License-Identifier: Apache-2.0 */
#include "core/sha256.h"

#include <string.h>

#define ROUNDS    64u
#define WORDS     16u
#define LENGTH_AT (SHA256_BLOCK_BYTES - 8u)

/* The first 32 bits of the fractions of the square roots of 2, 3, 5 … and of the cube roots. */
static const uint32_t initial[8] = {
	0x6A09E667, 0xBB67AE85, 0x3C6EF372, 0xA54FF53A,
	0x510E527F, 0x9B05688C, 0x1F83D9AB, 0x5BE0CD19,
};
static const uint32_t round_constants[ROUNDS] = {
	0x428A2F98, 0x71374491, 0xB5C0FBCF, 0xE9B5DBA5, 0x3956C25B, 0x59F111F1, 0x923F82A4,
	0xAB1C5ED5, 0xD807AA98, 0x12835B01, 0x243185BE, 0x550C7DC3, 0x72BE5D74, 0x80DEB1FE,
	0x9BDC06A7, 0xC19BF174, 0xE49B69C1, 0xEFBE4786, 0x0FC19DC6, 0x240CA1CC, 0x2DE92C6F,
	0x4A7484AA, 0x5CB0A9DC, 0x76F988DA, 0x983E5152, 0xA831C66D, 0xB00327C8, 0xBF597FC7,
	0xC6E00BF3, 0xD5A79147, 0x06CA6351, 0x14292967, 0x27B70A85, 0x2E1B2138, 0x4D2C6DFC,
	0x53380D13, 0x650A7354, 0x766A0ABB, 0x81C2C92E, 0x92722C85, 0xA2BFE8A1, 0xA81A664B,
	0xC24B8B70, 0xC76C51A3, 0xD192E819, 0xD6990624, 0xF40E3585, 0x106AA070, 0x19A4C116,
	0x1E376C08, 0x2748774C, 0x34B0BCB5, 0x391C0CB3, 0x4ED8AA4A, 0x5B9CCA4F, 0x682E6FF3,
	0x748F82EE, 0x78A5636F, 0x84C87814, 0x8CC70208, 0x90BEFFFA, 0xA4506CEB, 0xBEF9A3F7,
	0xC67178F2,
};

static uint32_t rotate(uint32_t word, unsigned int by)
{
	return word >> by | word << (32u - by);
}

static uint32_t word_at(const uint8_t *at)
{
	return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

static void put_word(uint8_t *at, uint32_t word)
{
	at[0] = (uint8_t)(word >> 24);
	at[1] = (uint8_t)(word >> 16);
	at[2] = (uint8_t)(word >> 8);
	at[3] = (uint8_t)word;
}

/* The schedule's word of a round; w keeps the latest 16. */
static uint32_t schedule(uint32_t w[WORDS], uint32_t round)
{
	uint32_t *const word = &w[round % WORDS];

	if (round >= WORDS) {
		const uint32_t a = w[(round + 1) % WORDS];
		const uint32_t b = w[(round + 14) % WORDS];

		*word += w[(round + 9) % WORDS] + (rotate(a, 7) ^ rotate(a, 18) ^ a >> 3) +
		         (rotate(b, 17) ^ rotate(b, 19) ^ b >> 10);
	}
	return *word;
}

/* The block becomes the schedule. */
__attribute__((weak)) void sha256_block(struct sha256 *self)
{
	uint32_t *const w = self->block.words;
	const uint32_t *const s = self->state;
	uint32_t a = s[0], b = s[1], c = s[2], d = s[3], e = s[4], f = s[5], g = s[6], h = s[7];

	for (uint32_t i = 0; i < WORDS; i++) {
		w[i] = word_at(&self->block.bytes[i * 4]);
	}
	for (uint32_t i = 0; i < ROUNDS; i++) {
		const uint32_t one = h + (rotate(e, 6) ^ rotate(e, 11) ^ rotate(e, 25)) +
		                     ((e & f) ^ (~e & g)) + round_constants[i] + schedule(w, i);
		const uint32_t two = (rotate(a, 2) ^ rotate(a, 13) ^ rotate(a, 22)) +
		                     ((a & b) ^ (a & c) ^ (b & c));

		h = g;
		g = f;
		f = e;
		e = d + one;
		d = c;
		c = b;
		b = a;
		a = one + two;
	}

	const uint32_t sums[8] = {a, b, c, d, e, f, g, h};

	for (uint32_t i = 0; i < 8; i++) {
		self->state[i] += sums[i];
	}
}

void sha256_begin(struct sha256 *self)
{
	memcpy(self->state, initial, sizeof(initial));
	self->length = 0;
}

void sha256_add(struct sha256 *self, const void *data, size_t size)
{
	const uint8_t *at = data;

	while (size > 0) {
		const size_t used = self->length % SHA256_BLOCK_BYTES;
		const size_t room = SHA256_BLOCK_BYTES - used;
		const size_t count = size < room ? size : room;

		memcpy(&self->block.bytes[used], at, count);
		self->length += (uint32_t)count;
		at += count;
		size -= count;
		if (count == room) {
			sha256_block(self);
		}
	}
}

const uint8_t *sha256_end(struct sha256 *self)
{
	uint8_t *const bytes = self->block.bytes;
	const uint32_t bits = self->length * 8;
	size_t used = self->length % SHA256_BLOCK_BYTES;

	bytes[used++] = 0x80;
	if (used > LENGTH_AT) {
		memset(&bytes[used], 0, SHA256_BLOCK_BYTES - used);
		sha256_block(self);
		used = 0;
	}
	memset(&bytes[used], 0, SHA256_BLOCK_BYTES - used);
	put_word(&bytes[SHA256_BLOCK_BYTES - 4], bits);
	sha256_block(self);
	for (uint32_t i = 0; i < 8; i++) {
		put_word(&bytes[i * 4], self->state[i]);
	}
	return bytes;
}
