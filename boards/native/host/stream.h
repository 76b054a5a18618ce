/* SPDX-License-Identifier: Apache-2.0 */
/* A connected byte stream (socket, pty, serial port) as one end of a wire: non-blocking, with a
 * backlog. */
#ifndef NATIVE_HOST_STREAM_H_
#define NATIVE_HOST_STREAM_H_

#include "host/wire.h"

struct stream {
	struct wire *wire;
	struct loop_source source;
	struct buffer backlog;
	/* The stream ended: error is 0 for a plain hang-up. It is closed already. */
	void (*closed)(struct stream *stream, int error);
	void *owner;
	int voice; /* which of several peers of the wire (host/wire_peers.h); WIRE_VOICES: the one
	            */
	bool open;
};

/* Takes fd, which is non-blocking. wire, closed, owner and voice are set. */
void stream_open(struct stream *stream, int fd);

void stream_close(struct stream *stream);

/* All or nothing; what the host doesn't take now is kept. false: the backlog is full, or it just
 * ended. */
bool stream_send(struct stream *stream, const uint8_t *data, size_t length);

void stream_pause(struct stream *stream, bool paused);

/* Reset: "name" carries descriptor and backlog. */
void stream_save(struct stream *stream, const char *name);
bool stream_restore(struct stream *stream, const char *name);

#endif
