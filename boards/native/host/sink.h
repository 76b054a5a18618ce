/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Bytes to a descriptor that may make its writer wait: a terminal, a pipe that nobody reads, a slow
 * disk. They go into a ring, out of which a helper writes; so the caller never waits, and what does
 * not fit is refused. In virtual time they are written before sink_put() returns.
 */
#ifndef NATIVE_HOST_SINK_H_
#define NATIVE_HOST_SINK_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/helper.h"

struct sink {
	int fd;
	size_t size; /* of the ring */
	/* In the loop: all that was put has been written, or there is an error. May be NULL. */
	void (*drained)(struct sink *sink);
	struct helper helper; /* its name is set; the rest is the sink's own, as all below */
	struct helper_job job;
	bool is_submitted;
	pthread_mutex_t lock; /* of all below */
	uint8_t *ring;
	size_t first;
	size_t used;
	int error;
	uint64_t lost_lines;
};

#define SINK_INIT(descriptor, ring_size, thread_name)                                              \
	{                                                                                          \
		.fd = (descriptor), .size = (ring_size), .helper = {.name = (thread_name)},        \
		.lock = PTHREAD_MUTEX_INITIALIZER,                                                 \
	}

/* All of it, or false: there is no room now, or no more at all (sink_error()). */
bool sink_put(struct sink *sink, const void *data, size_t length);

/* Bytes that sink_put() would take. */
size_t sink_room(struct sink *sink);

/* errno of the write that failed: what waited is lost, and nothing is taken any more. 0: none has.
 */
int sink_error(struct sink *sink);

/* Takes bytes again after an error. How many lines were lost by it. */
uint64_t sink_forgive(struct sink *sink);

/* Save and stop hooks: waits until all is written, at most so long; true: it is. */
bool sink_finish(struct sink *sink, unsigned int timeout_ms);

#endif
