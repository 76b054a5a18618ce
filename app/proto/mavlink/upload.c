/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/upload.h"

#include <string.h>

#include "core/assert.h"
#include "core/limits.h"
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

void mavlink_upload_init(struct mavlink_upload *self, const struct pharos_device *device)
{
	memset(self, 0, sizeof(*self));
	self->device = device;
}

/* --- whose it is ------------------------------------------------------------------------------ */

static bool is_whose(const struct mavlink_upload *self, const struct mavlink_context *context)
{
	return self->client.link == context->link &&
	       self->client.system == context->source_system &&
	       self->client.component == context->source_component;
}

static bool is_at_rest(const struct mavlink_upload *self)
{
	return self->state == MAVLINK_UPLOAD_IDLE || self->state == MAVLINK_UPLOAD_INSTALLED;
}

static bool may(const struct mavlink_upload *self, const struct mavlink_context *context)
{
	const struct device_who who = mavlink_who(context);

	return pharos_device_may(self->device, &who, SECURITY_UPDATE);
}

bool mavlink_upload_has(const struct mavlink_upload *self, const struct mavlink_context *context,
                        uint8_t session)
{
	return self->state != MAVLINK_UPLOAD_IDLE && self->session == session &&
	       is_whose(self, context);
}

static bool names_it(const struct mavlink_ftp_request *request)
{
	return request->path_length == strlen(MAVLINK_UPLOAD_NAME) &&
	       memcmp(request->path, MAVLINK_UPLOAD_NAME, request->path_length) == 0;
}

bool mavlink_upload_is_named(const struct mavlink_upload *self,
                             const struct mavlink_context *context,
                             const struct mavlink_ftp_request *request)
{
	return names_it(request) && self->state != MAVLINK_UPLOAD_IDLE && is_whose(self, context);
}

bool mavlink_upload_is_repeated(const struct mavlink_upload *self,
                                const struct mavlink_context *context,
                                const struct mavlink_ftp_request *request)
{
	return self->state == MAVLINK_UPLOAD_IDLE && self->error != MAV_FTP_ERR_NONE &&
	       self->owed.opcode == request->opcode && self->owed.sequence == request->sequence &&
	       is_whose(self, context);
}

/* --- its owner's jobs ------------------------------------------------------------------------- */

static uint8_t later(struct mavlink_upload *self, const struct mavlink_ftp_request *request)
{
	self->owed = (struct mavlink_ftp_request){
		.offset = request->offset,
		.sequence = request->sequence,
		.opcode = request->opcode,
	};
	self->is_ready = false;
	return MAVLINK_FTP_LATER;
}

/* The flash may be at work: then once it is at rest. */
static void stop(struct mavlink_upload *self, const struct mavlink_context *context)
{
	switch (self->state) {
	case MAVLINK_UPLOAD_IDLE:
	case MAVLINK_UPLOAD_CHECKING: /* too late: it is whole */
	case MAVLINK_UPLOAD_INSTALLED:
	case MAVLINK_UPLOAD_STOPPING:
		break;
	case MAVLINK_UPLOAD_STARTING:
	case MAVLINK_UPLOAD_STORING:
		self->state = MAVLINK_UPLOAD_STOPPING;
		self->owed.opcode = MAV_FTP_OPCODE_NONE;
		break;
	case MAVLINK_UPLOAD_OPEN:
		self->state = MAVLINK_UPLOAD_IDLE;
		self->owed.opcode = MAV_FTP_OPCODE_NONE;
		context->out->upload = MAVLINK_OUTBOX_UPLOAD_ABORT;
		break;
	}
}

void mavlink_upload_reset(struct mavlink_upload *self, const struct mavlink_context *context)
{
	if (is_whose(self, context)) {
		stop(self, context);
	}
}

/* What follows the block that has been stored moves to the front. */
static void drop_block(struct mavlink_upload *self)
{
	PHAROS_ASSERT(self->fill >= MAVLINK_UPLOAD_BLOCK);
	self->fill = (uint16_t)(self->fill - MAVLINK_UPLOAD_BLOCK);
	memmove(self->buffer, self->buffer + MAVLINK_UPLOAD_BLOCK, self->fill);
}

