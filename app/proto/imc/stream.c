/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/stream.h"

#include <string.h>

void imc_stream_init(struct imc_stream *self)
{
	self->stats = (struct imc_stream_stats){0};
	self->head = 0;
	self->tail = 0;
	self->skipping = false;
}

size_t imc_stream_write(struct imc_stream *self, const uint8_t *bytes, size_t count)
{
	if (self->head > 0 && IMC_STREAM_WINDOW - self->tail < count) {
		memmove(self->window, self->window + self->head, (size_t)(self->tail - self->head));
		self->tail = (uint16_t)(self->tail - self->head);
		self->head = 0;
	}

	const size_t room = IMC_STREAM_WINDOW - self->tail;
	const size_t taken = count < room ? count : room;

	memcpy(self->window + self->tail, bytes, taken);
	self->tail = (uint16_t)(self->tail + taken);
	return taken;
}

static void skip(struct imc_stream *self, size_t count)
{
	self->head = (uint16_t)(self->head + count);
	self->stats.skipped_bytes += (uint32_t)count;
	self->skipping = true;
}

static void take(struct imc_stream *self, const struct imc_stream_packet *packet)
{
	self->head = (uint16_t)(self->head + packet->length);
	self->stats.packets++;
	if (self->skipping) {
		self->stats.resyncs++;
		self->skipping = false;
	}
}

/* What begins at an offset of the window. */
static enum imc_result inspect(const struct imc_stream *self, size_t at,
                               struct imc_stream_packet *packet, bool *too_long)
{
	size_t length;
	const enum imc_result result = imc_verify(self->window + at, self->tail - at, &length);

	*too_long = length > IMC_PACKET_MAX;
	packet->bytes = self->window + at;
	packet->length = (uint16_t)length;
	return result;
}

bool imc_stream_next(struct imc_stream *self, struct imc_stream_packet *packet)
{
	while (self->head < self->tail) {
		bool too_long;
		const enum imc_result result = inspect(self, self->head, packet, &too_long);

		if (too_long) {
			self->stats.too_long++;
		} else if (result == IMC_OK) {
			take(self, packet);
			return true;
		} else if (result == IMC_TRUNCATED) {
			return false;
		} else if (result == IMC_BAD_CHECKSUM) {
			self->stats.checksum_errors++;
		}
		skip(self, 1);
	}
	return false;
}

bool imc_stream_pending(const struct imc_stream *self)
{
	return self->head < self->tail;
}

size_t imc_stream_wanted(const struct imc_stream *self)
{
	const size_t available = (size_t)(self->tail - self->head);
	size_t length;

	(void)imc_verify(self->window + self->head, available, &length);
	return (length > 0 ? length : IMC_HEADER_SIZE + IMC_FOOTER_SIZE) - available;
}

bool imc_stream_idle(struct imc_stream *self, struct imc_stream_packet *packet)
{
	for (size_t at = (size_t)self->head + 1; at < self->tail; at++) {
		bool too_long;

		if (inspect(self, at, packet, &too_long) == IMC_OK && !too_long) {
			skip(self, at - self->head);
			take(self, packet);
			return true;
		}
	}
	return false;
}
