/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stream: bytes of a UART or a TCP connection in, in any chunks; whole packets out, pointing into
 * the stream's window. It is used like a MAVLink framer:
 *
 *   while (size > 0) {
 *           size_t taken = imc_stream_write(&stream, bytes, size);
 *           bytes += taken, size -= taken;
 *           while (imc_stream_next(&stream, &packet)) { … imc_parse(packet.bytes, …) … }
 *   }
 *
 * After a false start (no sync number, wrong checksum, a claim of more than IMC_PAYLOAD_MAX) the
 * search goes on with the very next byte, so no good packet is lost behind a wrong size. Packets of
 * messages that we don't know come out like others: what they carry is not searched.
 * A false start may claim bytes that never come: once the line has been silent for
 * IMC_STREAM_IDLE_US, imc_stream_idle() finds the good packets behind it.
 *
 * Context: one thread per stream.
 */
#ifndef PHAROS_PROTO_IMC_STREAM_H
#define PHAROS_PROTO_IMC_STREAM_H

#include "proto/imc/codec.h"

/* Silence after which a byte that should follow will not: longer than a USB adapter's latency. */
#define IMC_STREAM_IDLE_US 50000

struct imc_stream_stats {
	uint32_t packets;
	uint32_t checksum_errors; /* candidates with a wrong checksum */
	uint32_t too_long;        /* candidates that claimed more than we take */
	uint32_t resyncs;         /* times that a packet was found after bytes had been skipped */
	uint32_t skipped_bytes;   /* bytes that belong to no packet */
};

struct imc_stream_packet {
	const uint8_t *bytes;
	uint16_t length;
};

struct imc_stream {
	struct imc_stream_stats stats;
	uint16_t head;
	uint16_t tail;
	bool skipping;
	uint8_t window[IMC_STREAM_WINDOW];
};

void imc_stream_init(struct imc_stream *self);

/*
 * Copies as many bytes as have room, and returns how many: at least one once imc_stream_next() has
 * returned false. Packets handed out before are no longer valid.
 */
size_t imc_stream_write(struct imc_stream *self, const uint8_t *bytes, size_t count);

/* The next packet, its checksum good, valid until bytes are written. false: more are needed. */
bool imc_stream_next(struct imc_stream *self, struct imc_stream_packet *packet);

/* Is an unfinished packet waiting for more bytes? */
bool imc_stream_pending(const struct imc_stream *self);

/*
 * How many bytes must come before imc_stream_next, which has returned false, can find a packet:
 * 1…IMC_PACKET_MAX. With fewer it need not be asked.
 */
size_t imc_stream_wanted(const struct imc_stream *self);

/*
 * The line is silent: looks for a whole packet behind the unfinished one. true: found, and the
 * unfinished one given up; go on with imc_stream_next. false: nothing changed.
 */
bool imc_stream_idle(struct imc_stream *self, struct imc_stream_packet *packet);

#endif
