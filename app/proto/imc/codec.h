/* SPDX-License-Identifier: Apache-2.0 */
/*
 * IMC packets: 20 bytes of header, payload, CRC-16/ARC of both. The sender's byte order holds for
 * all of it and shows in the sync number: we send little endian and accept both.
 *
 * A packet decodes whole or not at all. A payload that is too short, a text longer than what is
 * left, a list that holds another message: IMC_BAD_PAYLOAD. Bytes after the last
 * field are ignored: the sender knows a later version of the message.
 *
 * Context: any; no state. Spec: IMC 5.4.31.
 */
#ifndef PHAROS_PROTO_IMC_CODEC_H
#define PHAROS_PROTO_IMC_CODEC_H

#include "proto/imc/messages.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Whatever a packet says beside its message. timestamp_s: Unix time, any number or none. */
struct imc_header {
	double timestamp_s;
	uint16_t src;
	uint16_t dst; /* IMC_DST_ALL: everyone */
	uint8_t src_ent;
	uint8_t dst_ent; /* IMC_ENTITY_ALL: all of them */
};

struct imc_packet {
	struct imc_header header;
	struct imc_message message;
};

enum imc_result {
	IMC_OK,
	IMC_BAD_SYNC,  /* no packet begins here */
	IMC_TRUNCATED, /* fewer bytes than the header, or than it claims */
	IMC_BAD_CHECKSUM,
	IMC_UNKNOWN_ID,  /* a good packet whose message is none of ours */
	IMC_BAD_PAYLOAD, /* a good packet whose fields are not those of its message */
};

/* CRC-16/ARC. 0xBB3D for "123456789". */
uint16_t imc_checksum(const uint8_t *bytes, size_t length);

/*
 * Does a packet begin here? Decides as early as the bytes allow: IMC_TRUNCATED only while the bytes
 * may still become one. IMC_OK sets *length, IMC_HEADER_SIZE + IMC_FOOTER_SIZE and more; *length
 * may be less than size, and of an IMC_TRUNCATED with a header it is what the header claims (else
 * 0). Any claim of up to 65557 bytes is believed here; what can't be waited for is the caller's.
 */
enum imc_result imc_verify(const uint8_t *bytes, size_t size, size_t *length);

/* Decodes a packet that imc_verify() found good. The packet's texts point into bytes. */
enum imc_result imc_parse(const uint8_t *bytes, struct imc_packet *packet);

/* Both. Bytes behind the packet are ignored. */
enum imc_result imc_decode(const uint8_t *bytes, size_t size, struct imc_packet *packet);

/* Little endian. Returns the packet's length; 0: more than room, or than IMC_PACKET_MAX. */
size_t imc_encode(const struct imc_packet *packet, uint8_t *bytes, size_t room);

/* Takes the first item off the list. false: there is none. */
bool imc_parameters_next(struct imc_parameter_list *list, struct imc_entity_parameter *parameter);

/*
 * Appends to a list that was {0} at first and is built in a buffer of room <= UINT16_MAX bytes,
 * which has to live as long. false: no room, nothing changed.
 */
bool imc_parameters_add(struct imc_parameter_list *list, uint8_t *buffer, size_t room,
                        const struct imc_entity_parameter *parameter);

/* Do the bytes of a text equal those of a string? */
bool imc_text_is(const struct imc_text *text, const char *string);

/* The text of a string, which has to live as long. */
struct imc_text imc_text_of(const char *string);

#endif
