/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Power channels: what is switched on, what shall be switched when, and what comes on at the next
 * start.
 *
 * A command is carried out at once. Schedules are relative to the command and kept as absolute
 * times, so that they are exact whenever they fall due: one to switch on and one to switch off per
 * channel, independent of each other and of commands; a new one replaces the old. When both fall on
 * the same instant, off is last. Restart is off at once and on POWER_RESTART_US later, unless the
 * channel is commanded or switched by a schedule in between.
 *
 * Context: the thread that owns it, no locks inside. Spec: IMC 309 PowerChannelControl.
 */
#ifndef PHAROS_CORE_POWER_H
#define PHAROS_CORE_POWER_H

#include "core/limits.h"

#include <stdbool.h>
#include <stdint.h>

/* Wire values of IMC. */
enum power_op {
	POWER_OP_OFF,
	POWER_OP_ON,
	POWER_OP_TOGGLE,
	POWER_OP_SCHEDULE_ON,
	POWER_OP_SCHEDULE_OFF,
	POWER_OP_RESET_SCHEDULES,
	POWER_OP_SAVE,
	POWER_OP_RESTART,
};
#define POWER_OPS 8u

/* When something is due; TIME_NEVER_US: nothing is. */
struct power_timers {
	int64_t restart_us;
	int64_t on_us;
	int64_t off_us;
};

/* Bit n of a mask is channel n. */
struct power {
	uint32_t present;
	uint32_t on;    /* as commanded */
	uint32_t saved; /* what is on after the next start */
	bool down;      /* the whole device is: nothing is on, whatever `on` says */
	struct power_timers timers[POWER_CHANNELS_MAX];
	int64_t due_us; /* the first of all timers */
};

/* present, on: masks within POWER_CHANNELS_MAX (asserted); on is what was saved, or the default. */
void power_init(struct power *self, uint32_t present, uint32_t on);

/*
 * delay_us: of the two SCHEDULE ops, 0…POWER_SCHEDULE_MAX_US; else not looked at. False: no such
 * channel, no such op or a delay out of range; nothing changed.
 */
bool power_command(struct power *self, int64_t now_us, uint32_t channel, uint32_t op,
                   int64_t delay_us);

/* Does what has fallen due, in the order in which it did. */
void power_advance(struct power *self, int64_t now_us);

/* When power_advance() next has something to do; TIME_NEVER_US: not without a command. */
int64_t power_deadline_us(const struct power *self);

/* The channels that have power. */
uint32_t power_outputs(const struct power *self);

#endif
