/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When a value that may change all the time is worth a write to flash: once it has stood for a
 * second, and half a minute after its first change at the latest.
 *
 *   changes   x x xx x                     x x x x x x x x x x x x x x x x x x x x x
 *   writes          |--1 s--W              |----------------30 s----------------W
 *
 * Twenty writes may follow each other as fast as that; beyond them one is due every 36 seconds. So
 * no hour has more than 120, and a year of them wears out no flash.
 *
 * Context: the thread that owns it, or under its lock.
 */
#ifndef PHAROS_CORE_SETTLE_H
#define PHAROS_CORE_SETTLE_H

#include "core/limits.h"

#include <stdint.h>

#define SETTLE_QUIET_US  (1 * (int64_t)US_PER_S)
#define SETTLE_LATEST_US (30 * (int64_t)US_PER_S)
#define SETTLE_BURST     20
#define SETTLE_REFILL_US (36 * (int64_t)US_PER_S)

_Static_assert(SETTLE_BURST + 3600 * (int64_t)US_PER_S / SETTLE_REFILL_US == 120,
               "writes in an hour, at most");

/* All zero: nothing waits, nothing was written. */
struct settle {
	int64_t due_us;    /* 0: nothing waits */
	int64_t latest_us; /* of what waits */
	int64_t spent_us;  /* until then the writes so far have used up their time */
};

/* The value has changed. */
void settle_change(struct settle *self, int64_t now_us);

/* When to write it; TIME_NEVER_US: nothing waits. */
int64_t settle_deadline_us(const struct settle *self);

/* It is written now, for itself. */
void settle_write(struct settle *self, int64_t now_us);

/* It is written now with something else, which costs no write; or need not be. */
void settle_drop(struct settle *self);

#endif
