/* SPDX-License-Identifier: Apache-2.0 */
/*
 * DSDL bit streams (DroneCAN specification, "Data serialization"): a scalar goes out as its little
 * endian bytes, the highest byte holding only the bits left over; bits fill each byte of the stream
 * from its most significant end. The generated serialisation (generate.py) is made of these.
 *
 * A failure (stream too short, or no room) sticks: everything after it does nothing and reads zero,
 * so the caller checks once, at the end. Any context; no state of their own.
 */
#ifndef PHAROS_PROTO_DRONECAN_BITS_H
#define PHAROS_PROTO_DRONECAN_BITS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct dronecan_writer {
	uint8_t *data;
	size_t size_bits;
	size_t position;
	bool failed;
};

struct dronecan_reader {
	const uint8_t *data;
	size_t size_bits;
	size_t position;
	bool failed;
};

void dronecan_writer_init(struct dronecan_writer *self, uint8_t *data, size_t size);
void dronecan_reader_init(struct dronecan_reader *self, const uint8_t *data, size_t size);

/* count: 1...64 bits, the low ones of value. */
void dronecan_put(struct dronecan_writer *self, uint64_t value, unsigned int count);
void dronecan_put_bytes(struct dronecan_writer *self, const uint8_t *bytes, size_t count);
void dronecan_put_float16(struct dronecan_writer *self, float value);
void dronecan_put_float32(struct dronecan_writer *self, float value);

uint64_t dronecan_get(struct dronecan_reader *self, unsigned int count);
int64_t dronecan_get_signed(struct dronecan_reader *self, unsigned int count);
void dronecan_get_bytes(struct dronecan_reader *self, uint8_t *bytes, size_t count);
float dronecan_get_float16(struct dronecan_reader *self);
float dronecan_get_float32(struct dronecan_reader *self);

/* Whole bytes that are left: what tail array optimisation takes for the last array's length. */
size_t dronecan_bytes_left(const struct dronecan_reader *self);
/* Bytes written, the last one padded with zero bits. */
size_t dronecan_bytes_written(const struct dronecan_writer *self);

/* DSDL "saturated": the nearest value that count bits hold (count: 1...63). */
uint64_t dronecan_saturate(uint64_t value, unsigned int count);
int64_t dronecan_saturate_signed(int64_t value, unsigned int count);

/* IEEE 754 half precision. To half: saturated to +-65504 (infinity too), half a step rounds away
 * from zero, NaN stays NaN. From half: exact.
 */
uint16_t dronecan_float16_from_float(float value);
float dronecan_float_from_float16(uint16_t half);

#endif
