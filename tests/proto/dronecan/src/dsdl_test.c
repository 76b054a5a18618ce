/* SPDX-License-Identifier: Apache-2.0 */
/* Serialisation against the vectors that PyPI's dronecan made (tests/vectors/make_dronecan.py). */
#include <zephyr/ztest.h>

#include "proto/dronecan/bits.h"
#include "proto/dronecan/transport.h"

#include "vectors/dronecan_vectors.h"

#include <string.h>

#define BUFFER_SIZE 512

ZTEST_SUITE(dronecan_dsdl, NULL, NULL, NULL, NULL, NULL);

/* The codec of a vector, whatever its type: encode the message; decode a payload and encode it. */
#define VECTOR_CODEC(name)                                                                         \
	static bool encode_##name(const void *message, bool tao, uint8_t *data, size_t *size)      \
	{                                                                                          \
		return name##_encode(message, tao, data, BUFFER_SIZE, size);                       \
	}                                                                                          \
	static bool again_##name(const uint8_t *payload, size_t payload_size, bool tao,            \
	                         uint8_t *data, size_t *size)                                      \
	{                                                                                          \
		static struct name message;                                                        \
                                                                                                   \
		return name##_decode(&message, tao, payload, payload_size) &&                      \
		       name##_encode(&message, tao, data, BUFFER_SIZE, size);                      \
	}
DRONECAN_VECTOR_TYPES(VECTOR_CODEC)

#define VECTOR_ENCODE(name) encode_##name,
#define VECTOR_AGAIN(name)  again_##name,
static bool (*const encoders[])(const void *, bool, uint8_t *,
                                size_t *) = {DRONECAN_VECTOR_TYPES(VECTOR_ENCODE)};
static bool (*const repeaters[])(const uint8_t *, size_t, bool, uint8_t *,
                                 size_t *) = {DRONECAN_VECTOR_TYPES(VECTOR_AGAIN)};

ZTEST(dronecan_dsdl, test_every_type_encodes_as_the_reference_implementation)
{
	static uint8_t data[BUFFER_SIZE];

	for (size_t i = 0; i < ARRAY_SIZE(dronecan_vectors); i++) {
		const struct dronecan_vector *vector = &dronecan_vectors[i];
		size_t size = 0;

		zassert_true(encoders[vector->codec](vector->message, !vector->fd, data, &size),
		             "vector %zu", i);
		zassert_equal(size, vector->size, "vector %zu: %zu bytes", i, size);
		zassert_mem_equal(data, vector->payload, size, "vector %zu", i);
	}
}

/* With the test above: what is decoded is what the reference implementation had encoded. */
ZTEST(dronecan_dsdl, test_every_type_survives_decode_and_encode)
{
	static uint8_t data[BUFFER_SIZE];

	for (size_t i = 0; i < ARRAY_SIZE(dronecan_vectors); i++) {
		const struct dronecan_vector *vector = &dronecan_vectors[i];
		size_t size = 0;

		zassert_true(repeaters[vector->codec](vector->payload, vector->size, !vector->fd,
		                                      data, &size),
		             "vector %zu", i);
		zassert_equal(size, vector->size, "vector %zu", i);
		zassert_mem_equal(data, vector->payload, size, "vector %zu", i);
	}
}

/* FD has no tail array optimisation, so every length is explicit: a byte less must not decode. */
ZTEST(dronecan_dsdl, test_a_payload_cut_short_is_refused)
{
	static uint8_t data[BUFFER_SIZE];

	for (size_t i = 0; i < ARRAY_SIZE(dronecan_vectors); i++) {
		const struct dronecan_vector *vector = &dronecan_vectors[i];
		size_t size;

		if (!vector->fd) {
			continue;
		}
		for (size_t cut = 0; cut < vector->size; cut++) {
			zassert_false(
				repeaters[vector->codec](vector->payload, cut, false, data, &size),
				"vector %zu cut to %zu", i, cut);
		}
	}
}

