/* SPDX-License-Identifier: Apache-2.0 */
#include "host/kept_file.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/claim.h"

enum {
	MODE = 0600,
	OPENINGS_MAX = 100, /* while another process replaces it */
};

/* The path still names the file that is open. */
static bool is_current(const char *path, int fd)
{
	struct stat own;
	struct stat named;

	return fstat(fd, &own) == 0 && lstat(path, &named) == 0 && own.st_dev == named.st_dev &&
	       own.st_ino == named.st_ino;
}

static const char *reason_of(int error)
{
	switch (error) {
	case ELOOP:
		return "a symbolic link, which is not followed; give the path of the file itself";
	case EISDIR:
	case EINVAL:
		return "not a regular file; give the path of one, or of one to make";
	case EWOULDBLOCK:
		return "another light has it";
	default:
		return strerror(error);
	}
}

static int open_once(const char *path)
{
	struct stat status;
	int error;
	const int fd =
		open(path, O_RDWR | O_APPEND | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, MODE);

	if (fd < 0) {
		return -errno;
	}
	error = fstat(fd, &status) != 0 ? errno : S_ISREG(status.st_mode) ? claim_file(fd) : EINVAL;
	if (error != 0) {
		close(fd);
		return -error;
	}
	/* One of before, that everybody could read. */
	if ((status.st_mode & 077) != 0) {
		(void)fchmod(fd, MODE);
	}
	return fd;
}

int kept_file_open(struct kept_file *self, const char *path, int fd, struct host_error *error)
{
	for (int i = 0; i < OPENINGS_MAX && (fd < 0 || !is_current(path, fd)); i++) {
		if (fd >= 0) {
			close(fd);
		}
		fd = open_once(path);
		if (fd < 0) {
			return host_error_set(error, "%s: %s", path, reason_of(-fd));
		}
	}
	*self = (struct kept_file){.path = path, .fd = fd};
	return 0;
}

void kept_file_close(struct kept_file *self)
{
	if (self->fd >= 0) {
		close(self->fd);
		self->fd = -1;
	}
}

off_t kept_file_length(const struct kept_file *self)
{
	struct stat status;

	return fstat(self->fd, &status) == 0 ? status.st_size : -errno;
}

int kept_file_read(const struct kept_file *self, size_t offset, void *buffer, size_t length)
{
	for (size_t done = 0; done < length;) {
		const ssize_t n = pread(self->fd, (uint8_t *)buffer + done, length - done,
		                        (off_t)(offset + done));

		if (n < 0 && errno != EINTR) {
			return -errno;
		}
		if (n == 0) {
			return -EIO;
		}
		done += n > 0 ? (size_t)n : 0;
	}
	return 0;
}

/* Onto the disk. */
static int write_all(int fd, const uint8_t *data, size_t length)
{
	for (size_t done = 0; done < length;) {
		const ssize_t n = write(fd, data + done, length - done);

		if (n < 0 && errno != EINTR) {
			return -errno;
		}
		done += n > 0 ? (size_t)n : 0;
	}
	return fdatasync(fd) == 0 ? 0 : -errno;
}

int kept_file_append(const struct kept_file *self, const void *data, size_t length)
{
	if (!is_current(self->path, self->fd)) {
		return -ENOENT;
	}
	return write_all(self->fd, data, length);
}

/* Makes a rename last. */
static int sync_directory(const char *path)
{
	char copy[PATH_MAX];
	int rc = 0;
	int fd;

	(void)snprintf(copy, sizeof(copy), "%s", path);
	fd = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
	if (fd < 0) {
		return -errno;
	}
	/* Some file systems cannot do this, and need not. */
	if (fsync(fd) != 0 && errno != EINVAL) {
		rc = -errno;
	}
	close(fd);
	return rc;
}

int kept_file_replace(struct kept_file *self, const void *data, size_t length, bool is_cut)
{
	char path[PATH_MAX + sizeof(".new")];
	int fd;
	int rc;

	(void)snprintf(path, sizeof(path), "%s.new", self->path);
	(void)unlink(path); /* left by a cut */
	fd = open(path, O_RDWR | O_APPEND | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, MODE);
	if (fd < 0) {
		return -errno;
	}
	rc = write_all(fd, data, length);
	if (rc == 0 && is_cut) {
		rc = -EIO;
	}
	if (rc == 0) {
		rc = -claim_file(fd);
	}
	if (rc == 0 && rename(path, self->path) != 0) {
		rc = -errno;
	}
	if (rc != 0) {
		close(fd);
		return rc;
	}
	close(self->fd);
	self->fd = fd;
	return sync_directory(self->path);
}
