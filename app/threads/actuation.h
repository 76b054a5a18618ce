/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What IMC actuates besides protocol: the actuation service with the board's outputs behind it.
 *
 * Context: functions take the command thread's state and run in that thread, unless said otherwise.
 */
#ifndef PHAROS_THREADS_ACTUATION_H
#define PHAROS_THREADS_ACTUATION_H

#include "threads/command.h"

#ifdef CONFIG_PHAROS_IMC

#include "proto/imc/actuation.h"

struct actuation_stats {
	uint32_t errors;  /* writes that a driver refused; tried again with the next change */
	uint32_t unaimed; /* commands to the gimbal that it, or its arbiter, refused */
};

/* With the parameters as loaded: the outputs are what they are after a start. */
struct imc_actuation *actuation_start(struct command *command);

/* Parameters have changed. */
void actuation_configure(const struct params *params, const struct param_set *changed);

/* Reads the GPIO inputs: before the service is given a packet. */
void actuation_sample(void);

/* Carries out what the service wants now: after each of its calls. */
void actuation_perform(struct command *command);

/* For the shell: from functions given to command_call(). */
const struct imc_actuation *actuation_service(void);
struct actuation_stats actuation_stats_get(void);

/* For the shell: a power channel by its number, as the core's power_command. */
bool actuation_power(struct command *command, uint32_t channel, uint32_t op);

#else

static inline void actuation_configure(const struct params *params, const struct param_set *changed)
{
}

#endif

#endif
