/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the host asks of the kernel's side. No host and no Zephyr headers. Interrupt context, but
 * for bridge_wait_for().
 */
#ifndef NATIVE_DEVICES_BRIDGE_H_
#define NATIVE_DEVICES_BRIDGE_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * The thread of that name gets no more CPU, whatever wakes it, until it is let go again (or a
 * reset). False: there is no such thread, and names holds those that there are ("a, b, …").
 */
bool bridge_stall_thread(const char *name, bool stalled, char *names, size_t size);

/*
 * Drives a line of models/board.h to level, and back after pulse_us of the kernel's time. A reset
 * in between ends the pulse. One pulse at a time per line: a new one replaces it.
 */
void bridge_line_pulse(uint32_t line, bool level, uint32_t pulse_us);

/*
 * Runs work(arg), which may wait for a disk of the host. In real time a helper runs it
 * (host/helper.h), and only the calling thread of the device waits, as for a slow device. In
 * virtual time, and in interrupt context, it runs at once.
 */
void bridge_wait_for(void (*work)(void *arg), void *arg);

/* Save and stop hooks of what uses it: waits until work that was begun has ended. */
void bridge_finish(void);

/* Ends a pulse's timer without touching the line. */
void bridge_line_pulse_stop(uint32_t line);

#endif
