/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/ftp.h"

#include "core/assert.h"
#include "core/limits.h"
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/ftp_request.h"
#include "proto/mavlink/ftp_session.h"

#include <stddef.h>
#include <string.h>

/* Where things lie in FILE_TRANSFER_PROTOCOL.payload. */
#define AT_SEQUENCE       0
#define AT_SESSION        2
#define AT_OPCODE         3
#define AT_SIZE           4
#define AT_REQUEST        5
#define AT_BURST_COMPLETE 6
#define AT_OFFSET         8
#define AT_DATA           12

#define COMPONENT_OFFSET offsetof(mavlink_file_transfer_protocol_t, target_component)
#define PAYLOAD_OFFSET   offsetof(mavlink_file_transfer_protocol_t, payload)
#define PAYLOAD_BYTES    sizeof(((mavlink_file_transfer_protocol_t *)0)->payload)

_Static_assert(AT_DATA + MAVLINK_FTP_DATA_MAX == PAYLOAD_BYTES, "common.xml");
/* "F", name, tab, ten digits, 0 */
_Static_assert(1 + MAVLINK_FTP_NAME_MAX + 1 + 10 + 1 <= MAVLINK_FTP_DATA_MAX, "an entry fits");

void mavlink_ftp_init(struct mavlink_ftp *self, const struct mavlink_files *files,
                      struct mavlink_params *params)
{
	memset(self, 0, sizeof(*self));
	self->files = files;
	self->params = params;
#ifdef CONFIG_PHAROS_UPLOAD
	mavlink_upload_init(&self->upload, params->device);
#endif
}

/* --- wire ------------------------------------------------------------------------------------- */

static uint32_t get_le(const struct mavlink_frame *frame, uint8_t at, uint8_t bytes)
{
	uint32_t value = 0;

	for (uint8_t i = 0; i < bytes; i++) {
		value |= (uint32_t)mavlink_frame_byte(frame, (uint8_t)(PAYLOAD_OFFSET + at + i))
		         << (8 * i);
	}
	return value;
}

void mavlink_ftp_put_le(uint8_t *to, uint32_t value, uint8_t bytes)
{
	for (uint8_t i = 0; i < bytes; i++) {
		to[i] = (uint8_t)(value >> (8 * i));
	}
}

#define CRC32_REFLECTED 0xEDB88320u

uint32_t mavlink_ftp_crc32(uint32_t crc, uint8_t byte)
{
	crc ^= byte;
	for (uint8_t bit = 0; bit < 8; bit++) {
		crc = (crc >> 1) ^ ((crc & 1u) != 0 ? CRC32_REFLECTED : 0u);
	}
	return crc;
}

uint8_t mavlink_ftp_data_byte(const struct mavlink_ftp_request *request, uint8_t i)
{
	return mavlink_frame_byte(request->frame, (uint8_t)(PAYLOAD_OFFSET + AT_DATA + i));
}

/* The path ends at its size, at a 0, or where the frame was truncated; "/a" and "a" are one. */
static void read_path(const struct mavlink_frame *frame, struct mavlink_ftp_request *request)
{
	const size_t start = PAYLOAD_OFFSET + AT_DATA;
	const size_t there = frame->payload_length > start ? frame->payload_length - start : 0;
	const char *path = (const char *)frame->payload + start;
	size_t length = 0;

	while (length < there && length < request->size && path[length] != '\0') {
		length++;
	}
	while (length > 0 && *path == '/') {
		path++;
		length--;
	}
	request->path = path;
	request->path_length = length;
}

static struct mavlink_ftp_request read_request(const struct mavlink_frame *frame)
{
	struct mavlink_ftp_request request = {
		.sequence = (uint16_t)get_le(frame, AT_SEQUENCE, 2),
		.session = (uint8_t)get_le(frame, AT_SESSION, 1),
		.opcode = (uint8_t)get_le(frame, AT_OPCODE, 1),
		.size = (uint8_t)get_le(frame, AT_SIZE, 1),
		.offset = get_le(frame, AT_OFFSET, 4),
		.to_all = mavlink_frame_byte(frame, COMPONENT_OFFSET) == 0,
		.frame = frame,
	};

