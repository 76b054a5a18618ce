/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lock-step: virtual time with a control socket. Time stands still until an `advance`, which first
 * waits (in the host's time) for bytes that its client has sent to wires, then moves time from
 * event to event, then replies.
 */
#ifndef NATIVE_HOST_LOCKSTEP_H_
#define NATIVE_HOST_LOCKSTEP_H_

#include <stdbool.h>
#include <stdint.h>

bool lockstep_enabled(void);

/* The client of the advance under way has gone: time stops where it is. */
void lockstep_cancel(void);

/* Nothing is ready to run; the kernel's next timeout is at this board time (UINT64_MAX: none). One
 * step. */
void lockstep_idle(uint64_t deadline_us);

#endif
