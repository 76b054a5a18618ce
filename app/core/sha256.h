/* SPDX-License-Identifier: Apache-2.0 */
/*
 * SHA-256, for signatures and for images of the firmware. 700 bytes of code and constants, which
 * both share; no table of its own in RAM.
 *
 * Context: the thread that owns it. Spec: FIPS 180-4.
 */
#ifndef PHAROS_CORE_SHA256_H
#define PHAROS_CORE_SHA256_H

#include <stddef.h>
#include <stdint.h>

#define SHA256_BYTES       32u
#define SHA256_BLOCK_BYTES 64u

struct sha256 {
	uint32_t state[8];
	uint32_t length; /* bytes so far */
	union {
		uint8_t bytes[SHA256_BLOCK_BYTES];
		uint32_t words[SHA256_BLOCK_BYTES / 4];
	} block; /* what is not yet in the state */
};

void sha256_begin(struct sha256 *self);

/* size: in all calls together below 512 MiB. */
void sha256_add(struct sha256 *self, const void *data, size_t size);

/* The digest, SHA256_BYTES: in self, until the next sha256_begin(). */
const uint8_t *sha256_end(struct sha256 *self);

/*
 * For sha256.c: a whole block into the state, its bytes are not needed any more. Weak: a board with
 * something faster (instructions, a peripheral) defines its own.
 */
void sha256_block(struct sha256 *self);

#endif
