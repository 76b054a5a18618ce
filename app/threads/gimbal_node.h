/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The gimbal as the command thread has it: the core's gimbal, who may aim it, and its servos. There
 * is none when the board has no servos, GMB_ENABLE is 0, or the build leaves it out.
 *
 * Context: functions take the command thread's state and run in that thread.
 */
#ifndef PHAROS_THREADS_GIMBAL_NODE_H
#define PHAROS_THREADS_GIMBAL_NODE_H

#include <stdbool.h>
#include <stdint.h>

#include "core/arbiter.h"
#include "core/gimbal.h"
#include "core/limits.h"

struct command;
struct param_set;

struct gimbal_node {
	bool active; /* there is a gimbal; else the rest means nothing */
	struct gimbal gimbal;
	struct arbiter arbiter;
	uint32_t servo_errors;
};

#ifdef CONFIG_PHAROS_GIMBAL

/* With the parameters as loaded. Moves the servos to neutral. */
void gimbal_node_init(struct command *command);

/* Parameters have changed. */
void gimbal_node_configure(struct command *command, const struct param_set *changed);

/* Moves the servos when it is time. */
void gimbal_node_step(struct command *command);
int64_t gimbal_node_deadline_us(const struct command *command);

bool gimbal_node_is_active(const struct command *command);

/* Where on an axis a share of its range is, as gimbal_share_mdeg. There is a gimbal (asserted). */
int32_t gimbal_node_share_mdeg(const struct command *command, enum gimbal_axis_id axis,
                               int32_t share_ppm);

/* A share of an axis's fastest rate, -PPM_ONE…PPM_ONE, in mdeg/s. There is a gimbal (asserted). */
int32_t gimbal_node_share_rate(const struct command *command, enum gimbal_axis_id axis,
                               int32_t share_ppm);

/* Who aims it now. */
enum arbiter_source gimbal_node_commander(const struct command *command);

#else

static inline void gimbal_node_init(struct command *command)
{
}

static inline void gimbal_node_configure(struct command *command, const struct param_set *changed)
{
}

static inline void gimbal_node_step(struct command *command)
{
}

static inline int64_t gimbal_node_deadline_us(const struct command *command)
{
	return TIME_NEVER_US;
}

static inline bool gimbal_node_is_active(const struct command *command)
{
	return false;
}

static inline int32_t gimbal_node_share_mdeg(const struct command *command,
                                             enum gimbal_axis_id axis, int32_t share_ppm)
{
	return 0;
}

static inline int32_t gimbal_node_share_rate(const struct command *command,
                                             enum gimbal_axis_id axis, int32_t share_ppm)
{
	return 0;
}

static inline enum arbiter_source gimbal_node_commander(const struct command *command)
{
	return ARBITER_SOURCE_NONE;
}

#endif

#endif
