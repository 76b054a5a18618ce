/* SPDX-License-Identifier: Apache-2.0 */
/* The codec against golden packets (tests/vectors/make_imc.py says where they come from). */
#include "proto/imc/codec.h"
#include "proto/imc/seconds.h"

#include <string.h>

#include <zephyr/ztest.h>

#include "vectors/imc_vectors.h"

ZTEST_SUITE(imc_codec, NULL, NULL, NULL, NULL, NULL);

static struct imc_packet packet;
static uint8_t bytes[IMC_PACKET_MAX];

/* IMC: CRC-16/ARC, check value of its catalogue. */
ZTEST(imc_codec, test_checksum)
{
	zassert_equal(imc_checksum((const uint8_t *)"123456789", 9), 0xBB3D);
	zassert_equal(imc_checksum(NULL, 0), 0);
}

ZTEST(imc_codec, test_every_vector_encodes_from_its_values)
{
	for (size_t i = 0; i < ARRAY_SIZE(imc_vectors); i++) {
		const struct imc_vector *const vector = &imc_vectors[i];

		zassert_equal(imc_encode(&vector->packet, bytes, sizeof(bytes)), vector->length,
		              "%s", vector->name);
		zassert_mem_equal(bytes, vector->little, vector->length, "%s", vector->name);
	}
}

/* What comes out of either byte order is what the same values encode to: all of them came out. */
ZTEST(imc_codec, test_every_vector_decodes_to_its_values_in_both_byte_orders)
{
	for (size_t i = 0; i < ARRAY_SIZE(imc_vectors); i++) {
		const struct imc_vector *const vector = &imc_vectors[i];
		const uint8_t *const orders[] = {vector->little, vector->big};

		for (size_t order = 0; order < ARRAY_SIZE(orders); order++) {
			memset(&packet, 0xA5, sizeof(packet));
			zassert_equal(imc_decode(orders[order], vector->length, &packet), IMC_OK,
			              "%s", vector->name);
			zassert_equal(packet.message.id, vector->packet.message.id);
			zassert_equal(packet.header.src, vector->packet.header.src);
			zassert_equal(packet.header.src_ent, vector->packet.header.src_ent);
			zassert_equal(packet.header.dst, vector->packet.header.dst);
			zassert_equal(packet.header.dst_ent, vector->packet.header.dst_ent);
			memset(bytes, 0, sizeof(bytes));
			zassert_equal(imc_encode(&packet, bytes, sizeof(bytes)), vector->length);
			zassert_mem_equal(bytes, vector->little, vector->length, "%s",
			                  vector->name);
		}
	}
}

/* A few of them once more, value by value: imc.json, "SetPWM", "PowerChannelControl" and so on. */
ZTEST(imc_codec, test_values_by_name)
{
	bool pwm = false;
	bool channel = false;
	bool down = false;

	for (size_t i = 0; i < ARRAY_SIZE(imc_vectors); i++) {
		const struct imc_vector *const vector = &imc_vectors[i];
		const struct imc_message *const message = &packet.message;

		zassert_equal(imc_decode(vector->big, vector->length, &packet), IMC_OK);
		if (strcmp(vector->name, "PowerChannelControl op3") == 0) {
			zassert_true(imc_text_is(&message->power_channel_control.name, "Radio"));
			zassert_equal(message->power_channel_control.op, 3);
			zassert_equal(message->power_channel_control.sched_time, 30.0);
			channel = true;
		} else if (strcmp(vector->name, "PowerOperation op6") == 0) {
			zassert_equal(message->power_operation.time_remain, 75.0f);
			zassert_equal(message->power_operation.sched_time, 1763849000.5);
			zassert_equal(packet.header.timestamp_s, 1700000000.25);
			down = true;
		} else if (strcmp(vector->name, "SetPWM servo") == 0) {
			zassert_equal(message->pwm.id, 1);
			zassert_equal(message->pwm.period, 20000);
			zassert_equal(message->pwm.duty_cycle, 1500);
			pwm = true;
		}
	}
	zassert_true(pwm && channel && down, "the vectors are there");
}

ZTEST(imc_codec, test_every_malformed_packet_is_refused)
{
	for (size_t i = 0; i < ARRAY_SIZE(imc_malformed); i++) {
		const struct imc_malformed *const vector = &imc_malformed[i];
		const enum imc_result result = imc_decode(vector->bytes, vector->length, &packet);

		zassert_equal(result == IMC_OK, vector->accepted, "%s: %d", vector->name, result);
	}
}

/* Truncated anywhere, in its bytes or in its payload, a packet is refused. */
ZTEST(imc_codec, test_every_vector_is_refused_when_cut)
{
	for (size_t i = 0; i < ARRAY_SIZE(imc_vectors); i++) {
		const struct imc_vector *const vector = &imc_vectors[i];
		const size_t payload = vector->length - IMC_HEADER_SIZE - IMC_FOOTER_SIZE;

		for (size_t length = 0; length < vector->length; length++) {
			zassert_equal(imc_decode(vector->big, length, &packet), IMC_TRUNCATED);
		}
		for (size_t size = 0; size < payload; size++) {
			uint16_t crc;

			memcpy(bytes, vector->little, IMC_HEADER_SIZE + size);
			bytes[4] = (uint8_t)size;
			bytes[5] = (uint8_t)(size >> 8);
			crc = imc_checksum(bytes, IMC_HEADER_SIZE + size);
			bytes[IMC_HEADER_SIZE + size] = (uint8_t)crc;
			bytes[IMC_HEADER_SIZE + size + 1] = (uint8_t)(crc >> 8);
			zassert_equal(imc_decode(bytes, sizeof(bytes), &packet), IMC_BAD_PAYLOAD,
			              "%s, %zu bytes", vector->name, size);
		}
	}
}

