/* SPDX-License-Identifier: Apache-2.0 */
/* Runs routine(parameter) in interrupt context, then reschedules. Threads only, not with interrupts
 * locked. */
#ifndef ZEPHYR_IRQ_OFFLOAD_H_
#define ZEPHYR_IRQ_OFFLOAD_H_

typedef void (*irq_offload_routine_t)(const void *parameter);

void irq_offload(irq_offload_routine_t routine, const void *parameter);

#endif