ZTEST(dronecan_dsdl, test_fields_decode_to_their_values)
{
	/* NodeStatus of the reference, then one with every field set: 0x12345678 s, ERROR,
	 * MAINTENANCE, sub mode 5, code 0xABCD.
	 */
	static const uint8_t payload[] = {0x78, 0x56, 0x34, 0x12, 0x95, 0xCD, 0xAB};
	struct dronecan_node_status status;

	zassert_true(dronecan_node_status_decode(&status, true, payload, sizeof(payload)));
	zassert_equal(status.uptime_sec, 0x12345678);
	zassert_equal(status.health, DRONECAN_NODE_STATUS_HEALTH_ERROR);
	zassert_equal(status.mode, DRONECAN_NODE_STATUS_MODE_MAINTENANCE);
	zassert_equal(status.sub_mode, 5);
	zassert_equal(status.vendor_specific_status_code, 0xABCD);
}

ZTEST(dronecan_dsdl, test_lengths_and_tags_out_of_range_are_refused)
{
	/* FD: 2 ids, then 5 bits of length = 17 of at most 16. */
	static const uint8_t too_long[32] = {0x00, 17u << 3};
	/* GetSet on FD: index 0, tag 7 of 5. */
	static const uint8_t no_tag[32] = {0x00, 0x07};
	/* Classic: 121 bytes of buffer after the 6 of the header. */
	static const uint8_t targetted[127];
	struct dronecan_dynamic_node_id_allocation allocation;
	struct dronecan_param_get_set_request request;
	struct dronecan_tunnel_targetted tunnel;
	struct dronecan_param_value *value = &request.value;
	uint8_t data[BUFFER_SIZE];
	size_t size;

	zassert_false(dronecan_dynamic_node_id_allocation_decode(&allocation, false, too_long,
	                                                         sizeof(too_long)));
	zassert_false(
		dronecan_param_get_set_request_decode(&request, false, no_tag, sizeof(no_tag)));
	zassert_false(dronecan_tunnel_targetted_decode(&tunnel, true, targetted, 127));
	zassert_true(dronecan_tunnel_targetted_decode(&tunnel, true, targetted, 126));

	memset(&tunnel, 0, sizeof(tunnel));
	tunnel.buffer_len = 121;
	zassert_false(dronecan_tunnel_targetted_encode(&tunnel, true, data, sizeof(data), &size));
	memset(&request, 0, sizeof(request));
	value->tag = DRONECAN_PARAM_VALUE_STRING_VALUE;
	value->string_value_len = 129;
	zassert_false(
		dronecan_param_get_set_request_encode(&request, true, data, sizeof(data), &size));
}

ZTEST(dronecan_dsdl, test_no_room_is_refused_and_not_overrun)
{
	const struct dronecan_node_status status = {.uptime_sec = 0xFFFFFFFF};
	uint8_t data[8];
	size_t size;

	for (size_t room = 0; room < 7; room++) {
		memset(data, 0x5A, sizeof(data));
		zassert_false(dronecan_node_status_encode(&status, true, data, room, &size));
		zassert_equal(data[room], 0x5A, "byte %zu", room);
	}
}

ZTEST(dronecan_dsdl, test_integers_saturate)
{
	const struct dronecan_node_status status = {.health = 200, .mode = 9, .sub_mode = 255};
	const struct dronecan_tunnel_targetted tunnel = {.serial_id = -100, .baudrate = UINT32_MAX};
	struct dronecan_tunnel_targetted tunnel_back;
	uint8_t data[BUFFER_SIZE];
	size_t size;

	zassert_true(dronecan_node_status_encode(&status, true, data, sizeof(data), &size));
	zassert_equal(data[4], 0xFF); /* 3, 7 and 7: the most that 2, 3 and 3 bits hold */
	zassert_true(dronecan_tunnel_targetted_encode(&tunnel, true, data, sizeof(data), &size));
	zassert_true(dronecan_tunnel_targetted_decode(&tunnel_back, true, data, size));
	zassert_equal(tunnel_back.serial_id, -16);     /* int5 */
	zassert_equal(tunnel_back.baudrate, 0xFFFFFF); /* uint24 */
}

