/* SPDX-License-Identifier: Apache-2.0 */
#include <stdarg.h>
#include <stdio.h>

#include <zephyr/sys/reboot.h>

#include "port.h"
#include "sched.h"

/* Zephyr's hwinfo bits. */
#define RESET_CAUSE_SOFTWARE   (1U << 1)
#define RESET_CAUSE_CPU_LOCKUP (1U << 8)

#define LINE_MAX_BYTES 512

void vprintk(const char *fmt, va_list ap)
{
	char line[LINE_MAX_BYTES];
	const int length = vsnprintf(line, sizeof(line), fmt, ap);

	if (length > 0) {
		port_console_write(line, MIN((size_t)length, sizeof(line) - 1));
	}
}

void printk(const char *fmt, ...)
{
	va_list ap;

	va_start(ap, fmt);
	vprintk(fmt, ap);
	va_end(ap);
}

void assert_print(const char *fmt, ...)
{
	va_list ap;

	va_start(ap, fmt);
	vprintk(fmt, ap);
	va_end(ap);
}

__weak void assert_post_action(const char *file, unsigned int line)
{
	ARG_UNUSED(file);
	ARG_UNUSED(line);
	k_panic();
}

__weak void k_fatal_halt(unsigned int reason)
{
	ARG_UNUSED(reason);
	port_reset(RESET_CAUSE_CPU_LOCKUP);
}

static const char *reason_name(unsigned int reason)
{
	static const char *const names[] = {
		[K_ERR_CPU_EXCEPTION] = "CPU exception",
		[K_ERR_SPURIOUS_IRQ] = "spurious interrupt",
		[K_ERR_STACK_CHK_FAIL] = "stack overflow",
		[K_ERR_KERNEL_OOPS] = "oops",
		[K_ERR_KERNEL_PANIC] = "panic",
	};

	return reason < ARRAY_SIZE(names) ? names[reason] : "unknown";
}

__weak void k_sys_fatal_error_handler(unsigned int reason, const struct arch_esf *esf)
{
	ARG_UNUSED(esf);
	k_fatal_halt(reason);
}

void z_fatal_error(unsigned int reason, const struct arch_esf *esf)
{
	struct k_thread *thread = sched_current;
	const bool in_isr = native_cpu.isr_depth > 0;

	(void)irq_lock();
	printk("FATAL ERROR: %s in %s \"%s\"\n", reason_name(reason),
	       in_isr ? "an interrupt during thread" : "thread",
	       thread != NULL ? thread->name : "boot");
	k_sys_fatal_error_handler(reason, esf);
	if (thread == NULL || in_isr || (thread->base.user_options & K_ESSENTIAL) != 0) {
		k_fatal_halt(reason);
	}
	k_thread_abort(thread);
	CODE_UNREACHABLE;
}

void k_fatal(unsigned int reason)
{
	z_fatal_error(reason, NULL);
}

void sys_reboot(int type)
{
	ARG_UNUSED(type);
	port_reset(RESET_CAUSE_SOFTWARE);
}
