/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/ftp_session.h"

#include "core/limits.h"

#include <string.h>

/* --- files ------------------------------------------------------------------------------------ */

/* Not stored anywhere. */
static const struct mavlink_file packed = {.name = "@PARAM/param.pck"};
static const struct mavlink_file packed_with_defaults = {.name = "@PARAM/param.pck?withdefaults=1"};

static bool is_named(const struct mavlink_file *file, const char *name, size_t length)
{
	return strlen(file->name) == length && memcmp(file->name, name, length) == 0;
}

const struct mavlink_file *mavlink_ftp_file(const struct mavlink_ftp *self, const char *name,
                                            size_t length)
{
	for (uint8_t i = 0; i < self->files->count; i++) {
		if (is_named(&self->files->files[i], name, length)) {
			return &self->files->files[i];
		}
	}
	if (is_named(&packed, name, length)) {
		return &packed;
	}
	return is_named(&packed_with_defaults, name, length) ? &packed_with_defaults : NULL;
}

bool mavlink_ftp_is_packed(const struct mavlink_file *file)
{
	return file == &packed || file == &packed_with_defaults;
}

static uint32_t file_length(const struct mavlink_ftp *self, const struct mavlink_file *file)
{
	return mavlink_ftp_is_packed(file)
	               ? mavlink_param_pack_length(&self->pack, file == &packed_with_defaults)
	               : file->length;
}

uint8_t mavlink_ftp_session_read(const struct mavlink_ftp *self,
                                 const struct mavlink_ftp_session *session, uint32_t offset,
                                 uint8_t size, uint8_t *to)
{
	const uint32_t left = session->length - offset;
	const uint8_t count = left < size ? (uint8_t)left : size;

	if (mavlink_ftp_is_packed(session->file)) {
		mavlink_param_pack_read(&self->pack, session->file == &packed_with_defaults, offset,
		                        count, to);
	} else {
		memcpy(to, session->file->bytes + offset, count);
	}
	return count;
}

/* --- closing ---------------------------------------------------------------------------------- */

static bool is_idle(const struct mavlink_ftp_session *session, int64_t now_us)
{
	return now_us - session->used_us >= MAVLINK_FTP_IDLE_US;
}

/* Who has read packed parameters hears what is no longer so. */
static void end(struct mavlink_ftp *self, int64_t now_us, struct mavlink_ftp_session *session)
{
	if (mavlink_ftp_is_packed(session->file)) {
		const struct param_set outdated =
			mavlink_param_pack_outdated(&self->pack, &self->params->device->params);

		mavlink_params_changed(self->params, now_us, (uint8_t)(1u << session->link),
		                       &outdated);
	}
	session->file = NULL;
	session->burst_length = 0;
}

static bool is_whose(const struct mavlink_ftp_session *session,
                     const struct mavlink_context *context)
{
	return session->link == context->link && session->system == context->source_system &&
	       session->component == context->source_component;
}

static struct mavlink_ftp_session *find_open(struct mavlink_ftp *self,
                                             const struct mavlink_context *context, uint8_t id)
{
	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		struct mavlink_ftp_session *const session = &self->sessions[i];

		if (session->file != NULL && session->id == id && is_whose(session, context)) {
			return session;
		}
	}
	return NULL;
}

bool mavlink_ftp_session_close(struct mavlink_ftp *self, const struct mavlink_context *context,
                               uint8_t id, uint16_t sequence)
{
	struct mavlink_ftp_session *const open = find_open(self, context, id);

	if (open != NULL) {
		end(self, context->now_us, open);
		open->closed = sequence;
		open->was_closed = true;
		return true;
	}
	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		const struct mavlink_ftp_session *const session = &self->sessions[i];

		if (session->was_closed && session->closed == sequence && session->id == id &&
		    is_whose(session, context)) {
			return true;
		}
	}
	return false;
}

void mavlink_ftp_session_reset(struct mavlink_ftp *self, const struct mavlink_context *context)
{
	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		if (is_whose(&self->sessions[i], context)) {
			end(self, context->now_us, &self->sessions[i]);
			self->sessions[i] = (struct mavlink_ftp_session){0};
		}
	}
}

void mavlink_ftp_session_expire(struct mavlink_ftp *self, int64_t now_us)
{
	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		struct mavlink_ftp_session *const session = &self->sessions[i];

		if (mavlink_ftp_is_packed(session->file) && is_idle(session, now_us)) {
			end(self, now_us, session);
		}
	}
}

