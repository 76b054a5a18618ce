/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/imc/codec.h"

#include <string.h>

#include "core/byte_table.h"

#define SYNC_FIRST  0x54u /* of a little endian packet; the other order if it is big endian */
#define SYNC_SECOND 0xFEu
#define AT_ID       2u
#define AT_SIZE     4u
/* Every member of the union begins where the first does. */
#define FIELDS_AT   offsetof(struct imc_message, entity_state)

/* Polynomial 0x8005, reflected: a byte, shifted through the register. The bits of 0x6996 are the
 * parities of 0…15. */
#define ODD(byte)     (0x6996u >> (((byte) ^ (byte) >> 4) & 0xFu) & 1u)
#define SHIFTED(byte) ((byte) << 6 ^ (byte) << 7 ^ ODD(byte) * 0xC001u)

static uint32_t shifted(uint32_t byte)
{
#ifdef CONFIG_PHAROS_CHECKSUM_TABLES
	static const uint16_t table[256] = {BYTE_TABLE(SHIFTED)};

	return table[byte];
#else
	return SHIFTED(byte);
#endif
}

uint16_t imc_checksum(const uint8_t *bytes, size_t length)
{
	uint32_t sum = 0;

	for (size_t i = 0; i < length; i++) {
		sum = sum >> 8 ^ shifted((sum ^ bytes[i]) & 0xFFu);
	}
	return (uint16_t)sum;
}

/* --- reading ---------------------------------------------------------------------------------- */

/* A failure sticks: what follows reads zero, and the caller checks once. */
struct reader {
	const uint8_t *at;
	size_t left;
	bool big_endian;
	bool failed;
};

static const uint8_t *take(struct reader *self, size_t count)
{
	const uint8_t *const bytes = self->at;

	if (count > self->left) {
		self->failed = true;
		self->left = 0;
		return NULL;
	}
	self->at += count;
	self->left -= count;
	return bytes;
}

/* count: 1…8 bytes. */
static uint64_t get(struct reader *self, size_t count)
{
	const uint8_t *const bytes = take(self, count);
	uint64_t value = 0;

	for (size_t i = 0; i < count && bytes != NULL; i++) {
		value = value << 8 | bytes[self->big_endian ? i : count - 1 - i];
	}
	return value;
}

static uint16_t get_u16(struct reader *self)
{
	return (uint16_t)get(self, sizeof(uint16_t));
}

static double get_f64(struct reader *self)
{
	const uint64_t bits = get(self, sizeof(bits));
	double value;

	memcpy(&value, &bits, sizeof(value));
	return value;
}

static void get_text(struct reader *self, struct imc_text *text)
{
	const uint16_t length = get_u16(self);
	const uint8_t *const bytes = take(self, length);

	text->bytes = (const char *)bytes;
	text->length = bytes != NULL ? length : 0;
}

static void get_parameter(struct reader *self, struct imc_entity_parameter *parameter)
{
	self->failed = self->failed || get_u16(self) != IMC_ENTITY_PARAMETER;
	get_text(self, &parameter->name);
	get_text(self, &parameter->value);
}

/* Nobody has a use for a list with holes: all of it, or none. */
static void get_parameters(struct reader *self, struct imc_parameter_list *list)
{
	const uint16_t count = get_u16(self);
	const uint8_t *const bytes = self->at;

	for (uint16_t i = 0; i < count && !self->failed; i++) {
		struct imc_entity_parameter ignored;

		get_parameter(self, &ignored);
	}
	*list = (struct imc_parameter_list){
		.bytes = bytes,
		.size = (uint16_t)(self->at - bytes),
		.count = count,
		.big_endian = self->big_endian,
	};
}

static void get_field(struct reader *self, const struct imc_field *field, uint8_t *fields)
{
	void *const value = fields + field->offset;

	switch ((enum imc_field_kind)field->kind) {
	case IMC_U8:
		*(uint8_t *)value = (uint8_t)get(self, sizeof(uint8_t));
		break;
	case IMC_U16:
		*(uint16_t *)value = get_u16(self);
		break;
	case IMC_U32:
	case IMC_F32: {
		const uint32_t bits = (uint32_t)get(self, sizeof(bits));

		memcpy(value, &bits, sizeof(bits));
		break;
	}
	case IMC_F64: {
		const uint64_t bits = get(self, sizeof(bits));

		memcpy(value, &bits, sizeof(bits));
		break;
	}
	case IMC_TEXT:
		get_text(self, value);
		break;
	case IMC_PARAMETER_LIST:
		get_parameters(self, value);
		break;
	}
}

