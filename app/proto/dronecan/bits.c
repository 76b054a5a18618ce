/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/bits.h"

#include <string.h>

#define FLOAT16_MAX      0x7BFFu
#define FLOAT16_INFINITY 0x7C00u
#define FLOAT16_NAN      0x7E00u
#define FLOAT32_INFINITY 0x7F800000u
/* The exponent biases' difference, 127 - 15. */
#define BIAS_DIFFERENCE  112u

_Static_assert(sizeof(float) == 4, "float is IEEE 754 single precision");

void dronecan_writer_init(struct dronecan_writer *self, uint8_t *data, size_t size)
{
	self->data = data;
	self->size_bits = size * 8u;
	self->position = 0;
	self->failed = false;
}

void dronecan_reader_init(struct dronecan_reader *self, const uint8_t *data, size_t size)
{
	self->data = data;
	self->size_bits = size * 8u;
	self->position = 0;
	self->failed = false;
}

/* value's low count bits, 1...8, most significant first; there is room. */
static void put_bits(struct dronecan_writer *self, uint8_t value, unsigned int count)
{
	const size_t byte = self->position / 8u;
	const unsigned int used = (unsigned int)(self->position % 8u);
	const unsigned int window = ((unsigned int)value << (16u - count)) >> used;

	if (used == 0) {
		self->data[byte] = 0;
	}
	self->data[byte] |= (uint8_t)(window >> 8);
	if (used + count > 8u) {
		self->data[byte + 1u] = (uint8_t)window;
	}
	self->position += count;
}

void dronecan_put(struct dronecan_writer *self, uint64_t value, unsigned int count)
{
	if (self->failed || self->size_bits - self->position < count) {
		self->failed = true;
		return;
	}
	while (count > 0) {
		const unsigned int part = (count < 8u) ? count : 8u;

		put_bits(self, (uint8_t)(value & (0xFFu >> (8u - part))), part);
		value >>= 8;
		count -= part;
	}
}

void dronecan_put_bytes(struct dronecan_writer *self, const uint8_t *bytes, size_t count)
{
	if (self->failed || (self->size_bits - self->position) / 8u < count) {
		self->failed = true;
		return;
	}
	if (self->position % 8u == 0) {
		memcpy(&self->data[self->position / 8u], bytes, count);
		self->position += count * 8u;
		return;
	}
	for (size_t i = 0; i < count; i++) {
		put_bits(self, bytes[i], 8);
	}
}

void dronecan_put_float16(struct dronecan_writer *self, float value)
{
	dronecan_put(self, dronecan_float16_from_float(value), 16);
}

void dronecan_put_float32(struct dronecan_writer *self, float value)
{
	uint32_t bits;

	memcpy(&bits, &value, sizeof(bits));
	dronecan_put(self, bits, 32);
}

/* 1...8 bits; they are there. */
static uint8_t get_bits(struct dronecan_reader *self, unsigned int count)
{
	const size_t byte = self->position / 8u;
	const unsigned int used = (unsigned int)(self->position % 8u);
	unsigned int window = (unsigned int)self->data[byte] << 8;

	if (used + count > 8u) {
		window |= self->data[byte + 1u];
	}
	self->position += count;
	return (uint8_t)(((window << used) & 0xFFFFu) >> (16u - count));
}

uint64_t dronecan_get(struct dronecan_reader *self, unsigned int count)
{
	uint64_t value = 0;

	if (self->failed || self->size_bits - self->position < count) {
		self->failed = true;
		return 0;
	}
	for (unsigned int shift = 0; shift < count; shift += 8u) {
		const unsigned int part = (count - shift < 8u) ? count - shift : 8u;

		value |= (uint64_t)get_bits(self, part) << shift;
	}
	return value;
}

int64_t dronecan_get_signed(struct dronecan_reader *self, unsigned int count)
{
	const uint64_t value = dronecan_get(self, count);
	const uint64_t sign = (uint64_t)1 << (count - 1u);

	/* Extends the sign without a shift of a negative number. */
	return (int64_t)((value ^ sign) - sign);
}

