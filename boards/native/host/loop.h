/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The host's event loop: descriptors (epoll), timers in the host's time, signals. Callbacks run
 * inside port_idle(), in interrupt context of the kernel, on the stack of whichever thread went
 * idle: they keep their frames small.
 */
#ifndef NATIVE_HOST_LOOP_H_
#define NATIVE_HOST_LOOP_H_

#include <stdbool.h>
#include <stdint.h>
#include <sys/epoll.h>

struct loop_source {
	int fd;
	/* events: EPOLLIN, EPOLLOUT, EPOLLHUP, EPOLLERR. Level-triggered. May remove and free the
	 * source. */
	void (*ready)(struct loop_source *source, uint32_t events);
	/* Only for loop_hot(): reads without waiting; true if something came. */
	bool (*again)(struct loop_source *source);
	void *owner;
	uint32_t wanted; /* the loop's own, as all below */
	bool added;
	bool always; /* a regular file: epoll takes none, reading never blocks */
	struct loop_source *next;
};

/* fd, ready and owner are set. Aborts when the descriptor is no descriptor. */
void loop_add(struct loop_source *source, uint32_t events);
void loop_want(struct loop_source *source, uint32_t events);
void loop_remove(struct loop_source *source);

/* Something came, so more may: its again() is tried once before the loop looks at anything else. */
void loop_hot(struct loop_source *source);

struct loop_timer {
	void (*fire)(struct loop_timer *timer);
	void *owner;
	uint64_t due_ns; /* the loop's own, as all below */
	bool running;
	struct loop_timer *next;
};

/* One-shot, in the host's time. Never for anything that the device could see in virtual time. */
void loop_timer_start(struct loop_timer *timer, uint32_t delay_ms);
void loop_timer_stop(struct loop_timer *timer);

/* Waits up to timeout_ns (negative: without end) and serves what is ready; how many callbacks ran.
 */
int loop_poll(int64_t timeout_ns);

/* SIGINT or SIGTERM came: the process should end. */
bool loop_interrupted(void);

/* Descriptors that something could still come from, besides signals. */
unsigned int loop_sources(void);

#endif