/* Whose sync number has this order; false: neither's. */
static bool byte_order(const uint8_t *bytes, bool *big_endian)
{
	*big_endian = bytes[0] == SYNC_SECOND;
	return (bytes[0] == SYNC_FIRST && bytes[1] == SYNC_SECOND) ||
	       (bytes[0] == SYNC_SECOND && bytes[1] == SYNC_FIRST);
}

static uint16_t u16_at(const uint8_t *bytes, bool big_endian)
{
	return (uint16_t)(big_endian ? bytes[0] << 8 | bytes[1] : bytes[1] << 8 | bytes[0]);
}

enum imc_result imc_verify(const uint8_t *bytes, size_t size, size_t *length)
{
	bool big_endian;

	*length = 0;
	if (size == 0) {
		return IMC_TRUNCATED;
	}
	if (size == 1) {
		return bytes[0] == SYNC_FIRST || bytes[0] == SYNC_SECOND ? IMC_TRUNCATED
		                                                         : IMC_BAD_SYNC;
	}
	if (!byte_order(bytes, &big_endian)) {
		return IMC_BAD_SYNC;
	}
	if (size < IMC_HEADER_SIZE) {
		return IMC_TRUNCATED;
	}

	const size_t body = IMC_HEADER_SIZE + u16_at(bytes + AT_SIZE, big_endian);

	*length = body + IMC_FOOTER_SIZE;
	if (size < *length) {
		return IMC_TRUNCATED;
	}
	return u16_at(bytes + body, big_endian) == imc_checksum(bytes, body) ? IMC_OK
	                                                                     : IMC_BAD_CHECKSUM;
}

enum imc_result imc_parse(const uint8_t *bytes, struct imc_packet *packet)
{
	struct imc_header *const header = &packet->header;
	struct reader reader = {.at = bytes + AT_ID, .left = IMC_HEADER_SIZE - AT_ID};

	(void)byte_order(bytes, &reader.big_endian);
	packet->message.id = get_u16(&reader);

	const uint16_t size = get_u16(&reader);

	header->timestamp_s = get_f64(&reader);
	header->src = get_u16(&reader);
	header->src_ent = (uint8_t)get(&reader, sizeof(header->src_ent));
	header->dst = get_u16(&reader);
	header->dst_ent = (uint8_t)get(&reader, sizeof(header->dst_ent));

	const struct imc_type *const type = imc_type_find(packet->message.id);

	if (type == NULL) {
		return IMC_UNKNOWN_ID;
	}
	reader.left = size;
	for (uint8_t i = 0; i < type->fields_count; i++) {
		get_field(&reader, &type->fields[i], (uint8_t *)&packet->message + FIELDS_AT);
	}
	return reader.failed ? IMC_BAD_PAYLOAD : IMC_OK;
}

enum imc_result imc_decode(const uint8_t *bytes, size_t size, struct imc_packet *packet)
{
	size_t length;
	const enum imc_result result = imc_verify(bytes, size, &length);

	return result == IMC_OK ? imc_parse(bytes, packet) : result;
}

/* --- writing ---------------------------------------------------------------------------------- */

/* As the reader. */
struct writer {
	uint8_t *bytes;
	size_t used;
	size_t room;
	bool failed;
};

static void put_bytes(struct writer *self, const void *bytes, size_t count)
{
	if (self->failed || count > self->room - self->used) {
		self->failed = true;
		return;
	}
	if (count > 0) {
		memcpy(self->bytes + self->used, bytes, count);
	}
	self->used += count;
}

static void put(struct writer *self, uint64_t value, size_t count)
{
	uint8_t bytes[sizeof(value)];

	for (size_t i = 0; i < count; i++) {
		bytes[i] = (uint8_t)(value >> 8 * i);
	}
	put_bytes(self, bytes, count);
}

static void put_text(struct writer *self, const struct imc_text *text)
{
	put(self, text->length, sizeof(text->length));
	put_bytes(self, text->bytes, text->length);
}

static void put_parameter(struct writer *self, const struct imc_entity_parameter *parameter)
{
	put(self, IMC_ENTITY_PARAMETER, sizeof(uint16_t));
	put_text(self, &parameter->name);
	put_text(self, &parameter->value);
}

