/* SPDX-License-Identifier: Apache-2.0 */
#include "host/claim.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <libgen.h>
#include <limits.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

int claim_file(int fd)
{
	return flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK ? EWOULDBLOCK : 0;
}

int claim_output(const char *path, bool is_new, struct host_error *error)
{
	const int fd = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
	struct stat status;

	if (fd < 0) {
		return host_error_set(error, "%s: %s", path, strerror(errno));
	}
	if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
		return fd;
	}
	if (claim_file(fd) != 0) {
		close(fd);
		return host_error_set(error, "%s: another light has it", path);
	}
	if (is_new && ftruncate(fd, 0) != 0) {
		close(fd);
		return host_error_set(error, "%s: %s", path, strerror(errno));
	}
	return fd;
}

/* FNV-1a. */
static uint64_t hash(const char *text)
{
	uint64_t value = 0xCBF29CE484222325u;

	for (; *text != '\0'; text++) {
		value = (value ^ (uint8_t)*text) * 0x100000001B3u;
	}
	return value;
}

/* A socket in the abstract name space: the kernel lets one process bind each name, and forgets it
 * with the process. The name is that of the folder, whatever way leads there, and of what is in it.
 */
int claim_name(const char *path)
{
	struct sockaddr_un address = {.sun_family = AF_UNIX};
	char folder[PATH_MAX];
	char name[PATH_MAX];
	struct stat status;
	int length;
	int fd;

	(void)snprintf(folder, sizeof(folder), "%s", path);
	(void)snprintf(name, sizeof(name), "%s", path);
	if (stat(dirname(folder), &status) != 0) {
		return -1;
	}
	length = snprintf(address.sun_path + 1, sizeof(address.sun_path) - 1,
	                  "pharos-%" PRIx64 "-%" PRIx64 "-%" PRIx64, (uint64_t)status.st_dev,
	                  (uint64_t)status.st_ino, hash(basename(name)));
	fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
	if (fd < 0) {
		return -1;
	}
	if (bind(fd, (const struct sockaddr *)&address,
	         (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)length)) != 0) {
		const int error = errno;

		close(fd);
		errno = error;
		return -1;
	}
	return fd;
}