void mavlink_upload_done(struct mavlink_upload *self, int64_t now_us, const char *failure)
{
	self->used_us = now_us;
	self->is_ready = true;
	self->error = failure == NULL ? MAV_FTP_ERR_NONE : MAV_FTP_ERR_FAIL;
	if (failure != NULL) {
		self->state = MAVLINK_UPLOAD_IDLE;
		return;
	}
	switch (self->state) {
	case MAVLINK_UPLOAD_STARTING:
		self->state = MAVLINK_UPLOAD_OPEN;
		break;
	case MAVLINK_UPLOAD_STORING:
		drop_block(self);
		self->state = MAVLINK_UPLOAD_OPEN;
		break;
	case MAVLINK_UPLOAD_CHECKING:
		self->state = MAVLINK_UPLOAD_INSTALLED;
		break;
	case MAVLINK_UPLOAD_STOPPING: /* the step gives it up */
		break;
	case MAVLINK_UPLOAD_IDLE:
	case MAVLINK_UPLOAD_OPEN:
	case MAVLINK_UPLOAD_INSTALLED:
		PHAROS_ASSERT(false);
		break;
	}
}

/* --- opening ---------------------------------------------------------------------------------- */

static uint8_t begin(struct mavlink_upload *self, const struct mavlink_context *context,
                     const struct mavlink_ftp_request *request, uint8_t wanted)
{
	self->state = MAVLINK_UPLOAD_STARTING;
	self->used_us = context->now_us;
	self->received = 0;
	self->crc32 = 0;
	self->fill = 0;
	self->session = wanted;
	self->client = (struct mavlink_ftp_client){
		.link = context->link,
		.system = context->source_system,
		.component = context->source_component,
	};
	context->out->upload = MAVLINK_OUTBOX_UPLOAD_BEGIN;
	return later(self, request);
}

static void tell_length(const struct mavlink_upload *self, struct mavlink_ftp_answer *answer)
{
	answer->session = self->session;
	if (self->owed.opcode != MAV_FTP_OPCODE_CREATEFILE) {
		answer->size = sizeof(self->received);
		mavlink_ftp_put_le(answer->data, self->received, sizeof(self->received));
	}
}

/* The same request again is one that was repeated: not a second beginning. */
static bool goes_on(const struct mavlink_upload *self, const struct mavlink_ftp_request *request)
{
	return request->opcode == MAV_FTP_OPCODE_OPENFILEWO ||
	       (self->received == 0 && request->sequence == self->owed.sequence);
}

uint8_t mavlink_upload_open(struct mavlink_upload *self, const struct mavlink_context *context,
                            const struct mavlink_ftp_request *request, uint8_t wanted,
                            struct mavlink_ftp_answer *answer)
{
	if (request->to_all || !names_it(request) || !may(self, context)) {
		return MAV_FTP_ERR_FILEPROTECTED;
	}
	if (is_at_rest(self)) {
		return self->is_taken ? MAV_FTP_ERR_NOSESSIONSAVAILABLE
		                      : begin(self, context, request, wanted);
	}

	const bool is_idle = context->now_us - self->used_us >= MAVLINK_FTP_IDLE_US;

	if (!is_whose(self, context) && !(is_idle && self->state == MAVLINK_UPLOAD_OPEN)) {
		return MAV_FTP_ERR_NOSESSIONSAVAILABLE;
	}
	if (self->state != MAVLINK_UPLOAD_OPEN) {
		return MAVLINK_FTP_LATER; /* the client asks again */
	}
	if (!is_whose(self, context) || !goes_on(self, request)) {
		return begin(self, context, request, wanted);
	}
	self->used_us = context->now_us;
	(void)later(self, request);
	tell_length(self, answer);
	return MAV_FTP_ERR_NONE;
}

