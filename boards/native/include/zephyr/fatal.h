/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fatal errors. k_panic(), k_oops(), a failed assertion and stack overflow call
 * k_sys_fatal_error_handler(), which is weak: by default it resets the board. When one returns, the
 * thread that failed is aborted; in an interrupt, or when the thread is essential, the board is
 * reset.
 */
#ifndef ZEPHYR_FATAL_H_
#define ZEPHYR_FATAL_H_

#include <zephyr/toolchain.h>

enum k_fatal_error_reason {
	K_ERR_CPU_EXCEPTION,
	K_ERR_SPURIOUS_IRQ,
	K_ERR_STACK_CHK_FAIL,
	K_ERR_KERNEL_OOPS,
	K_ERR_KERNEL_PANIC,
};

struct arch_esf;

/* Weak: resets the board. */
FUNC_NORETURN void k_fatal_halt(unsigned int reason);
void k_sys_fatal_error_handler(unsigned int reason, const struct arch_esf *esf);
FUNC_NORETURN void z_fatal_error(unsigned int reason, const struct arch_esf *esf);

#endif
