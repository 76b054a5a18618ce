/* SPDX-License-Identifier: Apache-2.0 */
#ifndef ZEPHYR_ARCH_CPU_H_
#define ZEPHYR_ARCH_CPU_H_

#include <stdbool.h>

#include <native/cpu.h>
#include <zephyr/irq.h>

#define arch_irq_lock()      native_irq_lock()
#define arch_irq_unlock(key) native_irq_unlock(key)
#define arch_is_in_isr()     (native_cpu.isr_depth > 0)

static inline bool arch_irq_unlocked(unsigned int key)
{
	return key == 0;
}

#endif
