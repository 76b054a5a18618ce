/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A file whose content is to survive, and may be secret. Nobody else may read it (0600), no
 * symbolic link is followed, and one process at a time has it: a lock (flock) that goes on over a
 * reset. The lock lies on the file that the path names, so a replaced file is locked before it gets
 * that name.
 *
 * Functions return 0 or -errno, may make their caller wait for the disk, and may be called from any
 * one thread at a time.
 */
#ifndef NATIVE_HOST_KEPT_FILE_H_
#define NATIVE_HOST_KEPT_FILE_H_

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#include "host/error.h"

struct kept_file {
	const char *path;
	int fd;
};

/* Makes it if it is not there. fd: that of before the reset, or -1. -1 with a reason: it cannot be
 * had, or another process has it. */
int kept_file_open(struct kept_file *self, const char *path, int fd, struct host_error *error);

void kept_file_close(struct kept_file *self);

/* Bytes, or -errno. */
off_t kept_file_length(const struct kept_file *self);

/* These bytes of it. -EIO: it is shorter. */
int kept_file_read(const struct kept_file *self, size_t offset, void *buffer, size_t length);

/* After a cut or an error, any number of the bytes may be there. -ENOENT: somebody has removed it.
 */
int kept_file_append(const struct kept_file *self, const void *data, size_t length);

/* After a cut or an error, the old content is there, or the new one. is_cut: power fails before it
 * is in force, which is -EIO. */
int kept_file_replace(struct kept_file *self, const void *data, size_t length, bool is_cut);

#endif