	read_path(frame, &request);
	return request;
}

static void write_head(mavlink_file_transfer_protocol_t *wire, uint16_t sequence, uint8_t request,
                       uint8_t session, uint32_t offset)
{
	mavlink_ftp_put_le(&wire->payload[AT_SEQUENCE], sequence, 2);
	wire->payload[AT_SESSION] = session;
	wire->payload[AT_OPCODE] = MAV_FTP_OPCODE_ACK;
	wire->payload[AT_REQUEST] = request;
	mavlink_ftp_put_le(&wire->payload[AT_OFFSET], offset, 4);
}

void mavlink_ftp_answer_init(struct mavlink_ftp_answer *self, uint8_t session)
{
	memset(self, 0, sizeof(*self));
	self->session = session;
	self->data = &self->wire.payload[AT_DATA];
}

static bool is_root(const struct mavlink_ftp_request *request)
{
	return request->path_length == 0 || (request->path_length == 1 && request->path[0] == '.');
}

/* --- operations: each returns a MAV_FTP_ERR ----------------------------------------------------
 */

/* "F", name, tab, size, 0; returns how long it is. */
static uint8_t write_entry(uint8_t *to, const struct mavlink_file *file)
{
	const size_t name_length = strlen(file->name);
	uint8_t digits[10];
	uint8_t digit_count = 0;
	uint32_t rest = file->length;
	size_t at = 0;

	PHAROS_ASSERT(name_length <= MAVLINK_FTP_NAME_MAX);
	do {
		digits[digit_count++] = (uint8_t)('0' + rest % 10);
		rest /= 10;
	} while (rest > 0);
	to[at++] = 'F';
	memcpy(to + at, file->name, name_length);
	at += name_length;
	to[at++] = '\t';
	while (digit_count > 0) {
		to[at++] = digits[--digit_count];
	}
	to[at++] = '\0';
	return (uint8_t)at;
}

/* Whole entries, from the one that offset counts to, as many as fit. */
static uint8_t list_directory(struct mavlink_ftp *self, const struct mavlink_ftp_request *request,
                              struct mavlink_ftp_answer *answer)
{
	const uint8_t entry_max = 1 + MAVLINK_FTP_NAME_MAX + 1 + 10 + 1;

	if (!is_root(request)) {
		return MAV_FTP_ERR_FILENOTFOUND;
	}
	if (request->offset >= self->files->count) {
		return MAV_FTP_ERR_EOF;
	}
	for (uint32_t i = request->offset;
	     i < self->files->count && answer->size + entry_max <= MAVLINK_FTP_DATA_MAX; i++) {
		answer->size = (uint8_t)(answer->size + write_entry(answer->data + answer->size,
		                                                    &self->files->files[i]));
	}
	return MAV_FTP_ERR_NONE;
}

static uint8_t open_file(struct mavlink_ftp *self, const struct mavlink_context *context,
                         const struct mavlink_ftp_request *request,
                         struct mavlink_ftp_answer *answer)
{
	const struct mavlink_file *const file =
		mavlink_ftp_file(self, request->path, request->path_length);
	const struct mavlink_ftp_session *session;

	if (file == NULL) {
		return MAV_FTP_ERR_FILENOTFOUND;
	}
	session =
		mavlink_ftp_session_open(self, context, file, request->sequence, request->session);
	if (session == NULL) {
		return MAV_FTP_ERR_NOSESSIONSAVAILABLE;
	}
	answer->session = session->id;
	answer->size = sizeof(session->length);
	mavlink_ftp_put_le(answer->data, session->length, sizeof(session->length));
	return MAV_FTP_ERR_NONE;
}

