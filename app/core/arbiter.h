/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Who may command the light, who does, and whether anyone is still there.
 *
 * The last command wins. A source with priority outranks the others for hold_us after each command
 * of its own. Use: arbiter_is_outranked before a command is carried out, arbiter_commit once it was
 * ACCEPTED. Who may command at all is security.h's to say, and has been asked before.
 *
 * Link loss: from the first sign of life of any commander on (arbiter_heard or arbiter_commit),
 * a silence of all of them for loss_us is a loss, told once; the next sign of life ends it.
 *
 * Context: the command thread. Spec: docs/architecture.md, promise 5.
 */
#ifndef PHAROS_CORE_ARBITER_H
#define PHAROS_CORE_ARBITER_H

#include "core/illuminator.h"

#include <stdbool.h>
#include <stdint.h>

/* NONE and FALLBACK are in command, but never ask. The numbers are those of LGT_SRC_PRIO. */
enum arbiter_source {
	ARBITER_SOURCE_NONE,
	ARBITER_SOURCE_MAVLINK,
	ARBITER_SOURCE_DRONECAN,
	ARBITER_SOURCE_IMC,
	ARBITER_SOURCE_SHELL,
	ARBITER_SOURCE_FALLBACK,
};
#define ARBITER_SOURCES 6

/* Bit of a source that can command, in LGT_SRC_EXCL. */
#define ARBITER_SOURCE_BIT(source) (1u << ((source)-ARBITER_SOURCE_MAVLINK))

/* priority: NONE or MAVLINK…SHELL. loss_us 0: never. */
struct arbiter_config {
	enum arbiter_source priority;
	enum illuminator_fallback fallback;
	int64_t hold_us;
	int64_t loss_us;
};

struct arbiter {
	struct arbiter_config config;
	enum arbiter_source commander; /* NONE at start */
	int64_t commanded_us;          /* when the commander last did */
	int64_t ranked_us;             /* when the priority source last did; -1: never */
	int64_t heard_us;              /* last sign of life; -1: none yet */
	bool lost;
};

/* config as above (asserted). */
void arbiter_init(struct arbiter *self, const struct arbiter_config *config);
void arbiter_configure(struct arbiter *self, const struct arbiter_config *config);

/*
 * Does the priority source's last command hold this one off for now? source MAVLINK…SHELL
 * (asserted), here and below. now_us 0…TIME_MAX_US.
 */
bool arbiter_is_outranked(const struct arbiter *self, int64_t now_us, enum arbiter_source source);

/* Its command was ACCEPTED: source is in command now. */
void arbiter_commit(struct arbiter *self, int64_t now_us, enum arbiter_source source);

/* A sign of life that is no command: a heartbeat of a ground station, a shell line, … */
void arbiter_heard(struct arbiter *self, int64_t now_us, enum arbiter_source source);

/*
 * True once per loss: FALLBACK is in command now (unless it is KEEP), and the caller gives the
 * illuminator config.fallback.
 */
bool arbiter_advance(struct arbiter *self, int64_t now_us);

/* When arbiter_advance may next return true; TIME_NEVER_US: not without a sign of life. */
int64_t arbiter_deadline_us(const struct arbiter *self);

/* For people, constant and never NULL: "none", "mavlink", … */
const char *arbiter_source_name(enum arbiter_source source);

#endif
