/* SPDX-License-Identifier: Apache-2.0 */
/* Interrupt lock. Belongs to the thread: while a locking thread waits, others run with interrupts
 * enabled. */
#ifndef ZEPHYR_IRQ_H_
#define ZEPHYR_IRQ_H_

#include <native/cpu.h>

#define irq_lock()      native_irq_lock()
#define irq_unlock(key) native_irq_unlock(key)

#endif