static uint8_t terminate(struct mavlink_ftp *self, const struct mavlink_context *context,
                         const struct mavlink_ftp_request *request)
{
	if (mavlink_ftp_session_close(self, context, request->session, request->sequence)) {
		return MAV_FTP_ERR_NONE;
	}
#ifdef CONFIG_PHAROS_UPLOAD
	if (mavlink_upload_has(&self->upload, context, request->session)) {
		return mavlink_upload_terminate(&self->upload, context, request);
	}
#endif
	return MAV_FTP_ERR_INVALIDSESSION;
}

static uint8_t reset(struct mavlink_ftp *self, const struct mavlink_context *context)
{
	mavlink_ftp_session_reset(self, context);
#ifdef CONFIG_PHAROS_UPLOAD
	mavlink_upload_reset(&self->upload, context);
#endif
	return MAV_FTP_ERR_NONE;
}

/* The only file that is written is a firmware image. */
static uint8_t write_file(struct mavlink_ftp *self, const struct mavlink_context *context,
                          const struct mavlink_ftp_request *request,
                          struct mavlink_ftp_answer *answer)
{
#ifdef CONFIG_PHAROS_UPLOAD
	if (request->opcode == MAV_FTP_OPCODE_WRITEFILE) {
		return mavlink_upload_write(&self->upload, context, request);
	}
	return mavlink_upload_open(&self->upload, context, request,
	                           mavlink_ftp_session_free_id(self, context, request->session),
	                           answer);
#else
	/* no session writes */
	return request->opcode == MAV_FTP_OPCODE_WRITEFILE ? MAV_FTP_ERR_INVALIDSESSION
	                                                   : MAV_FTP_ERR_FILEPROTECTED;
#endif
}

static uint8_t read_file(struct mavlink_ftp *self, const struct mavlink_context *context,
                         const struct mavlink_ftp_request *request,
                         struct mavlink_ftp_answer *answer)
{
	const struct mavlink_ftp_session *const session =
		mavlink_ftp_session_find(self, context, request->session);

	if (session == NULL) {
		return MAV_FTP_ERR_INVALIDSESSION;
	}
	if (request->size == 0) {
		return MAV_FTP_ERR_INVALIDDATASIZE;
	}
	if (request->offset >= session->length) {
		return MAV_FTP_ERR_EOF;
	}
	answer->size = mavlink_ftp_session_read(self, session, request->offset, request->size,
	                                        answer->data);
	return MAV_FTP_ERR_NONE;
}

/* Size 0 leaves the length of the parts to us. */
static uint8_t burst_read(struct mavlink_ftp *self, const struct mavlink_context *context,
                          const struct mavlink_ftp_request *request)
{
	struct mavlink_ftp_session *const session =
		mavlink_ftp_session_find(self, context, request->session);

	if (session == NULL) {
		return MAV_FTP_ERR_INVALIDSESSION;
	}
	if (request->offset >= session->length) {
		return MAV_FTP_ERR_EOF;
	}
	session->burst_length = request->size != 0 ? request->size : MAVLINK_FTP_DATA_MAX;
	session->burst_offset = request->offset;
	session->burst_sequence = (uint16_t)(request->sequence + 1);
	session->burst_us = context->now_us;
	return MAVLINK_FTP_LATER;
}

static uint8_t calculate_crc(struct mavlink_ftp *self, const struct mavlink_context *context,
                             const struct mavlink_ftp_request *request,
                             struct mavlink_ftp_answer *answer)
{
#ifdef CONFIG_PHAROS_UPLOAD
	if (mavlink_upload_is_named(&self->upload, context, request)) {
		answer->size = sizeof(self->upload.crc32);
		mavlink_ftp_put_le(answer->data, self->upload.crc32, sizeof(self->upload.crc32));
		return MAV_FTP_ERR_NONE;
	}
#endif

	const struct mavlink_file *const file =
		mavlink_ftp_file(self, request->path, request->path_length);

