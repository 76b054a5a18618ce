/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What MAVLink FTP has open: which file, by whom, under which number. Of ftp.c alone; the rules are
 * in ftp.h. Context: the endpoint's.
 */
#ifndef PHAROS_PROTO_MAVLINK_FTP_SESSION_H
#define PHAROS_PROTO_MAVLINK_FTP_SESSION_H

#include "proto/mavlink/ftp.h"

/* The file of that name, which is not terminated; NULL: none. */
const struct mavlink_file *mavlink_ftp_file(const struct mavlink_ftp *self, const char *name,
                                            size_t length);

/* "@PARAM/param.pck", with or without defaults: made when it is opened. */
bool mavlink_ftp_is_packed(const struct mavlink_file *file);

/*
 * A session of the asker's that reads file; wanted: the number that the request brings. The same
 * request again gets the same session. NULL: none is free.
 */
struct mavlink_ftp_session *mavlink_ftp_session_open(struct mavlink_ftp *self,
                                                     const struct mavlink_context *context,
                                                     const struct mavlink_file *file,
                                                     uint16_t sequence, uint8_t wanted);

/* The number that the asker wants, if it is free for it; else the lowest that is. */
uint8_t mavlink_ftp_session_free_id(struct mavlink_ftp *self, const struct mavlink_context *context,
                                    uint8_t wanted);

/* The asker's open session of that number; NULL: there is none. It counts as used now. */
struct mavlink_ftp_session *mavlink_ftp_session_find(struct mavlink_ftp *self,
                                                     const struct mavlink_context *context,
                                                     uint8_t id);

/* Up to size bytes at offset, which is before the end; how many. */
uint8_t mavlink_ftp_session_read(const struct mavlink_ftp *self,
                                 const struct mavlink_ftp_session *session, uint32_t offset,
                                 uint8_t size, uint8_t *to);

/* Of the file as a session would read it that opened now, or as those do that are open. */
uint32_t mavlink_ftp_session_crc32(struct mavlink_ftp *self, const struct mavlink_file *file);

/* false: the asker has no such session, nor had this request closed it before. */
bool mavlink_ftp_session_close(struct mavlink_ftp *self, const struct mavlink_context *context,
                               uint8_t id, uint16_t sequence);

/* All of the asker's. */
void mavlink_ftp_session_reset(struct mavlink_ftp *self, const struct mavlink_context *context);

/* Ends what reads packed parameters and has been idle; and when an open session would be. */
void mavlink_ftp_session_expire(struct mavlink_ftp *self, int64_t now_us);
int64_t mavlink_ftp_session_due_us(const struct mavlink_ftp_session *session);

#endif