static float single(uint32_t bits)
{
	float value;

	memcpy(&value, &bits, sizeof(value));
	return value;
}

ZTEST(dronecan_dsdl, test_float16_rounds_as_the_reference_implementation)
{
	for (size_t i = 0; i < ARRAY_SIZE(dronecan_halves); i++) {
		zassert_equal(dronecan_float16_from_float(single(dronecan_halves[i].single)),
		              dronecan_halves[i].half, "%08x", dronecan_halves[i].single);
	}
}

ZTEST(dronecan_dsdl, test_float16_values)
{
	/* IEEE 754-2008 binary16: one; the largest; the smallest normal and subnormal; 1/3. */
	zassert_equal(dronecan_float_from_float16(0x3C00), 1.0f);
	zassert_equal(dronecan_float_from_float16(0xFBFF), -65504.0f);
	zassert_equal(dronecan_float_from_float16(0x0400), 0x1p-14f);
	zassert_equal(dronecan_float_from_float16(0x0001), 0x1p-24f);
	zassert_equal(dronecan_float_from_float16(0x3555), 0x1.554p-2f);
	/* DSDL's float16 is saturated: infinity becomes the largest. */
	zassert_equal(dronecan_float16_from_float(single(0x7F800000)), 0x7BFF);
	zassert_equal(dronecan_float16_from_float(-1e30f), 0xFBFF);
	zassert_equal(dronecan_float16_from_float(1e-30f), 0);
	/* NaN stays NaN, both ways, and infinity is received as such. */
	zassert_equal(dronecan_float16_from_float(single(0x7FC00000)) & 0x7C00, 0x7C00);
	zassert_not_equal(dronecan_float16_from_float(single(0x7FC00000)) & 0x03FF, 0);
	zassert_true(dronecan_float_from_float16(0x7E00) != dronecan_float_from_float16(0x7E00));
	zassert_equal(dronecan_float_from_float16(0xFC00), single(0xFF800000));
}

ZTEST(dronecan_dsdl, test_every_float16_survives)
{
	for (uint32_t half = 0; half <= 0xFFFF; half++) {
		if ((half & 0x7C00) != 0x7C00) {
			const float value = dronecan_float_from_float16((uint16_t)half);

			zassert_equal(dronecan_float16_from_float(value), half, "%04x", half);
		}
	}
}

ZTEST(dronecan_dsdl, test_bits_fill_bytes_from_the_top)
{
	struct dronecan_writer writer;
	struct dronecan_reader reader;
	uint8_t data[4] = {0};

	/* 5 bits 10101, 11 bits 0x723 (low byte first: 00100011, then 111), 3 bits 110. */
	dronecan_writer_init(&writer, data, 3);
	dronecan_put(&writer, 0x15, 5);
	dronecan_put(&writer, 0x723, 11);
	dronecan_put(&writer, 6, 3);
	zassert_equal(data[0], 0xA9); /* 10101 001 */
	zassert_equal(data[1], 0x1F); /* 00011 111 */
	zassert_equal(data[2], 0xC0); /* 110 */
	zassert_equal(dronecan_bytes_written(&writer), 3);
	dronecan_put(&writer, 0, 6);
	zassert_true(writer.failed);

	dronecan_reader_init(&reader, data, 3);
	zassert_equal(dronecan_get(&reader, 5), 0x15);
	zassert_equal(dronecan_get(&reader, 11), 0x723);
	zassert_equal(dronecan_get_signed(&reader, 3), -2);
	zassert_equal(dronecan_get(&reader, 6), 0);
	zassert_true(reader.failed);
	zassert_equal(dronecan_get(&reader, 1), 0, "a failure sticks");
}
