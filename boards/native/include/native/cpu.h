/* SPDX-License-Identifier: Apache-2.0 */
/* The simulated CPU's interrupt state, visible for inline functions. Only the kernel writes it
 * otherwise. */
#ifndef NATIVE_CPU_H_
#define NATIVE_CPU_H_

#include <stdbool.h>

struct native_cpu {
	unsigned int isr_depth; /* > 0: interrupt context */
	bool irq_locked;
	bool irq_waiting; /* an interrupt or a timer expiry waits for the unlock */
};

extern struct native_cpu native_cpu;

/* Runs what waited for interrupts to be enabled, then reschedules. */
void native_irq_dispatch(void);

static inline unsigned int native_irq_lock(void)
{
	const unsigned int key = native_cpu.irq_locked;

	native_cpu.irq_locked = true;
	return key;
}

static inline void native_irq_unlock(unsigned int key)
{
	if (key == 0) {
		native_cpu.irq_locked = false;
		if (native_cpu.irq_waiting) {
			native_irq_dispatch();
		}
	}
}

#endif
