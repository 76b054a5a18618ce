/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What turns the lamp off when this process cannot any more. The kernel takes the lines of a dead
 * process back, but most chips then keep their last level. So a second process shares the lines,
 * does nothing but wait for the end of this one (SIGKILL and crashes included), makes them safe,
 * and ends.
 */
#ifndef GPIO_GUARD_H_
#define GPIO_GUARD_H_

#include <stdbool.h>

/*
 * When this process ends, or calls guard_stop(), make_safe() is called in the guard, once. Of the
 * descriptors the guard keeps those of GPIO lines only. 0 or -errno.
 */
int guard_start(void (*make_safe)(void));

/* Ends the guard, and waits until it has: then nobody but this process holds the lines. */
void guard_stop(void);

/* False: there should be a guard, but somebody has ended it. It is forgotten then. */
bool guard_is_well(void);

#endif
