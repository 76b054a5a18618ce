/* SPDX-License-Identifier: Apache-2.0 */
#include "core/power.h"

#include "core/assert.h"

#define CHANNELS_MASK ((1u << POWER_CHANNELS_MAX) - 1u)

static const struct power_timers no_timers = {
	.restart_us = TIME_NEVER_US,
	.on_us = TIME_NEVER_US,
	.off_us = TIME_NEVER_US,
};

void power_init(struct power *self, uint32_t present, uint32_t on)
{
	PHAROS_ASSERT((present & ~CHANNELS_MASK) == 0);
	*self = (struct power){
		.present = present,
		.on = on & present,
		.saved = on & CHANNELS_MASK, /* a line that fails today is not given up */
		.due_us = TIME_NEVER_US,
	};
	for (uint32_t channel = 0; channel < POWER_CHANNELS_MAX; channel++) {
		self->timers[channel] = no_timers;
	}
}

static bool is_on(const struct power *self, uint32_t channel)
{
	return (self->on & (1u << channel)) != 0;
}

/* Whatever switches a channel ends a restart. */
static void switch_channel(struct power *self, uint32_t channel, bool on)
{
	const uint32_t bit = 1u << channel;

	self->on = on ? self->on | bit : self->on & ~bit;
	self->timers[channel].restart_us = TIME_NEVER_US;
}

/* A channel that is being restarted is on, as far as the next start is concerned. */
static void save(struct power *self, uint32_t channel)
{
	const uint32_t bit = 1u << channel;
	const bool on = is_on(self, channel) || self->timers[channel].restart_us != TIME_NEVER_US;

	self->saved = on ? self->saved | bit : self->saved & ~bit;
}

static void carry_out(struct power *self, int64_t now_us, uint32_t channel, enum power_op op,
                      int64_t delay_us)
{
	struct power_timers *const timers = &self->timers[channel];

	switch (op) {
	case POWER_OP_OFF:
		switch_channel(self, channel, false);
		break;
	case POWER_OP_ON:
		switch_channel(self, channel, true);
		break;
	case POWER_OP_TOGGLE:
		switch_channel(self, channel, !is_on(self, channel));
		break;
	case POWER_OP_SCHEDULE_ON:
		timers->on_us = now_us + delay_us;
		break;
	case POWER_OP_SCHEDULE_OFF:
		timers->off_us = now_us + delay_us;
		break;
	case POWER_OP_RESET_SCHEDULES:
		timers->on_us = TIME_NEVER_US;
		timers->off_us = TIME_NEVER_US;
		break;
	case POWER_OP_SAVE:
		save(self, channel);
		break;
	case POWER_OP_RESTART:
		switch_channel(self, channel, false);
		timers->restart_us = now_us + POWER_RESTART_US;
		break;
	}
}

/* The one of a channel's timers that falls due first; of several at once, off is the last. */
static int64_t *first_timer(struct power_timers *timers)
{
	int64_t *first = &timers->restart_us;

	if (timers->on_us < *first) {
		first = &timers->on_us;
	}
	return (timers->off_us < *first) ? &timers->off_us : first;
}

static void find_due(struct power *self)
{
	self->due_us = TIME_NEVER_US;
	for (uint32_t channel = 0; channel < POWER_CHANNELS_MAX; channel++) {
		const int64_t due_us = *first_timer(&self->timers[channel]);

		self->due_us = due_us < self->due_us ? due_us : self->due_us;
	}
}

void power_advance(struct power *self, int64_t now_us)
{
	if (now_us < self->due_us) {
		return;
	}
	for (uint32_t channel = 0; channel < POWER_CHANNELS_MAX; channel++) {
		struct power_timers *const timers = &self->timers[channel];

		/* each is due once */
		for (int64_t *due = first_timer(timers); *due <= now_us;
		     due = first_timer(timers)) {
			const bool on = due != &timers->off_us;

			*due = TIME_NEVER_US;
			switch_channel(self, channel, on);
		}
	}
	find_due(self);
}

bool power_command(struct power *self, int64_t now_us, uint32_t channel, uint32_t op,
                   int64_t delay_us)
{
	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	const bool timed = op == POWER_OP_SCHEDULE_ON || op == POWER_OP_SCHEDULE_OFF;

	if (channel >= POWER_CHANNELS_MAX || (self->present & (1u << channel)) == 0 ||
	    op >= POWER_OPS || (timed && (delay_us < 0 || delay_us > POWER_SCHEDULE_MAX_US))) {
		return false;
	}
	power_advance(self, now_us);
	carry_out(self, now_us, channel, (enum power_op)op, delay_us);
	find_due(self);
	power_advance(self, now_us);
	return true;
}

int64_t power_deadline_us(const struct power *self)
{
	return self->due_us;
}

uint32_t power_outputs(const struct power *self)
{
	return self->down ? 0 : self->on;
}
