/* SPDX-License-Identifier: Apache-2.0 */
#include <native/irq.h>
#include <zephyr/irq_offload.h>

#include "port.h"
#include "sched.h"

struct native_cpu native_cpu;

static struct native_irq *waiting_first;
static struct native_irq **waiting_end = &waiting_first;

void irq_enter(void)
{
	native_cpu.isr_depth++;
}

static struct native_irq *take_waiting(void)
{
	struct native_irq *irq = waiting_first;

	if (irq != NULL) {
		waiting_first = irq->next;
		if (waiting_first == NULL) {
			waiting_end = &waiting_first;
		}
		irq->pending = false;
	}
	return irq;
}

/* In interrupt context: device interrupts in the order in which they were raised, then the clock.
 */
static void run_waiting(void)
{
	struct native_irq *irq;

	native_cpu.irq_waiting = false;
	while ((irq = take_waiting()) != NULL) {
		irq->isr(irq->arg);
	}
	timeout_announce();
}

void irq_exit(void)
{
	if (native_cpu.isr_depth == 1 && !native_cpu.irq_locked) {
		while (native_cpu.irq_waiting) {
			run_waiting();
		}
	}
	native_cpu.isr_depth--;
	sched_reschedule();
}

void native_irq_dispatch(void)
{
	if (native_cpu.isr_depth == 0) {
		irq_enter();
		irq_exit();
	}
}

void native_irq_raise(struct native_irq *irq)
{
	if (irq->pending) {
		return;
	}
	if (native_cpu.irq_locked || native_cpu.isr_depth > 0) {
		irq->pending = true;
		irq->next = NULL;
		*waiting_end = irq;
		waiting_end = &irq->next;
		native_cpu.irq_waiting = true;
		return;
	}
	irq_enter();
	irq->isr(irq->arg);
	irq_exit();
}

void native_irq_cancel(struct native_irq *irq)
{
	struct native_irq **link = &waiting_first;

	if (!irq->pending) {
		return;
	}
	while (*link != irq) {
		link = &(*link)->next;
	}
	*link = irq->next;
	if (irq->next == NULL) {
		waiting_end = link;
	}
	irq->pending = false;
}

void irq_offload(irq_offload_routine_t routine, const void *parameter)
{
	irq_enter();
	routine(parameter);
	irq_exit();
}
