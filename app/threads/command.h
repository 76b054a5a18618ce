/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The command thread owns the device and all protocols' state, so nothing in it needs a lock. It
 * takes what comes into its inbox, lets the device or a protocol do it, performs once what follows,
 * and lets every protocol tell its peers.
 */
#ifndef PHAROS_THREADS_COMMAND_H
#define PHAROS_THREADS_COMMAND_H

/* Before the threads start. */
void command_init(void);

/* Thread entry. */
void command_run(void *p1, void *p2, void *p3);

#endif
