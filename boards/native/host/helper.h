/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A thread of the host for what may make its caller wait: disks, terminals, pipes that nobody
 * reads. The board's own thread goes on meanwhile.
 *
 *   static struct helper disk = {.name = "pharos-disk"};
 *   helper_submit(&disk, &job);   job.work() on the helper's thread, then job.done() in the loop
 *
 * Real time only. In virtual time, and where no thread can be had, helper_submit() does the work
 * and calls done() before it returns, so that a run stays exact.
 */
#ifndef NATIVE_HOST_HELPER_H_
#define NATIVE_HOST_HELPER_H_

#include <pthread.h>
#include <stdbool.h>

struct helper_job {
	/* On the helper's thread: plain POSIX; nothing of the kernel, the loop or the clock. */
	void (*work)(struct helper_job *job);
	/* In the loop, interrupt context of the kernel. NULL: nobody waits. The job is free again.
	 */
	void (*done)(struct helper_job *job);
	struct helper_job *next; /* the helper's own */
};

struct helper {
	const char *name; /* of the thread, at most 15 characters */
	/* The helper's own. */
	pthread_t thread;
	pthread_cond_t changed;
	struct helper_job *first;
	bool is_started;
	bool is_busy;
};

/* In the order of submission. The job stays the caller's and must not be submitted again before it
 * is done. */
void helper_submit(struct helper *helper, struct helper_job *job);

/* Waits until all of its work is done, at most so long; true: it is. For save and stop hooks, when
 * the lamp is off; done() of what has ended then is not called any more. */
bool helper_finish(struct helper *helper, unsigned int timeout_ms);

enum {
	HELPER_FINISH_MS = 60000, /* a slow disk is waited for: what was begun is not to be torn */
};

#endif