void dronecan_get_bytes(struct dronecan_reader *self, uint8_t *bytes, size_t count)
{
	if (self->failed || (self->size_bits - self->position) / 8u < count) {
		self->failed = true;
		return;
	}
	if (self->position % 8u == 0) {
		memcpy(bytes, &self->data[self->position / 8u], count);
		self->position += count * 8u;
		return;
	}
	for (size_t i = 0; i < count; i++) {
		bytes[i] = get_bits(self, 8);
	}
}

float dronecan_get_float16(struct dronecan_reader *self)
{
	return dronecan_float_from_float16((uint16_t)dronecan_get(self, 16));
}

float dronecan_get_float32(struct dronecan_reader *self)
{
	const uint32_t bits = (uint32_t)dronecan_get(self, 32);
	float value;

	memcpy(&value, &bits, sizeof(value));
	return value;
}

size_t dronecan_bytes_left(const struct dronecan_reader *self)
{
	return self->failed ? 0 : (self->size_bits - self->position) / 8u;
}

size_t dronecan_bytes_written(const struct dronecan_writer *self)
{
	return (self->position + 7u) / 8u;
}

uint64_t dronecan_saturate(uint64_t value, unsigned int count)
{
	const uint64_t max = ((uint64_t)1 << count) - 1u;

	return (value > max) ? max : value;
}

int64_t dronecan_saturate_signed(int64_t value, unsigned int count)
{
	const int64_t max = ((int64_t)1 << (count - 1u)) - 1;

	if (value > max) {
		return max;
	}
	return (value < -max - 1) ? -max - 1 : value;
}

uint16_t dronecan_float16_from_float(float value)
{
	uint32_t bits;

	memcpy(&bits, &value, sizeof(bits));
	const uint16_t sign = (uint16_t)((bits >> 16) & 0x8000u);
	const uint32_t magnitude = bits & 0x7FFFFFFFu;
	const uint32_t exponent = magnitude >> 23;
	uint32_t half;

	if (magnitude > FLOAT32_INFINITY) {
		return (uint16_t)(sign | FLOAT16_NAN);
	}
	if (exponent > BIAS_DIFFERENCE) {
		/* Normal: 13 bits of the mantissa go, a carry may run into the exponent. */
		half = (magnitude - (BIAS_DIFFERENCE << 23) + 0x1000u) >> 13;
	} else if (exponent > BIAS_DIFFERENCE - 12u) {
		/* Subnormal: the implicit one becomes visible and moves right. */
		const uint32_t mantissa = (magnitude & 0x7FFFFFu) | 0x800000u;
		const uint32_t shift = BIAS_DIFFERENCE + 14u - exponent;

		half = (mantissa + ((uint32_t)1 << (shift - 1u))) >> shift;
	} else {
		half = 0;
	}
	return (uint16_t)(sign | (half > FLOAT16_MAX ? FLOAT16_MAX : half));
}

float dronecan_float_from_float16(uint16_t half)
{
	const uint32_t sign = (uint32_t)(half & 0x8000u) << 16;
	uint32_t exponent = (half >> 10) & 0x1Fu;
	uint32_t mantissa = half & 0x3FFu;
	uint32_t bits;
	float value;

	if ((half & FLOAT16_INFINITY) == FLOAT16_INFINITY) {
		bits = FLOAT32_INFINITY | (mantissa << 13);
	} else if (exponent == 0 && mantissa == 0) {
		bits = 0;
	} else {
		if (exponent == 0) {
			/* Subnormal: normalise; at most ten steps. */
			exponent = 1;
			while ((mantissa & 0x400u) == 0) {
				mantissa <<= 1;
				exponent--;
			}
			mantissa &= 0x3FFu;
		}
		bits = ((exponent + BIAS_DIFFERENCE) << 23) | (mantissa << 13);
	}
	bits |= sign;
	memcpy(&value, &bits, sizeof(value));
	return value;
}
