/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The staged power-down of the whole device: announced with the time that remains, once a second
 * and when it is over; can be aborted until then. Down, it still listens, and comes up when told
 * to. Going down and coming up can be scheduled, independently; a new schedule replaces the old.
 *
 * Context: the thread that owns it, no locks inside. Spec: IMC 308 PowerOperation.
 */
#ifndef PHAROS_CORE_SHUTDOWN_H
#define PHAROS_CORE_SHUTDOWN_H

#include "core/limits.h"

#include <stdbool.h>
#include <stdint.h>

/* Wire values of IMC. The two IN_PROGRESS are what a device tells; as commands they do nothing. */
enum shutdown_op {
	SHUTDOWN_OP_DOWN,
	SHUTDOWN_OP_DOWN_IN_PROGRESS,
	SHUTDOWN_OP_DOWN_ABORTED,
	SHUTDOWN_OP_SCHEDULE_DOWN,
	SHUTDOWN_OP_UP,
	SHUTDOWN_OP_UP_IN_PROGRESS,
	SHUTDOWN_OP_SCHEDULE_UP,
};
#define SHUTDOWN_OPS 7u

enum shutdown_state {
	SHUTDOWN_STATE_UP,
	SHUTDOWN_STATE_GOING_DOWN,
	SHUTDOWN_STATE_DOWN,
};

/* To be told to everyone: DOWN_IN_PROGRESS, DOWN_ABORTED or UP_IN_PROGRESS. */
struct shutdown_notice {
	enum shutdown_op op;
	int64_t remain_us;
};

struct shutdown {
	enum shutdown_state state;
	bool noticed; /* there is a notice to be fetched */
	struct shutdown_notice notice;
	int64_t grace_us;    /* of a command that names none, and of a scheduled one */
	int64_t down_us;     /* GOING_DOWN: when it will be down */
	int64_t announce_us; /* GOING_DOWN: when to tell next */
	int64_t schedule_down_us;
	int64_t schedule_up_us;
};

/* Up. grace_us 0…SHUTDOWN_GRACE_MAX_US (asserted). */
void shutdown_init(struct shutdown *self, int64_t grace_us);

/*
 * time_us of DOWN: how long until it is down, 1…SHUTDOWN_GRACE_MAX_US, 0: grace_us. Of the two
 * SCHEDULE ops: how long from now, 0…POWER_SCHEDULE_MAX_US. Else not looked at. DOWN while going
 * down changes nothing. DOWN_ABORTED ends a power-down that is going on or scheduled. UP ends one
 * that is going on. False: no such op or a time out of range; nothing changed.
 */
bool shutdown_command(struct shutdown *self, int64_t now_us, uint32_t op, int64_t time_us);

/* Ends a power-down that goes on, and every schedule: of who may not have them any more. */
void shutdown_lapse(struct shutdown *self);

/*
 * Does what has fallen due. True: *notice is to be told; call again, there may be another. Call
 * after shutdown_command() and at the deadline.
 */
bool shutdown_advance(struct shutdown *self, int64_t now_us, struct shutdown_notice *notice);

int64_t shutdown_deadline_us(const struct shutdown *self);

#endif
