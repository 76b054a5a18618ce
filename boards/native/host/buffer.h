/* SPDX-License-Identifier: Apache-2.0 */
/* A byte queue that grows up to a bound. The host may allocate: it stands for the world, not for
 * the device. */
#ifndef NATIVE_HOST_BUFFER_H_
#define NATIVE_HOST_BUFFER_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct buffer {
	uint8_t *data;
	size_t head; /* first byte that is still wanted */
	size_t tail; /* one after the last */
	size_t size; /* allocated */
};

static inline size_t buffer_length(const struct buffer *buffer)
{
	return buffer->tail - buffer->head;
}

static inline const uint8_t *buffer_bytes(const struct buffer *buffer)
{
	return buffer->data == NULL ? NULL : buffer->data + buffer->head;
}

/* Room for `length` more bytes at the end, at most `max` in all; NULL: it would be more. */
uint8_t *buffer_reserve(struct buffer *buffer, size_t length, size_t max);

/* Appends; false (nothing taken): it would be more than max. */
bool buffer_append(struct buffer *buffer, const void *data, size_t length, size_t max);

/* Drops the first `length` bytes. */
void buffer_consume(struct buffer *buffer, size_t length);

void buffer_free(struct buffer *buffer);

#endif
