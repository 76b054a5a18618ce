/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MAVLink FTP: files of the device's flash, read by anyone, written by nobody, but for a firmware
 * image (upload.h). One folder, "/"; and beside it "@PARAM/param.pck", all parameters as
 * param_pack.h has them.
 *
 *   ListDirectory, OpenFileRO, ReadFile, BurstReadFile, CalcFileCRC32, TerminateSession,
 *   ResetSessions, None; what else writes is refused as FileProtected, the rest as UnknownCommand.
 *
 * A session belongs to who opened it: link, system id, component id; ResetSessions ends the asker's
 * only. Its number is the one that OpenFileRO brought, if that client has no other session of that
 * number; else the lowest that it has not. So clients that choose numbers are served, and those
 * that take what they get. With all sessions in use, OpenFileRO takes the place of one that was
 * idle for MAVLINK_FTP_IDLE_US, else there are NoSessionsAvailable. A request that comes again
 * (same sequence number) gets the same answer and does nothing twice. A burst starts at any offset,
 * goes at the pace of bulk, and ends with burst_complete at the end of the file. What is asked of
 * all components is answered where it succeeds.
 *
 * All sessions of packed parameters read the same values, those of when the first was opened: while
 * these are old, no other is opened. When one ends, by the client or after MAVLINK_FTP_IDLE_US, the
 * client is told by PARAM_VALUE what has changed meanwhile, since it may have believed the file.
 *
 * Context: the endpoint's. Spec: mavlink.io/en/services/ftp.html; FILE_TRANSFER_PROTOCOL 110.
 */
#ifndef PHAROS_PROTO_MAVLINK_FTP_H
#define PHAROS_PROTO_MAVLINK_FTP_H

#include "proto/mavlink/endpoint.h"
#include "proto/mavlink/param_pack.h"
#include "proto/mavlink/param_service.h"
#include "proto/mavlink/upload.h"

#include <stdbool.h>
#include <stdint.h>

/*
 * name: without '/', 1…MAVLINK_FTP_NAME_MAX bytes. crc32: of its bytes; IEEE 802.3's polynomial,
 * reflected, from 0, not inverted at the end (mavlink.io/en/guide/crc.html).
 */
struct mavlink_file {
	const char *name;
	const uint8_t *bytes;
	uint32_t length;
	uint32_t crc32;
};

/* count may be 0. */
struct mavlink_files {
	const struct mavlink_file *files;
	uint8_t count;
};

struct mavlink_ftp_session {
	const struct mavlink_file *file; /* NULL: closed */
	uint32_t length;
	int64_t used_us;
	int64_t burst_us; /* when the burst goes on */
	uint32_t burst_offset;
	uint16_t burst_sequence;
	uint16_t opened;      /* sequence number that opened it */
	uint16_t closed;      /* and that closed it, */
	bool was_closed;      /* if one did */
	uint8_t burst_length; /* of a part; 0: no burst */
	uint8_t id;           /* unique among its client's */
	uint8_t wanted;       /* what the client asked for */
	uint8_t link;
	uint8_t system;
	uint8_t component;
};

struct mavlink_ftp_stats {
	uint32_t requests;
	uint32_t refused; /* with any error but EOF */
	uint32_t evicted; /* idle sessions that had to go */
};

/* Readable by the owner; only the functions below write. */
struct mavlink_ftp {
	const struct mavlink_files *files;
	struct mavlink_params *params;
	struct mavlink_param_pack pack; /* what sessions of packed parameters read */
	struct mavlink_ftp_session sessions[MAVLINK_FTP_SESSIONS];
	struct mavlink_ftp_stats stats;
#ifdef CONFIG_PHAROS_UPLOAD
	struct mavlink_upload upload;
#endif
};

/* Both outlive it. */
void mavlink_ftp_init(struct mavlink_ftp *self, const struct mavlink_files *files,
                      struct mavlink_params *params);

/*
 * A FILE_TRANSFER_PROTOCOL for the context's component: at most one frame answers it. self NULL: it
 * has no files, and answers UnknownCommand, so that a client need not try again.
 */
void mavlink_ftp_receive(struct mavlink_ftp *self, const struct mavlink_context *context,
                         const struct mavlink_frame *frame);

/* Bursts, as a profile's step and deadline_us. */
bool mavlink_ftp_step(struct mavlink_ftp *self, const struct mavlink_context *context);
int64_t mavlink_ftp_deadline_us(const struct mavlink_ftp *self);

/* COMPONENT_METADATA 397: general is the general metadata. payload is zeroed. */
void mavlink_fill_metadata(const struct mavlink_file *general, int64_t now_us, void *payload);

#endif
