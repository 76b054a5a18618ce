/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The command thread owns all protocol state and the core state that commands change, so nothing in
 * it needs a lock. Others reach it through its queue: MAVLink and CAN frames, thermal reports, and
 * calls that run a function inside it.
 */
#ifndef PHAROS_THREADS_COMMAND_H
#define PHAROS_THREADS_COMMAND_H

#include <stdbool.h>
#include <stdint.h>

#include "core/arbiter.h"
#include "core/illuminator.h"
#include "core/params.h"
#include "core/self_test.h"
#include "threads/gimbal_node.h"
#include "threads/link.h"

struct dronecan_frame;
struct imc_frame;

/* What the command thread owns. Only a function given to command_call() may touch it. */
struct command {
	struct illuminator illuminator;
	struct arbiter arbiter;
	struct params params;
	struct self_test self_test;
#ifdef CONFIG_PHAROS_GIMBAL
	struct gimbal_node gimbal;
#endif
};

struct command_stats {
	uint32_t frames;
	uint32_t can_frames;
	uint32_t imc_packets;
	uint32_t thermal_reports;
	uint32_t calls;
	uint32_t reports_dropped; /* the queue was full: the next report comes in 100 ms */
};

/* Before the threads start. */
void command_init(void);

/*
 * A frame from the pool, whose buffer now is the command thread's. Waits for room up to one report
 * period; -EAGAIN: none came, the frame stays the caller's. Link threads.
 */
int command_post_frame(struct link_frame *frame);

/* The same with a CAN frame of the CAN thread's pool. */
int command_post_can(struct dronecan_frame *frame);

/* The same with a packet of IMC's pool. */
int command_post_imc(struct imc_frame *frame);

/* Something that the command thread waits for may have happened: it looks. Any context. */
void command_wake(void);

/* Never waits; a full queue drops the report and counts. Thermal thread. */
void command_post_thermal(const struct thermal_report *report);

/*
 * Runs function(command, argument) in the command thread and returns what it returned. Waits for
 * it: a command thread that does not come to it is a stall, which ends in a reset. -EAGAIN, which
 * no function returns: the thread does not run yet, and nothing was done. Any thread but the
 * command thread.
 */
int command_call(int (*function)(struct command *command, void *argument), void *argument);

/*
 * From functions that run in the command thread: a command from a source other than MAVLink. Asks
 * the arbiter; when it grants, applies the event, sets *result, and performs what follows.
 */
enum arbiter_verdict command_apply(struct command *command, enum arbiter_source source,
                                   const struct illuminator_event *event,
                                   enum illuminator_result *result);

/* The same with several events, all or none: false when one is refused, by whomever. */
bool command_apply_all(struct command *command, enum arbiter_source source,
                       const struct illuminator_event *events, size_t count);

/*
 * The same for the gimbal, which has an arbiter of its own. GRANTED with GIMBAL_ABSENT: there is no
 * gimbal. Servos begin to move within GIMBAL_FRAME_US.
 */
#ifdef CONFIG_PHAROS_GIMBAL
enum arbiter_verdict command_point(struct command *command, enum arbiter_source source,
                                   const struct gimbal_event *event, enum gimbal_result *result);
#else
static inline enum arbiter_verdict command_point(struct command *command,
                                                 enum arbiter_source source,
                                                 const struct gimbal_event *event,
                                                 enum gimbal_result *result)
{
	*result = GIMBAL_ABSENT;
	return ARBITER_GRANTED;
}
#endif

/*
 * From functions that run in the command thread: change a parameter, tell those concerned, store
 * it. name: length bytes, need not be terminated. Results as params_set.
 */
enum params_result command_set_param(struct command *command, const char *name, size_t length,
                                     int32_t value);
void command_reset_params(struct command *command);

/* The same, of parameters that have already been changed; in_force: MAVLink knows already. */
void command_params_changed(struct command *command, const struct param_set *changed);
void command_params_in_force(struct command *command, const struct param_set *changed);

/* From functions that run in the command thread: carry out what a step of the core returned. */
void command_perform(const struct illuminator_outbox *actions);

/* Counters; any thread. */
struct command_stats command_stats_get(void);

/* Thread entry. */
void command_run(void *, void *, void *);

#endif
