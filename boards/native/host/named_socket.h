/* SPDX-License-Identifier: Apache-2.0 */
/* A Unix stream socket that listens at a name in the file system, which is its own: neither taken
 * from another process nor left to one. */
#ifndef NATIVE_HOST_NAMED_SOCKET_H_
#define NATIVE_HOST_NAMED_SOCKET_H_

#include <sys/types.h>

/* Plain data; both descriptors are to be carried over a reset. */
struct named_socket {
	int fd;
	int claim; /* on the name (host/claim.h) */
	dev_t device;
	ino_t inode;
};

/* A socket that an earlier run has left there is replaced. 0 or -errno: -EADDRINUSE: another
 * process listens there; -EEXIST: something else has that name. */
int named_socket_open(struct named_socket *self, const char *path, int backlog);

/* Closes it, and removes the name if it is still that of this socket. */
void named_socket_close(struct named_socket *self, const char *path);

#endif
