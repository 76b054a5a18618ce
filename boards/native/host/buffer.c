/* SPDX-License-Identifier: Apache-2.0 */
#include "host/buffer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
	BUFFER_MIN = 1024
};

uint8_t *buffer_reserve(struct buffer *buffer, size_t length, size_t max)
{
	const size_t used = buffer_length(buffer);

	if (length > max || used > max - length) {
		return NULL;
	}
	if (buffer->tail + length <= buffer->size) {
		return buffer->data + buffer->tail;
	}
	if (used + length > buffer->size) {
		size_t size = buffer->size != 0 ? buffer->size : BUFFER_MIN;
		uint8_t *data;

		while (size < used + length) {
			size *= 2;
		}
		data = realloc(buffer->data, size);
		if (data == NULL) {
			fputs("pharos: out of memory\n", stderr);
			abort();
		}
		buffer->data = data;
		buffer->size = size;
	}
	if (buffer->head != 0) {
		memmove(buffer->data, buffer->data + buffer->head, used);
		buffer->head = 0;
		buffer->tail = used;
	}
	return buffer->data + buffer->tail;
}

bool buffer_append(struct buffer *buffer, const void *data, size_t length, size_t max)
{
	uint8_t *room;

	if (length == 0) {
		return true;
	}
	room = buffer_reserve(buffer, length, max);
	if (room == NULL) {
		return false;
	}
	memcpy(room, data, length);
	buffer->tail += length;
	return true;
}

void buffer_consume(struct buffer *buffer, size_t length)
{
	buffer->head += length;
	if (buffer->head == buffer->tail) {
		buffer->head = 0;
		buffer->tail = 0;
	}
}

void buffer_free(struct buffer *buffer)
{
	free(buffer->data);
	*buffer = (struct buffer){0};
}
