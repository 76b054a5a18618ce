/* SPDX-License-Identifier: Apache-2.0 */
#include "host/sink.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The bytes to be written next, in one piece. */
static size_t peek(struct sink *sink, const uint8_t **data)
{
	size_t length;

	pthread_mutex_lock(&sink->lock);
	length = sink->size - sink->first;
	length = sink->used < length ? sink->used : length;
	*data = &sink->ring[sink->first];
	pthread_mutex_unlock(&sink->lock);
	return length;
}

static void consume(struct sink *sink, size_t length)
{
	pthread_mutex_lock(&sink->lock);
	sink->used -= length;
	/* An empty ring starts anew, so that its far end stays untouched. */
	sink->first = sink->used > 0 ? (sink->first + length) % sink->size : 0;
	pthread_mutex_unlock(&sink->lock);
}

static void fail(struct sink *sink, int error)
{
	pthread_mutex_lock(&sink->lock);
	sink->error = error;
	for (; sink->used > 0; sink->used--) {
		sink->lost_lines += sink->ring[sink->first] == '\n' ? 1 : 0;
		sink->first = (sink->first + 1) % sink->size;
	}
	pthread_mutex_unlock(&sink->lock);
}

/* On the helper's thread. */
static void write_all(struct helper_job *job)
{
	struct sink *sink = (struct sink *)((char *)job - offsetof(struct sink, job));
	const uint8_t *data;
	size_t length;

	while ((length = peek(sink, &data)) > 0) {
		const ssize_t n = write(sink->fd, data, length);

		if (n > 0) {
			consume(sink, (size_t)n);
		} else if (errno == EAGAIN) {
			/* Somebody who shares the descriptor does not want to wait; this does. */
			poll(&(struct pollfd){.fd = sink->fd, .events = POLLOUT}, 1, -1);
		} else if (errno != EINTR) {
			fail(sink, errno);
		}
	}
}

static void submit(struct sink *sink);

static void on_done(struct helper_job *job)
{
	struct sink *sink = (struct sink *)((char *)job - offsetof(struct sink, job));

	sink->is_submitted = false;
	if (sink_room(sink) < sink->size && sink_error(sink) == 0) {
		submit(sink); /* put since */
	} else if (sink->drained != NULL) {
		sink->drained(sink);
	}
}

static void submit(struct sink *sink)
{
	sink->is_submitted = true;
	sink->job.work = write_all;
	sink->job.done = on_done;
	helper_submit(&sink->helper, &sink->job);
}

size_t sink_room(struct sink *sink)
{
	size_t room;

	pthread_mutex_lock(&sink->lock);
	room = sink->size - sink->used;
	pthread_mutex_unlock(&sink->lock);
	return room;
}

int sink_error(struct sink *sink)
{
	int error;

	pthread_mutex_lock(&sink->lock);
	error = sink->error;
	pthread_mutex_unlock(&sink->lock);
	return error;
}

uint64_t sink_forgive(struct sink *sink)
{
	uint64_t lines;

	pthread_mutex_lock(&sink->lock);
	lines = sink->lost_lines;
	sink->lost_lines = 0;
	sink->error = 0;
	pthread_mutex_unlock(&sink->lock);
	return lines;
}

bool sink_put(struct sink *sink, const void *data, size_t length)
{
	bool fits;

	if (sink->ring == NULL) {
		sink->ring = malloc(sink->size);
		if (sink->ring == NULL) {
			abort();
		}
	}
	pthread_mutex_lock(&sink->lock);
	fits = sink->error == 0 && length <= sink->size - sink->used;
	if (fits) {
		const size_t at = (sink->first + sink->used) % sink->size;
		const size_t part = length < sink->size - at ? length : sink->size - at;

		memcpy(&sink->ring[at], data, part);
		memcpy(sink->ring, (const uint8_t *)data + part, length - part);
		sink->used += length;
	}
	pthread_mutex_unlock(&sink->lock);
	if (fits && !sink->is_submitted) {
		submit(sink);
	}
	return fits;
}

bool sink_finish(struct sink *sink, unsigned int timeout_ms)
{
	/* What was put after the helper's last look has not been submitted by the loop yet. */
	while (helper_finish(&sink->helper, timeout_ms)) {
		if (sink->ring == NULL || sink_room(sink) == sink->size || sink_error(sink) != 0) {
			return true;
		}
		submit(sink);
	}
	return false;
}
