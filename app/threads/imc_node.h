/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light as an IMC node, as the command thread has it. A build without IMC has none of it.
 *
 * Context: functions take the command thread's state and run in that thread.
 */
#ifndef PHAROS_THREADS_IMC_NODE_H
#define PHAROS_THREADS_IMC_NODE_H

#include "threads/command.h"

struct imc_frame;

#ifdef CONFIG_PHAROS_IMC

struct imc_endpoint;

/* With the parameters as loaded, and the UARTs' protocols as set. */
void imc_node_start(struct command *command);

/* A packet from the pool of imc_link.h, which gets it back. */
void imc_node_take(struct command *command, struct imc_frame *frame);

/* A button has been pressed or released: tell everyone. */
void imc_node_button(struct command *command, uint8_t button, bool pressed);

/* Sends what is due. */
void imc_node_poll(struct command *command);
int64_t imc_node_due_us(void);

/* The lamp's state may be new: tell it. */
void imc_node_report(const struct illuminator *illuminator);

/* For the shell: from functions given to command_call(). */
const struct imc_endpoint *imc_node_endpoint(void);

#else

static inline void imc_node_start(struct command *command)
{
}

static inline void imc_node_take(struct command *command, struct imc_frame *frame)
{
}

static inline void imc_node_button(struct command *command, uint8_t button, bool pressed)
{
}

static inline void imc_node_poll(struct command *command)
{
}

static inline int64_t imc_node_due_us(void)
{
	return TIME_NEVER_US;
}

static inline void imc_node_report(const struct illuminator *illuminator)
{
}

#endif

#endif
