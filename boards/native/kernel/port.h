/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The line between the native kernel and the host below it. No host header is included here.
 *
 * The kernel (boards/native/kernel) calls port_*(); the host (boards/native/host) implements them
 * and calls kernel_boot() once. Everything runs in one OS thread.
 */
#ifndef NATIVE_KERNEL_PORT_H_
#define NATIVE_KERNEL_PORT_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <native/context.h>

/* The stack gets a new owner: makes the sanitizer forget the frames of the previous one. */
void port_stack_claim(void *stack, size_t size);

/* Prepares ctx so that the first switch to it calls entry(arg) on that stack; entry must not
 * return. */
void port_context_init(struct port_context *ctx, void *stack, size_t size, void (*entry)(void *),
                       void *arg);

/*
 * Suspends the caller in *from and resumes *to. from == NULL: the caller is never resumed (its
 * sanitizer state is released).
 */
void port_context_switch(struct port_context *from, struct port_context *to);

/*
 * Microseconds since this boot, never going back. Virtual time: stands still while code runs. Real
 * time: the host's monotonic clock.
 */
uint64_t port_clock_now_us(void);

/*
 * Returns when port_clock_now_us() >= until_us. Virtual: moves the clock there. Real: spins. The
 * kernel has bounded until_us to the next timeout, so that no expiry is jumped over.
 */
void port_clock_busy_wait(uint64_t until_us);

/*
 * Nothing is ready to run: waits for a host event, or until deadline_us (UINT64_MAX: no deadline).
 * The host's callbacks run inside; the kernel has marked this as interrupt context. Returns after
 * one or more events, at the deadline, or early. A deadline that is not in the future (the kernel
 * uses 0 when threads have kept the CPU for long): dispatches what is waiting already, in virtual
 * time nothing at all, and returns at once.
 */
void port_idle(uint64_t deadline_us);

/* Nanoseconds from any origin; for k_cycle_get_*(). In virtual time: virtual nanoseconds. */
uint64_t port_cycles(void);

/* One line of the event trace ("<time> <kind> <name> <value>"); returns at once when there is no
 * trace. */
void port_trace(const char *kind, const char *name, int64_t value);

/* A fault keeps the thread of that name from running at all. */
bool port_thread_stalled(const char *name);

/*
 * Board reset: the lamp goes off at that instant, then the MCU's side starts anew. The cause is one
 * of Zephyr's hwinfo bits: the kernel uses software (1 << 1) and CPU lockup (1 << 8: fatal error).
 */
_Noreturn void port_reset(uint32_t cause);

_Noreturn void port_exit(int status);

/* Last-resort output: any context, any state of the kernel; it never waits in real time. */
void port_console_write(const char *text, size_t length);

/*
 * Implemented by the kernel, called once by the host's main(): runs the SYS_INIT levels, starts the
 * static threads, then calls main() in the main thread.
 */
_Noreturn void kernel_boot(void);

#endif