	if (file == NULL) {
		return MAV_FTP_ERR_FILENOTFOUND;
	}
	answer->size = sizeof(file->crc32);
	mavlink_ftp_put_le(answer->data, mavlink_ftp_session_crc32(self, file),
	                   sizeof(file->crc32));
	return MAV_FTP_ERR_NONE;
}

static uint8_t operate(struct mavlink_ftp *self, const struct mavlink_context *context,
                       const struct mavlink_ftp_request *request, struct mavlink_ftp_answer *answer)
{
	if (request->size > MAVLINK_FTP_DATA_MAX) {
		return MAV_FTP_ERR_INVALIDDATASIZE;
	}
#ifdef CONFIG_PHAROS_UPLOAD
	if (mavlink_upload_is_repeated(&self->upload, context, request)) {
		return self->upload.error;
	}
#endif
	switch (request->opcode) {
	case MAV_FTP_OPCODE_NONE:
		return MAV_FTP_ERR_NONE;
	case MAV_FTP_OPCODE_TERMINATESESSION:
		return terminate(self, context, request);
	case MAV_FTP_OPCODE_RESETSESSION:
		return reset(self, context);
	case MAV_FTP_OPCODE_LISTDIRECTORY:
		return list_directory(self, request, answer);
	case MAV_FTP_OPCODE_OPENFILERO:
		return open_file(self, context, request, answer);
	case MAV_FTP_OPCODE_READFILE:
		return read_file(self, context, request, answer);
	case MAV_FTP_OPCODE_CALCFILECRC:
		return calculate_crc(self, context, request, answer);
	case MAV_FTP_OPCODE_BURSTREADFILE:
		return burst_read(self, context, request);
	case MAV_FTP_OPCODE_CREATEFILE:
	case MAV_FTP_OPCODE_OPENFILEWO:
	case MAV_FTP_OPCODE_WRITEFILE:
		return write_file(self, context, request, answer);
	case MAV_FTP_OPCODE_REMOVEFILE:
	case MAV_FTP_OPCODE_CREATEDIRECTORY:
	case MAV_FTP_OPCODE_REMOVEDIRECTORY:
	case MAV_FTP_OPCODE_TRUNCATEFILE:
	case MAV_FTP_OPCODE_RENAME:
		return MAV_FTP_ERR_FILEPROTECTED;
	default:
		return MAV_FTP_ERR_UNKNOWNCOMMAND;
	}
}

/* --- in and out ------------------------------------------------------------------------------- */

static const struct mavlink_kind kind = MAVLINK_KIND(FILE_TRANSFER_PROTOCOL);

void mavlink_ftp_send(const struct mavlink_context *context,
                      const struct mavlink_ftp_client *client,
                      const struct mavlink_ftp_request *request, uint8_t error,
                      struct mavlink_ftp_answer *answer)
{
	mavlink_file_transfer_protocol_t *const wire = &answer->wire;

	write_head(wire, (uint16_t)(request->sequence + 1), request->opcode, answer->session,
	           request->offset);
	wire->payload[AT_SIZE] = answer->size;
	if (error != MAV_FTP_ERR_NONE) {
		wire->payload[AT_OPCODE] = MAV_FTP_OPCODE_NAK;
		wire->payload[AT_SIZE] = 1;
		answer->data[0] = error;
	}
	wire->target_system = client->system;
	wire->target_component = client->component;
	(void)mavlink_send(context, client->link, &kind, wire);
}

