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

struct json_t;

/*
 * What gives input to the device besides the wires, such as a CAN bus: an advance waits for it,
 * lets it in, and reports it.
 */
struct lockstep_source {
	const char *name;
	/* Total of received frames: what `await` names. */
	uint64_t (*received)(void);
	/* Looks now at what the loop is not told about. */
	void (*poke)(void);
	/* Gives the device what was received, up to that total. */
	void (*release)(uint64_t total);
	/* Adds an entry by its name. */
	void (*report)(struct json_t *buses);
	struct lockstep_source *next; /* lock-step's own */
};

/* In start hooks. */
void lockstep_add(struct lockstep_source *source);

/* Nothing is ready to run; the kernel's next timeout is at this board time (UINT64_MAX: none). One
 * step. */
void lockstep_idle(uint64_t deadline_us);

#endif
