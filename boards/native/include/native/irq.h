/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Interrupts from simulated devices to the native kernel.
 *
 * native_irq_raise(): runs isr(arg) in interrupt context now, when interrupts are enabled and the
 * caller is not already in an interrupt; otherwise it stays pending until they are, or until that
 * interrupt ends. An interrupt that is raised while it is pending runs once (edge-triggered).
 * Afterwards the scheduler may switch threads, so that a caller in thread context may be preempted
 * inside the call. Any context.
 *
 * native_irq_cancel(): forgets a pending interrupt.
 */
#ifndef NATIVE_IRQ_H_
#define NATIVE_IRQ_H_

#include <stdbool.h>

struct native_irq {
	void (*isr)(void *arg);
	void *arg;
	struct native_irq *next; /* kernel's own, as is pending: zero at first */
	bool pending;
};

void native_irq_raise(struct native_irq *irq);
void native_irq_cancel(struct native_irq *irq);

#endif