void mavlink_ftp_receive(struct mavlink_ftp *self, const struct mavlink_context *context,
                         const struct mavlink_frame *frame)
{
	const struct mavlink_ftp_request request = read_request(frame);
	const struct mavlink_ftp_client client = {
		.link = context->link,
		.system = context->source_system,
		.component = context->source_component,
	};
	struct mavlink_ftp_answer answer;
	uint8_t error = MAV_FTP_ERR_UNKNOWNCOMMAND;

	/* somebody's answer to somebody else */
	if (request.opcode == MAV_FTP_OPCODE_ACK || request.opcode == MAV_FTP_OPCODE_NAK) {
		return;
	}
	mavlink_ftp_answer_init(&answer, request.session);
	if (self != NULL) {
		self->stats.requests++;
		error = operate(self, context, &request, &answer);
	}
	if (error == MAVLINK_FTP_LATER) {
		return; /* a step sends it */
	}
	if (error != MAV_FTP_ERR_NONE && error != MAV_FTP_ERR_EOF) {
		if (request.to_all) {
			return; /* another component may have it */
		}
		if (self != NULL) {
			self->stats.refused++;
		}
	}
	mavlink_ftp_send(context, &client, &request, error, &answer);
}

static void send_part(struct mavlink_ftp *self, const struct mavlink_context *context,
                      struct mavlink_ftp_session *session)
{
	mavlink_file_transfer_protocol_t wire = {0};

	write_head(&wire, session->burst_sequence, MAV_FTP_OPCODE_BURSTREADFILE, session->id,
	           session->burst_offset);

	const uint8_t size =
		mavlink_ftp_session_read(self, session, session->burst_offset,
	                                 session->burst_length, &wire.payload[AT_DATA]);

	wire.payload[AT_SIZE] = size;
	wire.target_system = session->system;
	wire.target_component = session->component;
	session->burst_sequence++;
	session->burst_offset += size;
	session->used_us = context->now_us;
	if (session->burst_offset == session->length) {
		wire.payload[AT_BURST_COMPLETE] = 1;
		session->burst_length = 0;
	}
	(void)mavlink_send_bulk(context, session->link, &kind, &wire);
}

bool mavlink_ftp_step(struct mavlink_ftp *self, const struct mavlink_context *context)
{
	mavlink_ftp_session_expire(self, context->now_us);
	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		struct mavlink_ftp_session *const session = &self->sessions[i];

		if (session->burst_length == 0 || session->burst_us > context->now_us) {
			continue;
		}
		if ((context->endpoint->config.links & 1u << session->link) == 0) {
			session->burst_length = 0;
			continue;
		}
		session->burst_us = mavlink_bulk_due_us(context->endpoint, session->link);
		if (session->burst_us > context->now_us) {
			continue;
		}
		if (!mavlink_outbox_has_room(context->out)) {
			return false;
		}
		send_part(self, context, session);
		session->burst_us = mavlink_bulk_due_us(context->endpoint, session->link);
	}
	return true;
}

int64_t mavlink_ftp_deadline_us(const struct mavlink_ftp *self)
{
	int64_t due_us = TIME_NEVER_US;

	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		const struct mavlink_ftp_session *const session = &self->sessions[i];

		if (session->file != NULL) {
			const int64_t idle_us = mavlink_ftp_session_due_us(session);

			due_us = idle_us < due_us ? idle_us : due_us;
			if (session->burst_length != 0 && session->burst_us < due_us) {
				due_us = session->burst_us;
			}
		}
	}
	return due_us;
}

void mavlink_fill_metadata(const struct mavlink_file *general, int64_t now_us, void *payload)
{
	static const char scheme[] = "mftp://";
	mavlink_component_metadata_t *const metadata = payload;
	const size_t scheme_length = sizeof(scheme) - 1;

	_Static_assert(sizeof(scheme) + MAVLINK_FTP_NAME_MAX <= sizeof(metadata->uri),
	               "a URI fits");
	PHAROS_ASSERT(strlen(general->name) <= MAVLINK_FTP_NAME_MAX);
	metadata->time_boot_ms = (uint32_t)(now_us / US_PER_MS);
	metadata->file_crc = general->crc32;
	memcpy(metadata->uri, scheme, scheme_length);
	memcpy(metadata->uri + scheme_length, general->name, strlen(general->name));
}
