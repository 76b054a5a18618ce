/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light as an IMC node, as the command thread has it. A build without IMC has none of it.
 *
 * Context: the command thread.
 */
#ifndef PHAROS_THREADS_IMC_LIGHT_H
#define PHAROS_THREADS_IMC_LIGHT_H

#include <stdbool.h>
#include <stdint.h>

#include "core/device.h"

struct imc_frame;

#ifdef CONFIG_PHAROS_IMC

struct imc_endpoint;

/* With the parameters as loaded, and the UARTs' protocols as set. */
void imc_light_init(struct pharos_device *device);

/* A packet has come. */
void imc_light_take(const struct imc_frame *frame);

/* A button has been pressed or released: tell everyone. */
void imc_light_button(uint8_t button, bool pressed);

/* What the device did: tells it. */
void imc_light_tell(const struct device_effects *effects);

/* What is due. */
void imc_light_step(void);
int64_t imc_light_deadline_us(void);

/* Sends what the calls above have made. After what the device did has been performed. */
void imc_light_flush(void);

/* For the shell: from functions given to inbox_call(). */
const struct imc_endpoint *imc_light_endpoint(void);

#else

static inline void imc_light_init(struct pharos_device *device)
{
}

static inline void imc_light_take(const struct imc_frame *frame)
{
}

static inline void imc_light_button(uint8_t button, bool pressed)
{
}

static inline void imc_light_tell(const struct device_effects *effects)
{
}

static inline void imc_light_step(void)
{
}

static inline int64_t imc_light_deadline_us(void)
{
	return TIME_NEVER_US;
}

static inline void imc_light_flush(void)
{
}

#endif

#endif
