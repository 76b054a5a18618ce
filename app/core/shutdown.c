/* SPDX-License-Identifier: Apache-2.0 */
#include "core/shutdown.h"

#include "core/assert.h"

#define ANNOUNCE_PERIOD_US US_PER_S

void shutdown_init(struct shutdown *self, int64_t grace_us)
{
	PHAROS_ASSERT(grace_us >= 0 && grace_us <= SHUTDOWN_GRACE_MAX_US);
	*self = (struct shutdown){
		.grace_us = grace_us,
		.schedule_down_us = TIME_NEVER_US,
		.schedule_up_us = TIME_NEVER_US,
	};
}

static void tell(struct shutdown *self, enum shutdown_op op, int64_t remain_us)
{
	self->noticed = true;
	self->notice = (struct shutdown_notice){.op = op, .remain_us = remain_us};
}

static void go_down(struct shutdown *self, int64_t now_us, int64_t time_us)
{
	if (self->state == SHUTDOWN_STATE_UP) {
		self->state = SHUTDOWN_STATE_GOING_DOWN;
		self->down_us = now_us + time_us;
		self->announce_us = now_us;
	}
}

static void abort_down(struct shutdown *self)
{
	if (self->state == SHUTDOWN_STATE_GOING_DOWN) {
		self->state = SHUTDOWN_STATE_UP;
		tell(self, SHUTDOWN_OP_DOWN_ABORTED, 0);
	}
}

static void come_up(struct shutdown *self)
{
	if (self->state == SHUTDOWN_STATE_DOWN) {
		self->state = SHUTDOWN_STATE_UP;
		tell(self, SHUTDOWN_OP_UP_IN_PROGRESS, 0);
	} else {
		abort_down(self);
	}
}

static bool time_valid(uint32_t op, int64_t time_us)
{
	if (op == SHUTDOWN_OP_DOWN) {
		return time_us >= 0 && time_us <= SHUTDOWN_GRACE_MAX_US;
	}
	if (op == SHUTDOWN_OP_SCHEDULE_DOWN || op == SHUTDOWN_OP_SCHEDULE_UP) {
		return time_us >= 0 && time_us <= POWER_SCHEDULE_MAX_US;
	}
	return op < SHUTDOWN_OPS;
}

bool shutdown_command(struct shutdown *self, int64_t now_us, uint32_t op, int64_t time_us)
{
	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	if (!time_valid(op, time_us)) {
		return false;
	}
	switch ((enum shutdown_op)op) {
	case SHUTDOWN_OP_DOWN:
		go_down(self, now_us, time_us == 0 ? self->grace_us : time_us);
		break;
	case SHUTDOWN_OP_DOWN_ABORTED:
		self->schedule_down_us = TIME_NEVER_US;
		abort_down(self);
		break;
	case SHUTDOWN_OP_SCHEDULE_DOWN:
		self->schedule_down_us = now_us + time_us;
		break;
	case SHUTDOWN_OP_UP:
		come_up(self);
		break;
	case SHUTDOWN_OP_SCHEDULE_UP:
		self->schedule_up_us = now_us + time_us;
		break;
	case SHUTDOWN_OP_DOWN_IN_PROGRESS:
	case SHUTDOWN_OP_UP_IN_PROGRESS:
		break;
	}
	return true;
}

/* GOING_DOWN: tells, or is down. Announcements fall on whole seconds before the end. */
static void count_down(struct shutdown *self, int64_t now_us)
{
	const int64_t remain_us = self->down_us - now_us;

	if (remain_us <= 0) {
		self->state = SHUTDOWN_STATE_DOWN;
		tell(self, SHUTDOWN_OP_DOWN_IN_PROGRESS, 0);
		return;
	}
	const int64_t rest_us = remain_us % ANNOUNCE_PERIOD_US;

	self->announce_us = now_us + (rest_us == 0 ? ANNOUNCE_PERIOD_US : rest_us);
	tell(self, SHUTDOWN_OP_DOWN_IN_PROGRESS, remain_us);
}

void shutdown_lapse(struct shutdown *self)
{
	self->schedule_down_us = TIME_NEVER_US;
	self->schedule_up_us = TIME_NEVER_US;
	abort_down(self);
}

bool shutdown_advance(struct shutdown *self, int64_t now_us, struct shutdown_notice *notice)
{
	if (!self->noticed && self->schedule_down_us <= now_us) {
		self->schedule_down_us = TIME_NEVER_US;
		go_down(self, now_us, self->grace_us);
	}
	if (!self->noticed && self->schedule_up_us <= now_us) {
		self->schedule_up_us = TIME_NEVER_US;
		come_up(self);
	}
	if (!self->noticed && self->state == SHUTDOWN_STATE_GOING_DOWN &&
	    self->announce_us <= now_us) {
		count_down(self, now_us);
	}
	if (!self->noticed) {
		return false;
	}
	self->noticed = false;
	*notice = self->notice;
	return true;
}

int64_t shutdown_deadline_us(const struct shutdown *self)
{
	int64_t deadline_us = (self->schedule_down_us < self->schedule_up_us)
	                              ? self->schedule_down_us
	                              : self->schedule_up_us;

	if (self->state == SHUTDOWN_STATE_GOING_DOWN && self->announce_us < deadline_us) {
		deadline_us = self->announce_us;
	}
	return self->noticed ? 0 : deadline_us;
}
