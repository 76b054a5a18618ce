/* SPDX-License-Identifier: Apache-2.0 */
#include "host/stream.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "host/carry.h"

static void update(struct stream *stream)
{
	loop_want(&stream->source, (stream->wire->paused ? 0 : EPOLLIN) |
	                                   (buffer_length(&stream->backlog) > 0 ? EPOLLOUT : 0));
}

void stream_close(struct stream *stream)
{
	if (stream->open) {
		stream->open = false;
		loop_remove(&stream->source);
		close(stream->source.fd);
	}
	buffer_free(&stream->backlog);
}

static void end(struct stream *stream, int error)
{
	stream_close(stream);
	stream->closed(stream, error);
}

/* Writes what it can; false: the stream ended. */
static bool drain(struct stream *stream)
{
	while (buffer_length(&stream->backlog) > 0) {
		const ssize_t n = write(stream->source.fd, buffer_bytes(&stream->backlog),
		                        buffer_length(&stream->backlog));

		if (n >= 0) {
			buffer_consume(&stream->backlog, (size_t)n);
		} else if (errno == EAGAIN) {
			break;
		} else if (errno != EINTR) {
			end(stream, errno);
			return false;
		}
	}
	update(stream);
	return true;
}

static void on_ready(struct loop_source *source, uint32_t events)
{
	static uint8_t bytes[WIRE_READ];
	struct stream *stream = source->owner;
	struct wire *wire = stream->wire;
	ssize_t n;

	if ((events & EPOLLOUT) != 0 && !drain(stream)) {
		return;
	}
	if ((events & ~(uint32_t)EPOLLOUT) == 0) {
		return;
	}
	/* A hang-up is told by the read, after all that came before it. */
	if (wire->paused && (events & (EPOLLHUP | EPOLLERR)) == 0) {
		return;
	}
	n = read(source->fd, bytes, sizeof(bytes));
	if (n > 0) {
		wire_received_of(wire, stream->voice, bytes, (size_t)n);
		wire_received_all(wire);
	} else if (n == 0) {
		end(stream, 0);
	} else if (errno != EAGAIN && errno != EINTR) {
		end(stream, errno);
	}
}

void stream_open(struct stream *stream, int fd)
{
	stream->source.fd = fd;
	stream->source.ready = on_ready;
	stream->source.owner = stream;
	stream->open = true;
	loop_add(&stream->source, 0);
	update(stream);
}

bool stream_send(struct stream *stream, const uint8_t *data, size_t length)
{
	size_t done = 0;

	if (!stream->open) {
		return false;
	}
	if (buffer_length(&stream->backlog) == 0) {
		const ssize_t n = write(stream->source.fd, data, length);

		if (n < 0 && errno != EAGAIN && errno != EINTR) {
			end(stream, errno);
			return false;
		}
		done = n > 0 ? (size_t)n : 0;
	}
	if (done < length) {
		/* A part of a datagram must be followed by its rest, whatever the bound. */
		const size_t max = done > 0 ? SIZE_MAX / 2 : wire_backlog_max();

		if (!buffer_append(&stream->backlog, data + done, length - done, max)) {
			return false;
		}
		update(stream);
	}
	return true;
}

void stream_pause(struct stream *stream, bool paused)
{
	(void)paused;
	if (stream->open) {
		update(stream);
	}
}

void stream_save(struct stream *stream, const char *name)
{
	struct buffer data = {0};

	if (!stream->open) {
		return;
	}
	buffer_append(&data, &stream->source.fd, sizeof(stream->source.fd), SIZE_MAX / 2);
	buffer_append(&data, buffer_bytes(&stream->backlog), buffer_length(&stream->backlog),
	              SIZE_MAX / 2);
	carry_put(name, buffer_bytes(&data), buffer_length(&data));
	carry_fd(stream->source.fd);
	buffer_free(&data);
}

bool stream_restore(struct stream *stream, const char *name)
{
	size_t size;
	const uint8_t *data = carry_get(name, &size);
	int fd;

	if (data == NULL || size < sizeof(fd)) {
		return false;
	}
	memcpy(&fd, data, sizeof(fd));
	buffer_append(&stream->backlog, data + sizeof(fd), size - sizeof(fd), SIZE_MAX / 2);
	stream_open(stream, fd);
	return true;
}
