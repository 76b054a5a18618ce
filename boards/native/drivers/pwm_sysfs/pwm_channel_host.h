/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One channel of a PWM chip of the kernel's, by sysfs. What may wait for a slow bus runs in a
 * helper or in a start hook.
 */
#ifndef PWM_CHANNEL_HOST_H_
#define PWM_CHANNEL_HOST_H_

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

#include "host/error.h"
#include "host/sysfs.h"

/* Where it is, and how it is to run. */
struct pwm_place {
	char chip[SYSFS_PATH_SIZE]; /* as sysfs_find() takes it; empty: nowhere */
	uint32_t channel;
	uint32_t period_ns;
	bool is_inverted;
};

struct pwm_channel {
	char chip[SYSFS_PATH_SIZE];
	char path[SYSFS_PATH_SIZE]; /* empty: it was not found */
	uint32_t channel;
	bool is_exported;   /* by us: so we unexport it */
	bool is_inverted;   /* it is low, and so fully lit, on many a chip once it is off */
	int claim_fd;       /* no other light has it; -1: not claimed */
	dev_t claim_device; /* the folder that the claim is for */
	ino_t claim_folder;
	int duty_fd;
	int enable_fd;
};

/* Sets chip, channel and path, whose folder need not be there yet. 0, or -1 with a reason. */
int pwm_channel_find(struct pwm_channel *self, const struct pwm_place *place,
                     struct host_error *error);

/* Before all else. */
void pwm_channel_init(struct pwm_channel *self);

/*
 * Finds the chip, exports the channel, and lets it run with pulses of no length; again, after it
 * was lost. is_exported: an earlier one of us has exported it. 0; or -1 with a reason, and *is_ours
 * says whether another light, or its guard, has it.
 */
int pwm_channel_open(struct pwm_channel *self, const struct pwm_place *place, bool is_exported,
                     bool *is_ours, struct host_error *error);

/* The pulse of each period. 0 or -errno. */
int pwm_channel_write(const struct pwm_channel *self, uint32_t pulse_ns);

/* Whether it is still there: 0 or -errno. Does not touch the chip. */
int pwm_channel_check(const struct pwm_channel *self);

/*
 * No pulses; off, and unexported if we have exported it. One of inverse polarity stays on with
 * pulses of no length. Also in another process that shares it.
 */
void pwm_channel_end(const struct pwm_channel *self);

/* Closes what is open, and gives up the claim; the output stays as it is. */
void pwm_channel_close(struct pwm_channel *self);

#endif
