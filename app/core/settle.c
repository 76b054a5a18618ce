/* SPDX-License-Identifier: Apache-2.0 */
#include "core/settle.h"

#define BURST_US ((SETTLE_BURST - 1) * SETTLE_REFILL_US)

static int64_t later(int64_t a, int64_t b)
{
	return a > b ? a : b;
}

void settle_change(struct settle *self, int64_t now_us)
{
	const int64_t quiet_us = now_us + SETTLE_QUIET_US;

	if (self->due_us == 0) {
		self->latest_us = now_us + SETTLE_LATEST_US;
	}
	self->due_us = quiet_us < self->latest_us ? quiet_us : self->latest_us;
}

int64_t settle_deadline_us(const struct settle *self)
{
	return self->due_us == 0 ? TIME_NEVER_US : later(self->due_us, self->spent_us - BURST_US);
}

void settle_write(struct settle *self, int64_t now_us)
{
	self->spent_us = later(self->spent_us, now_us) + SETTLE_REFILL_US;
	settle_drop(self);
}

void settle_drop(struct settle *self)
{
	self->due_us = 0;
}