static void put_parameters(struct writer *self, const struct imc_parameter_list *list)
{
	struct imc_parameter_list rest = *list;
	struct imc_entity_parameter parameter;

	put(self, list->count, sizeof(list->count));
	while (imc_parameters_next(&rest, &parameter)) {
		put_parameter(self, &parameter);
	}
}

static void put_field(struct writer *self, const struct imc_field *field, const uint8_t *fields)
{
	const void *const value = fields + field->offset;

	switch ((enum imc_field_kind)field->kind) {
	case IMC_U8:
		put_bytes(self, value, sizeof(uint8_t));
		break;
	case IMC_U16:
		put(self, *(const uint16_t *)value, sizeof(uint16_t));
		break;
	case IMC_U32:
	case IMC_F32: {
		uint32_t bits;

		memcpy(&bits, value, sizeof(bits));
		put(self, bits, sizeof(bits));
		break;
	}
	case IMC_F64: {
		uint64_t bits;

		memcpy(&bits, value, sizeof(bits));
		put(self, bits, sizeof(bits));
		break;
	}
	case IMC_TEXT:
		put_text(self, value);
		break;
	case IMC_PARAMETER_LIST:
		put_parameters(self, value);
		break;
	}
}

static void put_header(struct writer *self, const struct imc_packet *packet)
{
	const struct imc_header *const header = &packet->header;
	uint64_t timestamp_bits;

	memcpy(&timestamp_bits, &header->timestamp_s, sizeof(timestamp_bits));
	put(self, SYNC_FIRST, sizeof(uint8_t));
	put(self, SYNC_SECOND, sizeof(uint8_t));
	put(self, packet->message.id, sizeof(packet->message.id));
	put(self, 0, sizeof(uint16_t)); /* the size, when it is known */
	put(self, timestamp_bits, sizeof(timestamp_bits));
	put(self, header->src, sizeof(header->src));
	put(self, header->src_ent, sizeof(header->src_ent));
	put(self, header->dst, sizeof(header->dst));
	put(self, header->dst_ent, sizeof(header->dst_ent));
}

size_t imc_encode(const struct imc_packet *packet, uint8_t *bytes, size_t room)
{
	const struct imc_type *const type = imc_type_find(packet->message.id);
	struct writer writer = {
		.bytes = bytes,
		.room = room < IMC_PACKET_MAX ? room : IMC_PACKET_MAX,
	};

	if (type == NULL) {
		return 0;
	}
	put_header(&writer, packet);
	for (uint8_t i = 0; i < type->fields_count; i++) {
		put_field(&writer, &type->fields[i], (const uint8_t *)&packet->message + FIELDS_AT);
	}
	if (writer.failed) {
		return 0;
	}
	bytes[AT_SIZE] = (uint8_t)(writer.used - IMC_HEADER_SIZE);
	bytes[AT_SIZE + 1] = (uint8_t)((writer.used - IMC_HEADER_SIZE) >> 8);
	put(&writer, imc_checksum(bytes, writer.used), IMC_FOOTER_SIZE);
	return writer.failed ? 0 : writer.used;
}

/* --- lists and texts -------------------------------------------------------------------------- */

bool imc_parameters_next(struct imc_parameter_list *list, struct imc_entity_parameter *parameter)
{
	struct reader reader = {
		.at = list->bytes,
		.left = list->size,
		.big_endian = list->big_endian,
	};

	if (list->count == 0) {
		return false;
	}
	get_parameter(&reader, parameter);
	list->size = (uint16_t)(list->size - (reader.at - list->bytes));
	list->bytes = reader.at;
	list->count--;
	return !reader.failed;
}

bool imc_parameters_add(struct imc_parameter_list *list, uint8_t *buffer, size_t room,
                        const struct imc_entity_parameter *parameter)
{
	struct writer writer = {.bytes = buffer, .used = list->size, .room = room};

	put_parameter(&writer, parameter);
	if (writer.failed) {
		return false;
	}
	list->bytes = buffer;
	list->size = (uint16_t)writer.used;
	list->count++;
	return true;
}

bool imc_text_is(const struct imc_text *text, const char *string)
{
	return strlen(string) == text->length &&
	       (text->length == 0 || memcmp(text->bytes, string, text->length) == 0);
}

struct imc_text imc_text_of(const char *string)
{
	return (struct imc_text){.bytes = string, .length = (uint16_t)strlen(string)};
}
