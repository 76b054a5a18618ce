/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What turns the lamp off when this process cannot any more. The kernel takes lines of a dead
 * process back, but most chips then keep their last level; a PWM output goes on by itself. So a
 * second process, pharos-guard, shares the outputs, does nothing but wait for the end of this one
 * (SIGKILL and crashes included), makes them safe, each in a process of its own, and ends. If it is
 * ended itself, another takes its place at once. None in virtual time, and none with --off.
 *
 *   static struct guard_output lines = {.make_safe = make_safe, .keeps = keeps};
 *   guard_add(&lines);                                   once, in a start hook
 *   lines.is_open = true;  rc = guard_renew();           whenever what is open has changed
 */
#ifndef NATIVE_HOST_GUARD_H_
#define NATIVE_HOST_GUARD_H_

#include <stdbool.h>

struct guard_output {
	bool is_open; /* there is something to make safe */
	/* In the guard, after the end of this process. */
	void (*make_safe)(void);
	/* In the guard, at its start: make_safe needs this descriptor, which is a link to target.
	 * All others are closed: a socket that stayed open would hide the end of this process. */
	bool (*keeps)(int fd, const char *target);
	struct guard_output *next; /* the guard's own */
};

void guard_add(struct guard_output *output);

/*
 * Another guard, for what is open now, in place of the one that there is. Main thread only. 0; or
 * -errno: there is no process to be had. Then the guard before goes on, which is said, and another
 * is tried for again and again.
 */
int guard_renew(void);

/* Nobody but this process has the outputs then. They are left as they are. */
void guard_stop(void);

#endif
