/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/firmware.h"

#include <string.h>

#include "core/assert.h"

static const struct device_who who = {.way = SECURITY_WAY_DRONECAN};

#define PRIORITY_READ  24u
#define READ_REPEAT_US (1 * US_PER_S)
#define READ_TRIES_MAX 10u

void dronecan_firmware_init(struct dronecan_firmware *self, struct dronecan_node *node,
                            const char *unavailable)
{
	memset(self, 0, sizeof(*self));
	self->node = node;
	self->transport = node->transport;
	self->unavailable = unavailable;
	self->repeat_us = TIME_NEVER_US;
}

/* --- BeginFirmwareUpdate ---------------------------------------------------------------------- */

static bool answer(struct dronecan_firmware *self, int64_t now_us,
                   const struct dronecan_transfer *request, uint8_t error, const char *text)
{
	struct dronecan_file_begin_firmware_update_response response = {.error = error};
	uint8_t data[DRONECAN_FILE_BEGIN_FIRMWARE_UPDATE_RESPONSE_MAX_SIZE];
	size_t size;

	response.optional_error_message_len = (uint8_t)strlen(text);
	memcpy(response.optional_error_message, text, response.optional_error_message_len);
	return dronecan_file_begin_firmware_update_response_encode(
		       &response, !(request->fd && self->transport->fd), data, sizeof(data),
		       &size) &&
	       dronecan_node_respond(self->node, now_us, request, data, size);
}

/* An asker whose answer was lost asks again: for the same file that is no new update. */
static bool is_the_same(const struct dronecan_firmware *self, uint8_t server,
                        const struct dronecan_file_path *path)
{
	return self->state != DRONECAN_FIRMWARE_IDLE && self->server == server &&
	       self->request.path.path_len == path->path_len &&
	       memcmp(self->request.path.path, path->path, path->path_len) == 0;
}

static void begin(struct dronecan_firmware *self, int64_t now_us,
                  const struct dronecan_transfer *transfer, struct dronecan_firmware_outbox *out)
{
	struct dronecan_file_begin_firmware_update_request message;

	if (!dronecan_file_begin_firmware_update_request_decode(&message, !transfer->fd,
	                                                        transfer->data, transfer->size)) {
		self->node->stats.malformed++;
		return;
	}
	/* "If this field is zero, the caller's Node ID will be used instead." */
	const uint8_t server =
		message.source_node_id != 0 ? message.source_node_id : transfer->source;

	if (self->unavailable != NULL) {
		self->stats.refused++;
		answer(self, now_us, transfer,
		       DRONECAN_FILE_BEGIN_FIRMWARE_UPDATE_ERROR_INVALID_MODE, self->unavailable);
		return;
	}
	if (!pharos_device_may(self->node->device, &who, SECURITY_UPDATE)) {
		self->stats.refused++;
		answer(self, now_us, transfer, DRONECAN_FILE_BEGIN_FIRMWARE_UPDATE_ERROR_UNKNOWN,
		       "DroneCAN may not: LGT_SRC_EXCL, MAV_KEY_CAN");
		return;
	}
	if (server > DRONECAN_NODE_ID_MAX || message.image_file_remote_path.path_len == 0) {
		self->stats.refused++;
		answer(self, now_us, transfer, DRONECAN_FILE_BEGIN_FIRMWARE_UPDATE_ERROR_UNKNOWN,
		       "no such node, or no path");
		return;
	}
	if (self->state != DRONECAN_FIRMWARE_IDLE || self->is_taken) {
		self->stats.refused +=
			is_the_same(self, server, &message.image_file_remote_path) ? 0u : 1u;
		answer(self, now_us, transfer,
		       DRONECAN_FILE_BEGIN_FIRMWARE_UPDATE_ERROR_IN_PROGRESS, "");
		return;
	}
	/* Without an answer nothing happens: the asker will ask again. */
	if (answer(self, now_us, transfer, DRONECAN_FILE_BEGIN_FIRMWARE_UPDATE_ERROR_OK, "")) {
		self->state = DRONECAN_FIRMWARE_HELD;
		self->server = server;
		self->offset = 0;
		self->request.path = message.image_file_remote_path;
		self->stats.begun++;
		out->event = DRONECAN_FIRMWARE_BEGIN;
	}
}

