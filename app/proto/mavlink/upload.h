/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A firmware image over MAVLink FTP, written to the file MAVLINK_UPLOAD_NAME; sans-IO.
 *
 *   CreateFile       an upload from the beginning; answered when there is room for it
 *   OpenFileWO       goes on with what is there: its length comes as that of a file that is read
 *   WriteFile        in order; bytes that are there already are taken as written, a gap is refused
 *   CalcFileCRC32    of what is there: is it the beginning of this image?
 *   TerminateSession the image is whole: answered once it is verified and marked, or NAK with Fail
 *   ResetSessions    gives the upload up
 *
 * One upload at a time, of who began it: link, system id, component id. It is only taken by name,
 * not with what goes to all components, and from who may update (core/security.h); others get
 * FileProtected. A request is answered when the flash has done what it asks, so slow flash sets the
 * pace; what the client repeats meanwhile is ignored. Another client may begin when nothing has
 * come for MAVLINK_FTP_IDLE_US; after MAVLINK_UPLOAD_IDLE_US it is given up.
 *
 * Its owner does what the outbox says (BEGIN, BLOCK, ABORT), and calls mavlink_upload_done() when
 * BEGIN or BLOCK is done; until then the block stays as it is.
 *
 * Context: the endpoint's. Spec: mavlink.io/en/services/ftp.html.
 */
#ifndef PHAROS_PROTO_MAVLINK_UPLOAD_H
#define PHAROS_PROTO_MAVLINK_UPLOAD_H

#include "core/device.h"
#include "proto/mavlink/ftp_request.h"

#define MAVLINK_UPLOAD_NAME "firmware.bin"

enum mavlink_upload_state {
	MAVLINK_UPLOAD_IDLE,
	MAVLINK_UPLOAD_STARTING, /* room is being made */
	MAVLINK_UPLOAD_OPEN,
	MAVLINK_UPLOAD_STORING,  /* a block is being stored */
	MAVLINK_UPLOAD_CHECKING, /* the last one is, and then the image verified */
	MAVLINK_UPLOAD_STOPPING, /* given up once the flash is at rest */
	MAVLINK_UPLOAD_INSTALLED,
};

struct mavlink_upload {
	const struct pharos_device *device;
	enum mavlink_upload_state state;
	bool is_taken; /* the slot is, by an update that came another way; its owner sets it */
	int64_t used_us;
	uint32_t received; /* bytes, from the beginning */
	uint32_t crc32;    /* of them */
	struct mavlink_ftp_client client;
	uint8_t session;
	bool is_ready;                   /* the answer that is owed is known */
	uint8_t error;                   /* MAV_FTP_ERR of what is or was owed */
	struct mavlink_ftp_request owed; /* opcode 0: none */
	uint16_t fill;                   /* bytes in buffer */
	uint8_t buffer[MAVLINK_UPLOAD_BLOCK + MAVLINK_FTP_DATA_MAX];
};

void mavlink_upload_init(struct mavlink_upload *self, const struct pharos_device *device);

/* The client's upload has that session. */
bool mavlink_upload_has(const struct mavlink_upload *self, const struct mavlink_context *context,
                        uint8_t session);

/*
 * CreateFile, OpenFileWO, WriteFile. wanted: a session number that the client has free. Returns a
 * MAV_FTP_ERR, or MAVLINK_FTP_LATER.
 */
uint8_t mavlink_upload_open(struct mavlink_upload *self, const struct mavlink_context *context,
                            const struct mavlink_ftp_request *request, uint8_t wanted,
                            struct mavlink_ftp_answer *answer);
uint8_t mavlink_upload_write(struct mavlink_upload *self, const struct mavlink_context *context,
                             const struct mavlink_ftp_request *request);

/* Of the client's upload (mavlink_upload_has). */
uint8_t mavlink_upload_terminate(struct mavlink_upload *self, const struct mavlink_context *context,
                                 const struct mavlink_ftp_request *request);

/* Is it about the upload's file, and has the client one? */
bool mavlink_upload_is_named(const struct mavlink_upload *self,
                             const struct mavlink_context *context,
                             const struct mavlink_ftp_request *request);

/* The request that failed and ended the upload, repeated: its answer may have been lost. */
bool mavlink_upload_is_repeated(const struct mavlink_upload *self,
                                const struct mavlink_context *context,
                                const struct mavlink_ftp_request *request);

/* If it is the client's. */
void mavlink_upload_reset(struct mavlink_upload *self, const struct mavlink_context *context);

/* BEGIN or BLOCK is done: NULL, or why the update has failed. */
void mavlink_upload_done(struct mavlink_upload *self, int64_t now_us, const char *failure);

/* As a profile's. */
bool mavlink_upload_step(struct mavlink_upload *self, const struct mavlink_context *context);
int64_t mavlink_upload_deadline_us(const struct mavlink_upload *self);

#endif