ZTEST(imc_codec, test_a_message_that_does_not_fit_is_not_encoded)
{
	for (size_t i = 0; i < ARRAY_SIZE(imc_vectors); i++) {
		const struct imc_vector *const vector = &imc_vectors[i];

		for (size_t room = 0; room < vector->length; room++) {
			memset(bytes, 0xA5, sizeof(bytes));
			zassert_equal(imc_encode(&vector->packet, bytes, room), 0);
			zassert_equal(bytes[room], 0xA5, "nothing behind the room");
		}
	}
	packet = (struct imc_packet){.message = {.id = 64999}};
	zassert_equal(imc_encode(&packet, bytes, sizeof(bytes)), 0, "no message of ours");
}

/* IMC: an inline message begins with its id; a list of others than EntityParameter is refused. */
ZTEST(imc_codec, test_parameter_lists)
{
	static const char *const names[] = {"A", "BB", ""};
	struct imc_parameter_list list = {0};
	struct imc_entity_parameter parameter;
	uint8_t buffer[64];

	for (size_t i = 0; i < ARRAY_SIZE(names); i++) {
		parameter.name = imc_text_of(names[i]);
		parameter.value = imc_text_of("7");
		zassert_true(imc_parameters_add(&list, buffer, sizeof(buffer), &parameter));
	}
	zassert_equal(list.size, 3 * (2 + 2 + 2) + 3 + 3);
	packet = (struct imc_packet){
		.message = {.id = IMC_SET_ENTITY_PARAMETERS,
	                    .entity_parameters = {.name = imc_text_of("Lamp"), .params = list}},
	};
	const size_t length = imc_encode(&packet, bytes, sizeof(bytes));

	zassert_equal(imc_decode(bytes, length, &packet), IMC_OK);
	list = packet.message.entity_parameters.params;
	for (size_t i = 0; i < ARRAY_SIZE(names); i++) {
		zassert_true(imc_parameters_next(&list, &parameter));
		zassert_true(imc_text_is(&parameter.name, names[i]));
		zassert_true(imc_text_is(&parameter.value, "7"));
	}
	zassert_false(imc_parameters_next(&list, &parameter));

	/* header 20, name 2 + 4, count 2: the first item's id, 801 */
	zassert_equal(bytes[28], 0x21);
	bytes[28] = 0x22;
	const uint16_t crc = imc_checksum(bytes, length - 2);

	bytes[length - 2] = (uint8_t)crc;
	bytes[length - 1] = (uint8_t)(crc >> 8);
	zassert_equal(imc_decode(bytes, length, &packet), IMC_BAD_PAYLOAD);
}

ZTEST(imc_codec, test_a_parameter_list_that_is_full_stays_as_it_is)
{
	const struct imc_entity_parameter parameter = {.name = imc_text_of("NAME"),
	                                               .value = imc_text_of("1")};
	struct imc_parameter_list list = {0};
	uint8_t buffer[11];

	zassert_true(imc_parameters_add(&list, buffer, sizeof(buffer), &parameter));
	zassert_false(imc_parameters_add(&list, buffer, sizeof(buffer), &parameter));
	zassert_equal(list.count, 1);
	zassert_equal(list.size, 11);
}

ZTEST(imc_codec, test_texts)
{
	const struct imc_text text = {"Lamp\0x", 4};
	const struct imc_text none = {NULL, 0};

	zassert_true(imc_text_is(&text, "Lamp"));
	zassert_false(imc_text_is(&text, "Lam"));
	zassert_false(imc_text_is(&text, "Lamp "));
	zassert_false(imc_text_is(&text, "lamp"));
	zassert_true(imc_text_is(&none, ""));
	zassert_false(imc_text_is(&none, "Lamp"));
}

ZTEST(imc_codec, test_seconds_and_microseconds)
{
	static const struct {
		double seconds;
		int64_t us;
	} rows[] = {
		{0.0, 0},
		{-0.0, 0},
		{1.0, 1000000},
		{-1.0, -1000000},
		{0.0000006, 1},
		{0.0000004, 0},
		{5e-324, 0},
		{0.25, 250000},
		{31536000.0, 31536000000000},           /* a year */
		{1763849000.5, 1763849000500000},       /* imc.json, PowerOperation */
		{2305843009212.0, 2305843009212000000}, /* near TIME_MAX_US */
	};
	static const double refused[] = {
		__builtin_nan(""), __builtin_inf(), -__builtin_inf(), 1e300, 2305843009213.7, 4e12,
	};
	int64_t us;

	for (size_t i = 0; i < ARRAY_SIZE(rows); i++) {
		zassert_true(imc_seconds_to_us(rows[i].seconds, &us), "row %zu", i);
		zassert_equal(us, rows[i].us, "row %zu", i);
	}
	for (size_t i = 0; i < ARRAY_SIZE(refused); i++) {
		zassert_false(imc_seconds_to_us(refused[i], &us), "row %zu", i);
	}
	zassert_equal(imc_seconds_from_us(0), 0.0);
	zassert_equal(imc_seconds_from_us(1000000), 1.0);
	zassert_equal(imc_seconds_from_us(250000), 0.25);
	zassert_equal(imc_seconds_from_us(1700000000250000), 1700000000.25);
	for (int64_t time_us = 1; time_us < (1ll << 51); time_us = 3 * time_us + 1) {
		zassert_true(imc_seconds_to_us(imc_seconds_from_us(time_us), &us));
		zassert_equal(us, time_us, "there and back");
	}
}
