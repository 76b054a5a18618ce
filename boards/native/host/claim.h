/* SPDX-License-Identifier: Apache-2.0 */
/* What one process at a time may have. A claim ends with the process, however that ends. */
#ifndef NATIVE_HOST_CLAIM_H_
#define NATIVE_HOST_CLAIM_H_

#include <stdbool.h>

#include "host/error.h"

/* An open file or device, by its lock (flock), which goes on over a reset with the descriptor. 0;
 * EWOULDBLOCK: another process has it. Where there are no locks there are no claims. */
int claim_file(int fd);

/* A file to append to, which is made if it is not there, and emptied if is_new. A regular file is
 * claimed; anything else may be shared. -1 with a reason. */
int claim_output(const char *path, bool is_new, struct host_error *error);

/*
 * A name in the file system for something that cannot be locked: a socket, a link to a terminal.
 * The claim is a descriptor, to be carried over a reset. -1 with errno: EADDRINUSE: another process
 * has it.
 */
int claim_name(const char *path);

#endif