int64_t mavlink_ftp_session_due_us(const struct mavlink_ftp_session *session)
{
	return mavlink_ftp_is_packed(session->file) ? session->used_us + MAVLINK_FTP_IDLE_US
	                                            : TIME_NEVER_US;
}

/* --- opening ---------------------------------------------------------------------------------- */

struct mavlink_ftp_session *mavlink_ftp_session_find(struct mavlink_ftp *self,
                                                     const struct mavlink_context *context,
                                                     uint8_t id)
{
	struct mavlink_ftp_session *const session = find_open(self, context, id);

	if (session != NULL) {
		session->used_us = context->now_us;
	}
	return session;
}

/* A closed session, or the one that was idle for the longest, if that was long enough. */
static struct mavlink_ftp_session *vacant(struct mavlink_ftp *self, int64_t now_us)
{
	struct mavlink_ftp_session *oldest = &self->sessions[0];

	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		struct mavlink_ftp_session *const session = &self->sessions[i];

		if (session->file == NULL) {
			return session;
		}
		if (session->used_us < oldest->used_us) {
			oldest = session;
		}
	}
	if (!is_idle(oldest, now_us)) {
		return NULL;
	}
	self->stats.evicted++;
	end(self, now_us, oldest);
	return oldest;
}

static bool is_used(struct mavlink_ftp *self, const struct mavlink_context *context, uint8_t id)
{
#ifdef CONFIG_PHAROS_UPLOAD
	if (mavlink_upload_has(&self->upload, context, id)) {
		return true;
	}
#endif
	return find_open(self, context, id) != NULL;
}

uint8_t mavlink_ftp_session_free_id(struct mavlink_ftp *self, const struct mavlink_context *context,
                                    uint8_t wanted)
{
	uint8_t id = wanted;

	for (uint8_t next = 0; is_used(self, context, id); next++) {
		id = next;
	}
	return id;
}

/* The packed parameters become those of now, unless someone reads other ones. */
static bool refresh_pack(struct mavlink_ftp *self)
{
	const struct params *const params = &self->params->device->params;
	const struct param_set outdated = mavlink_param_pack_outdated(&self->pack, params);

	if (param_set_is_empty(&outdated)) {
		return true;
	}
	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		if (mavlink_ftp_is_packed(self->sessions[i].file)) {
			return false;
		}
	}
	mavlink_param_pack_take(&self->pack, params);
	return true;
}

/* The session that this very request has opened before. */
static struct mavlink_ftp_session *opened_by(struct mavlink_ftp *self,
                                             const struct mavlink_context *context,
                                             const struct mavlink_file *file, uint16_t sequence,
                                             uint8_t wanted)
{
	for (uint8_t i = 0; i < MAVLINK_FTP_SESSIONS; i++) {
		struct mavlink_ftp_session *const session = &self->sessions[i];

		if (session->file == file && is_whose(session, context) &&
		    session->opened == sequence && session->wanted == wanted) {
			session->used_us = context->now_us;
			return session;
		}
	}
	return NULL;
}

struct mavlink_ftp_session *mavlink_ftp_session_open(struct mavlink_ftp *self,
                                                     const struct mavlink_context *context,
                                                     const struct mavlink_file *file,
                                                     uint16_t sequence, uint8_t wanted)
{
	struct mavlink_ftp_session *session = opened_by(self, context, file, sequence, wanted);

	if (session != NULL) {
		return session;
	}
	session = vacant(self, context->now_us);
	if (session == NULL || (mavlink_ftp_is_packed(file) && !refresh_pack(self))) {
		return NULL;
	}
	*session = (struct mavlink_ftp_session){
		.file = file,
		.length = file_length(self, file),
		.used_us = context->now_us,
		.opened = sequence,
		.wanted = wanted,
		.id = mavlink_ftp_session_free_id(self, context, wanted),
		.link = context->link,
		.system = context->source_system,
		.component = context->source_component,
	};
	return session;
}

uint32_t mavlink_ftp_session_crc32(struct mavlink_ftp *self, const struct mavlink_file *file)
{
	uint8_t part[32];
	uint32_t crc = 0;

	if (!mavlink_ftp_is_packed(file)) {
		return file->crc32;
	}
	(void)refresh_pack(self);

	const struct mavlink_ftp_session whole = {.file = file, .length = file_length(self, file)};

	for (uint32_t at = 0; at < whole.length; at += sizeof(part)) {
		const uint8_t count =
			mavlink_ftp_session_read(self, &whole, at, sizeof(part), part);

		for (uint8_t i = 0; i < count; i++) {
			crc = mavlink_ftp_crc32(crc, part[i]);
		}
	}
	return crc;
}