/* --- file.Read -------------------------------------------------------------------------------- */

/* Without room it is repeated like one that was lost. */
static void request(struct dronecan_firmware *self, int64_t now_us)
{
	uint8_t data[DRONECAN_FILE_READ_REQUEST_MAX_SIZE];
	struct dronecan_transfer transfer = {
		.type = &dronecan_file_read_type,
		.kind = DRONECAN_REQUEST,
		.target = self->server,
		.priority = PRIORITY_READ,
		.fd = true,
		.data = data,
	};

	self->request.offset = self->offset;
	self->repeat_us = now_us + READ_REPEAT_US;
	self->tries++;
	if (dronecan_file_read_request_encode(&self->request, !self->transport->fd, data,
	                                      sizeof(data), &transfer.size) &&
	    dronecan_transport_send(self->transport, now_us, &transfer)) {
		self->transfer_id =
			dronecan_transport_last_id(self->transport, transfer.type, transfer.target);
	}
}

static void hold(struct dronecan_firmware *self)
{
	self->state = DRONECAN_FIRMWARE_HELD;
	self->repeat_us = TIME_NEVER_US;
}

static void fail(struct dronecan_firmware *self, int16_t error,
                 struct dronecan_firmware_outbox *out)
{
	dronecan_firmware_stop(self);
	out->event = DRONECAN_FIRMWARE_FAILED;
	out->error = error;
}

static void take_block(struct dronecan_firmware *self, const struct dronecan_transfer *transfer,
                       struct dronecan_firmware_outbox *out)
{
	struct dronecan_file_read_response *const response = &self->response;

	/* What is held is still being read by its owner. */
	if (self->state != DRONECAN_FIRMWARE_READING || transfer->source != self->server ||
	    transfer->id != self->transfer_id) {
		self->stats.ignored++;
		return;
	}
	if (!dronecan_file_read_response_decode(response, !transfer->fd, transfer->data,
	                                        transfer->size)) {
		self->node->stats.malformed++;
		return;
	}
	if (response->error.value != (int16_t)DRONECAN_FILE_ERROR_OK) {
		fail(self, response->error.value, out);
		return;
	}
	if (!pharos_device_may(self->node->device, &who, SECURITY_UPDATE)) {
		fail(self, (int16_t)DRONECAN_FILE_ERROR_ACCESS_DENIED, out);
		return;
	}
	hold(self);
	self->offset += response->data_len;
	out->event = DRONECAN_FIRMWARE_BLOCK;
	out->data = response->data;
	out->size = response->data_len;
	out->is_last = response->data_len < sizeof(response->data);
}

/* --- what its owner calls --------------------------------------------------------------------- */

void dronecan_firmware_receive(struct dronecan_firmware *self, int64_t now_us,
                               const struct dronecan_transfer *transfer,
                               struct dronecan_firmware_outbox *out)
{
	out->event = DRONECAN_FIRMWARE_NOTHING;
	if (transfer->type == &dronecan_file_begin_firmware_update_type &&
	    transfer->kind == DRONECAN_REQUEST) {
		begin(self, now_us, transfer, out);
	} else if (transfer->type == &dronecan_file_read_type &&
	           transfer->kind == DRONECAN_RESPONSE) {
		take_block(self, transfer, out);
	}
}

void dronecan_firmware_next(struct dronecan_firmware *self, int64_t now_us)
{
	PHAROS_ASSERT(self->state == DRONECAN_FIRMWARE_HELD);
	self->state = DRONECAN_FIRMWARE_READING;
	self->tries = 0;
	request(self, now_us);
}

void dronecan_firmware_stop(struct dronecan_firmware *self)
{
	self->state = DRONECAN_FIRMWARE_IDLE;
	self->repeat_us = TIME_NEVER_US;
}

void dronecan_firmware_step(struct dronecan_firmware *self, int64_t now_us,
                            struct dronecan_firmware_outbox *out)
{
	out->event = DRONECAN_FIRMWARE_NOTHING;
	if (now_us < self->repeat_us) {
		return;
	}
	if (self->tries >= READ_TRIES_MAX) {
		fail(self, 0, out);
		return;
	}
	self->stats.repeated++;
	request(self, now_us);
}

int64_t dronecan_firmware_deadline_us(const struct dronecan_firmware *self)
{
	return self->repeat_us;
}
