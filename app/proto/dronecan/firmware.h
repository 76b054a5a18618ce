/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Firmware update over DroneCAN; sans-IO: answers BeginFirmwareUpdate, then reads the image from
 * the server with file.Read, a block of 256 bytes at a time, the shorter one being the last.
 *
 * Each block is handed out once and stays valid until dronecan_firmware_next() asks for the one
 * after it, so that slow flash sets the pace. A request without an answer is repeated; ten in vain,
 * or an error of the server's, end the update. A late answer to an earlier request is told by its
 * transfer id and ignored.
 *
 * Context: the thread that owns it, no locks inside. Spec: DroneCAN DSDL 40.BeginFirmwareUpdate,
 * 48.Read.
 */
#ifndef PHAROS_PROTO_DRONECAN_FIRMWARE_H
#define PHAROS_PROTO_DRONECAN_FIRMWARE_H

#include "proto/dronecan/node.h"
#include "proto/dronecan/transport.h"

#include <stdbool.h>
#include <stdint.h>

enum dronecan_firmware_state {
	DRONECAN_FIRMWARE_IDLE,
	DRONECAN_FIRMWARE_HELD,    /* until dronecan_firmware_next() or _stop() */
	DRONECAN_FIRMWARE_READING, /* an answer is to come */
};

enum dronecan_firmware_event {
	DRONECAN_FIRMWARE_NOTHING,
	DRONECAN_FIRMWARE_BEGIN,  /* make room, then dronecan_firmware_next() */
	DRONECAN_FIRMWARE_BLOCK,  /* data, size, is_last */
	DRONECAN_FIRMWARE_FAILED, /* error: the server's, DRONECAN_FILE_ERROR_…; 0: silence */
};

struct dronecan_firmware_outbox {
	enum dronecan_firmware_event event;
	const uint8_t *data;
	uint16_t size;
	bool is_last;
	int16_t error;
};

struct dronecan_firmware_stats {
	uint32_t begun;
	uint32_t
		refused; /* BeginFirmwareUpdate while one is under way, or without a place for it */
	uint32_t repeated;
	uint32_t ignored; /* answers that nobody waits for */
};

struct dronecan_firmware {
	struct dronecan_transport *transport;
	struct dronecan_node *node;
	const char *unavailable; /* why there is no update; NULL: there is */
	bool is_taken;           /* by an update that came another way; its owner sets it */
	enum dronecan_firmware_state state;
	uint64_t offset;
	int64_t repeat_us;
	uint8_t server;
	uint8_t tries;
	uint8_t transfer_id; /* of the last request */
	struct dronecan_firmware_stats stats;
	struct dronecan_file_read_request request;
	struct dronecan_file_read_response response;
};

/* unavailable: constant, at most 127 bytes, told to whoever asks; NULL: updates are possible. */
void dronecan_firmware_init(struct dronecan_firmware *self, struct dronecan_node *node,
                            const char *unavailable);

/* A transfer of one of its types (others: ignored). *out is overwritten. */
void dronecan_firmware_receive(struct dronecan_firmware *self, int64_t now_us,
                               const struct dronecan_transfer *transfer,
                               struct dronecan_firmware_outbox *out);

/* The block is stored, or room is made: read on. Held, asserted. */
void dronecan_firmware_next(struct dronecan_firmware *self, int64_t now_us);

/* The image is whole, or given up: another may begin. */
void dronecan_firmware_stop(struct dronecan_firmware *self);

/* At its deadline or before. *out is overwritten. */
void dronecan_firmware_step(struct dronecan_firmware *self, int64_t now_us,
                            struct dronecan_firmware_outbox *out);
int64_t dronecan_firmware_deadline_us(const struct dronecan_firmware *self);

#endif
