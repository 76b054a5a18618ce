/* SPDX-License-Identifier: Apache-2.0 */
#include "host/named_socket.h"

#include <errno.h>
#include <stdio.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "host/claim.h"

static int listen_at(struct named_socket *self, const char *path, int backlog)
{
	struct sockaddr_un address = {.sun_family = AF_UNIX};
	struct stat status;

	if (lstat(path, &status) == 0) {
		if (!S_ISSOCK(status.st_mode)) {
			return -EEXIST;
		}
		unlink(path); /* left by an earlier run */
	}
	(void)snprintf(address.sun_path, sizeof(address.sun_path), "%s", path);
	self->fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
	if (self->fd < 0 ||
	    bind(self->fd, (const struct sockaddr *)&address, sizeof(address)) != 0 ||
	    listen(self->fd, backlog) != 0 || lstat(path, &status) != 0) {
		return -errno;
	}
	self->device = status.st_dev;
	self->inode = status.st_ino;
	return 0;
}

int named_socket_open(struct named_socket *self, const char *path, int backlog)
{
	int rc;

	*self = (struct named_socket){.fd = -1, .claim = claim_name(path)};
	if (self->claim < 0) {
		return -errno;
	}
	rc = listen_at(self, path, backlog);
	if (rc != 0) {
		if (self->fd >= 0) {
			close(self->fd);
		}
		close(self->claim);
	}
	return rc;
}

void named_socket_close(struct named_socket *self, const char *path)
{
	struct stat status;

	if (lstat(path, &status) == 0 && status.st_dev == self->device &&
	    status.st_ino == self->inode) {
		unlink(path);
	}
	close(self->fd);
	close(self->claim);
}
