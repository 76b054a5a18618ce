/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What survives a power cut: a log of what was accepted, in the order in which it was. Sans-IO.
 *
 *   accepted   p1  p2+p3  light  light  p4 …
 *   states     S1    S2                 S3        each after everything before it
 *   slots      0:S1  1:S2               0:S3      the older one is overwritten
 *
 * A record holds the whole state, so what was accepted together is in it together, and whatever is
 * left after a cut is the state after some prefix of what was accepted: a slot is written whole or
 * not at all (a value of Zephyr's settings is), and the other slot holds the record before. The
 * newest record that reads whole counts.
 *
 * The light settles (settle.h); all else is due at once and takes the light along as it is, so that
 * the order is kept.
 *
 * A record, integers little-endian:
 *
 *	CRC-32/ISO-HDLC of all that follows (4) | sequence (4) | version 1 (1) | what is there (1) |
 *	light: brightness ppm, period us, duty ppm (4 each), mode, enable (1 each) |
 *	power channels (1) | signing (40) |
 *	parameters that are not at their default: key of the name (2), value (1…5)
 *
 * The key is FNV-1a in 32 bits, folded to 16; the value is zigzag coded, 7 bits a byte, the lowest
 * first. A name that is not in the table (any more) is skipped; those of version 0.1, which had
 * their unit at the end, still count, and a value beyond a range that was wider then becomes the
 * range's end. The next record has today's names.
 *
 * Context: one owner, or under a lock.
 */
#ifndef PHAROS_CORE_STORE_H
#define PHAROS_CORE_STORE_H

#include "core/illuminator.h"
#include "core/params.h"
#include "core/settle.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STORE_SLOTS         2u
#define STORE_SIGNING_BYTES 40

/* After a write that failed. */
#define STORE_RETRY_US (30 * (int64_t)US_PER_S)

/* The longest value of a parameter. */
#define STORE_ZIGZAG(value) ((value) < 0 ? -2 * (int64_t)(value)-1 : 2 * (int64_t)(value))
#define STORE_VALUE_BYTES(zigzag)                                                                  \
	(1 + ((zigzag) >= 1 << 7) + ((zigzag) >= 1 << 14) + ((zigzag) >= 1 << 21) +                \
	 ((zigzag) >= 1 << 28))
#define STORE_PARAM_BYTES(name, group, unit, decimals, min, max, fallback, flags, meaning)         \
	+(2 + STORE_VALUE_BYTES(STORE_ZIGZAG(min) > STORE_ZIGZAG(max) ? STORE_ZIGZAG(min)          \
	                                                              : STORE_ZIGZAG(max)))
enum {
	STORE_RECORD_MIN = 10,
	STORE_RECORD_MAX =
		STORE_RECORD_MIN + 14 + 1 + STORE_SIGNING_BYTES PARAMS_TABLE(STORE_PARAM_BYTES)
};

/* params is always there; power without has_power: what holds as long as nothing is stored, no
 * change. signing: opaque.
 */
struct store_state {
	struct params params;
	bool has_light;
	bool has_power;
	bool has_signing;
	uint8_t power;
	struct illuminator_settings light;
	uint8_t signing[STORE_SIGNING_BYTES];
};

struct store {
	struct store_state state; /* as accepted */
	struct settle light;      /* when it is due */
	int64_t due_us;           /* what does not settle; TIME_NEVER_US: nothing of it waits */
	uint32_t sequence;        /* of the newest record; 0: there is none */
	uint8_t slot;             /* that the next one goes to */
};

/* Nothing is stored, everything at its default. */
void store_init(struct store *self);

/*
 * Loading: each slot's content is offered, in any order. True: it reads whole; the newest is the
 * state now, unchecked until store_check().
 */
bool store_offer(struct store *self, uint8_t slot, const uint8_t *record, size_t length);

/*
 * Loading, when no slot reads whole: the limits of heat that can still be read in this one take
 * effect where they are lower.
 */
void store_salvage(struct store *self, const uint8_t *record, size_t length);

/* The parameter that is called so, or was in version 0.1; PARAM_COUNT: none. */
uint32_t store_find(const char *name);

/* What version 0.1 called the parameter; NULL: as today. */
const char *store_former_name(uint32_t index);

/* Loading: a parameter's value as it was stored (asserted to be one). */
void store_put(struct store *self, uint32_t index, int32_t value);

/* Loading, last: what no longer fits the table is mended (params_load). Returns what was. */
struct param_set store_check(struct store *self);

/* What is accepted, each call together and in this order. What is stored already costs nothing. */
void store_params(struct store *self, int64_t now_us, const struct params *params,
                  const struct param_set *changed);
void store_light(struct store *self, int64_t now_us, const struct illuminator_settings *light);
void store_power(struct store *self, int64_t now_us, uint8_t mask);
void store_signing(struct store *self, int64_t now_us, const uint8_t record[STORE_SIGNING_BYTES]);

/* All of it is to be written, changed or not. */
void store_touch(struct store *self, int64_t now_us);

/* When to write; TIME_NEVER_US: nothing waits. */
int64_t store_deadline_us(const struct store *self);

/*
 * If a write is due: puts it into record (STORE_RECORD_MAX bytes) and returns its length; it goes
 * to the returned slot. 0: nothing is due. store_done() follows; what is accepted between them is
 * for the next record.
 */
size_t store_begin(struct store *self, int64_t now_us, uint8_t *record, uint8_t *slot);

/* The record is in its slot, or not. */
void store_done(struct store *self, int64_t now_us, bool stored);

#endif
