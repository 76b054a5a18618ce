/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A request of MAVLink FTP and its answer, between ftp.c, which reads and writes them, and
 * upload.c.
 */
#ifndef PHAROS_PROTO_MAVLINK_FTP_REQUEST_H
#define PHAROS_PROTO_MAVLINK_FTP_REQUEST_H

#include "proto/mavlink/dialect.h"
#include "proto/mavlink/endpoint.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct mavlink_ftp_request {
	uint32_t offset;
	uint16_t sequence;
	uint8_t session;
	uint8_t opcode;
	uint8_t size;     /* at most MAVLINK_FTP_DATA_MAX once it is carried out */
	bool to_all;      /* to no component in particular */
	const char *path; /* without leading '/', not terminated */
	size_t path_length;
	const struct mavlink_frame *frame;
};

/* What an operation fills in: data is its place in wire, MAVLINK_FTP_DATA_MAX bytes. */
struct mavlink_ftp_answer {
	uint8_t session;
	uint8_t size;
	uint8_t *data;
	mavlink_file_transfer_protocol_t wire;
};
void mavlink_ftp_answer_init(struct mavlink_ftp_answer *self, uint8_t session);

/* Instead of a MAV_FTP_ERR: no answer now; if it is owed, it comes with a step. */
#define MAVLINK_FTP_LATER 0xFFu

/* Byte i of the request's data; what the frame left out is 0. */
uint8_t mavlink_ftp_data_byte(const struct mavlink_ftp_request *request, uint8_t i);

void mavlink_ftp_put_le(uint8_t *to, uint32_t value, uint8_t bytes);

/* A file's checksum with one byte more: from 0, not inverted (mavlink.io/en/guide/crc.html). */
uint32_t mavlink_ftp_crc32(uint32_t crc, uint8_t byte);

/*
 * Answers request to the client of that link and ids: error is a MAV_FTP_ERR. The outbox has room
 * (asserted). answer becomes the frame.
 */
struct mavlink_ftp_client {
	uint8_t link;
	uint8_t system;
	uint8_t component;
};
void mavlink_ftp_send(const struct mavlink_context *context,
                      const struct mavlink_ftp_client *client,
                      const struct mavlink_ftp_request *request, uint8_t error,
                      struct mavlink_ftp_answer *answer);

#endif