/* MAV_FTP_ERR_NONE: the client may go on now. */
static uint8_t proceed(struct mavlink_upload *self, const struct mavlink_context *context)
{
	if (!may(self, context)) {
		stop(self, context);
		return MAV_FTP_ERR_FILEPROTECTED;
	}
	self->used_us = context->now_us;
	return self->state == MAVLINK_UPLOAD_OPEN ? MAV_FTP_ERR_NONE : MAVLINK_FTP_LATER;
}

/* --- bytes ------------------------------------------------------------------------------------ */

uint8_t mavlink_upload_write(struct mavlink_upload *self, const struct mavlink_context *context,
                             const struct mavlink_ftp_request *request)
{
	if (is_at_rest(self) || !mavlink_upload_has(self, context, request->session)) {
		return MAV_FTP_ERR_INVALIDSESSION;
	}

	const uint8_t verdict = proceed(self, context);

	if (verdict != MAV_FTP_ERR_NONE) {
		return verdict;
	}
	if (request->size == 0) {
		return MAV_FTP_ERR_INVALIDDATASIZE;
	}
	if (request->offset > self->received) {
		return MAV_FTP_ERR_FAIL;
	}
	for (uint32_t i = self->received - request->offset; i < request->size; i++) {
		const uint8_t byte = mavlink_ftp_data_byte(request, (uint8_t)i);

		self->buffer[self->fill++] = byte;
		self->crc32 = mavlink_ftp_crc32(self->crc32, byte);
		self->received++;
	}
	if (self->fill < MAVLINK_UPLOAD_BLOCK) {
		return MAV_FTP_ERR_NONE;
	}
	self->state = MAVLINK_UPLOAD_STORING;
	context->out->upload = MAVLINK_OUTBOX_UPLOAD_BLOCK;
	return later(self, request);
}

uint8_t mavlink_upload_terminate(struct mavlink_upload *self, const struct mavlink_context *context,
                                 const struct mavlink_ftp_request *request)
{
	if (self->state == MAVLINK_UPLOAD_INSTALLED) {
		return MAV_FTP_ERR_NONE;
	}

	const uint8_t verdict = proceed(self, context);

	if (verdict != MAV_FTP_ERR_NONE) {
		return verdict;
	}
	self->state = MAVLINK_UPLOAD_CHECKING;
	context->out->upload = MAVLINK_OUTBOX_UPLOAD_LAST;
	return later(self, request);
}

/* --- in time ---------------------------------------------------------------------------------- */

static void send_owed(struct mavlink_upload *self, const struct mavlink_context *context)
{
	struct mavlink_ftp_answer answer;

	mavlink_ftp_answer_init(&answer, self->session);
	if (self->error == MAV_FTP_ERR_NONE && self->owed.opcode == MAV_FTP_OPCODE_OPENFILEWO) {
		tell_length(self, &answer);
	}
	self->is_ready = false;
	mavlink_ftp_send(context, &self->client, &self->owed, self->error, &answer);
}

bool mavlink_upload_step(struct mavlink_upload *self, const struct mavlink_context *context)
{
	if (self->state == MAVLINK_UPLOAD_STOPPING && self->is_ready) {
		self->state = MAVLINK_UPLOAD_OPEN;
		self->is_ready = false;
		stop(self, context);
	}
	if (self->state == MAVLINK_UPLOAD_OPEN &&
	    context->now_us - self->used_us >= MAVLINK_UPLOAD_IDLE_US) {
		stop(self, context);
	}
	if (self->is_ready && self->owed.opcode != MAV_FTP_OPCODE_NONE) {
		if (!mavlink_outbox_has_room(context->out)) {
			return false;
		}
		send_owed(self, context);
	}
	self->is_ready = false;
	return true;
}

int64_t mavlink_upload_deadline_us(const struct mavlink_upload *self)
{
	if (self->is_ready) {
		return self->used_us;
	}
	return self->state == MAVLINK_UPLOAD_OPEN ? self->used_us + MAVLINK_UPLOAD_IDLE_US
	                                          : TIME_NEVER_US;
}
