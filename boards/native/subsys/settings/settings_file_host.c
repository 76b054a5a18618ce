/* SPDX-License-Identifier: Apache-2.0 */
/* Settings in a file of the host, or in memory. */
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/carry.h"
#include "host/control.h"
#include "host/module.h"
#include "settings_medium.h"

enum {
	MEMORY_SIZE = CONFIG_SETTINGS_STORAGE_SIZE
};

static char path[PATH_MAX];
static uint8_t memory[MEMORY_SIZE];
static size_t memory_length;

/* The fault: how many bytes still get through. */
static uint64_t bytes_left;
static bool is_armed;
static bool is_dead;

void settings_host_tear(uint64_t bytes)
{
	bytes_left = bytes;
	is_armed = true;
	is_dead = false;
}

void settings_host_heal(void)
{
	is_armed = false;
	is_dead = false;
}

/* How many of these bytes get through before power fails. */
static size_t allowed(size_t length)
{
	if (is_dead) {
		return 0;
	}
	if (is_armed && length > bytes_left) {
		is_dead = true;
		length = (size_t)bytes_left;
	}
	if (is_armed) {
		bytes_left -= length;
	}
	return length;
}

/* --- in memory -------------------------------------------------------------------------------- */

static int memory_read(void *buffer, size_t max)
{
	if (memory_length > max) {
		return -EFBIG;
	}
	memcpy(buffer, memory, memory_length);
	return (int)memory_length;
}

static int memory_append(const void *data, size_t length)
{
	const size_t count = allowed(length);

	if (length > sizeof(memory) - memory_length) {
		return -ENOSPC;
	}
	memcpy(&memory[memory_length], data, count);
	memory_length += count;
	return count == length ? 0 : -EIO;
}

static int memory_replace(const void *data, size_t length)
{
	if (length > sizeof(memory)) {
		return -ENOSPC;
	}
	/* The new content is in force all at once; that is the one byte more. */
	if (allowed(length) != length || allowed(1) != 1) {
		return -EIO;
	}
	memcpy(memory, data, length);
	memory_length = length;
	return 0;
}

static const char *memory_path(void)
{
	return NULL;
}

static const struct settings_medium memory_medium = {
	.read = memory_read,
	.append = memory_append,
	.replace = memory_replace,
	.path = memory_path,
};

/* --- in a file -------------------------------------------------------------------------------- */

static int file_read(void *buffer, size_t max)
{
	const int fd = open(path, O_RDONLY | O_CLOEXEC);
	size_t length = 0;
	ssize_t count = 0;
	char more;

	if (fd < 0) {
		return errno == ENOENT ? 0 : -errno;
	}
	while (length < max && (count = read(fd, (uint8_t *)buffer + length, max - length)) > 0) {
		length += (size_t)count;
	}
	if (count >= 0 && length == max) {
		count = read(fd, &more, 1);
		if (count > 0) {
			(void)close(fd);
			return -EFBIG;
		}
	}
	if (count < 0) {
		length = 0;
	}
	count = count < 0 ? -errno : 0;
	(void)close(fd);
	return count < 0 ? (int)count : (int)length;
}

static int write_all(int fd, const uint8_t *data, size_t length)
{
	const size_t through = allowed(length);
	size_t done = 0;

	while (done < through) {
		const ssize_t count = write(fd, data + done, through - done);

		if (count < 0 && errno != EINTR) {
			return -errno;
		}
		done += count > 0 ? (size_t)count : 0;
	}
	return through == length ? 0 : -EIO;
}

/* Closes fd after its bytes are on the disk; rc: what has happened before. */
static int finish(int fd, int rc)
{
	if (rc == 0 && fdatasync(fd) != 0) {
		rc = -errno;
	}
	if (close(fd) != 0 && rc == 0) {
		rc = -errno;
	}
	return rc;
}

static int file_append(const void *data, size_t length)
{
	/* Not created here: a new file begins with a replace. */
	const int fd = open(path, O_WRONLY | O_APPEND | O_CLOEXEC);

	return fd < 0 ? -errno : finish(fd, write_all(fd, data, length));
}

/* Makes a rename last. */
static int sync_directory(void)
{
	char copy[PATH_MAX];
	int fd;
	int rc = 0;

	memcpy(copy, path, sizeof(copy));
	fd = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
	if (fd < 0) {
		return -errno;
	}
	/* Some file systems cannot do this, and need not. */
	if (fsync(fd) != 0 && errno != EINVAL) {
		rc = -errno;
	}
	(void)close(fd);
	return rc;
}

static int file_replace(const void *data, size_t length)
{
	char new_path[PATH_MAX + 4];
	int fd;
	int rc;

	(void)snprintf(new_path, sizeof(new_path), "%s.new", path);
	fd = open(new_path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
	if (fd < 0) {
		return -errno;
	}
	rc = finish(fd, write_all(fd, data, length));
	if (rc == 0 && allowed(1) != 1) {
		rc = -EIO;
	}
	if (rc == 0 && rename(new_path, path) != 0) {
		rc = -errno;
	}
	return rc == 0 ? sync_directory() : rc;
}

static const char *file_path(void)
{
	return path;
}

static const struct settings_medium file_medium = {
	.read = file_read,
	.append = file_append,
	.replace = file_replace,
	.path = file_path,
};

const struct settings_medium *settings_host_medium(void)
{
	return path[0] == '\0' ? &memory_medium : &file_medium;
}

/* --- the module ------------------------------------------------------------------------------- */

static int parse_path(const char *value, struct host_error *error)
{
	struct stat status;

	if (value[0] == '\0' || strlen(value) >= sizeof(path)) {
		return host_error_set(error, "the path of a file, shorter than %zu bytes",
		                      sizeof(path));
	}
	if (stat(value, &status) == 0 && !S_ISREG(status.st_mode)) {
		return host_error_set(
			error, "%s is not a regular file; give the path of one, or of one to make",
			value);
	}
	memcpy(path, value, strlen(value) + 1);
	return 0;
}

static const struct host_option options[] = {
	{"settings", "PATH", "keep settings in this file (default: in memory)", parse_path},
	{0},
};

static enum control_result set_fault(struct control_call *call)
{
	const char *kind;
	int64_t byte;

	if (!control_string(call, "kind", &kind)) {
		return CONTROL_ERROR;
	}
	if (strcmp(kind, "none") == 0) {
		settings_host_heal();
		return CONTROL_OK;
	}
	if (strcmp(kind, "torn") != 0) {
		return control_fail(call, "storage has no fault \"%.40s\"; there are none, torn",
		                    kind);
	}
	if (!control_integer(call, "byte", 0, INT64_MAX, &byte)) {
		return CONTROL_ERROR;
	}
	settings_host_tear((uint64_t)byte);
	return CONTROL_OK;
}

static const struct control_fault faults[] = {
	{"storage",
         "kind torn with byte: writing fails after that many more bytes, until a reset; kind none",
         set_fault},
	{0},
};

/* Memory stands for the board's flash: a reset does not clear it. */
static int start(void)
{
	size_t size = 0;
	const void *carried = carry_get("settings", &size);

	if (carried != NULL && size <= sizeof(memory)) {
		memcpy(memory, carried, size);
		memory_length = size;
	}
	return 0;
}

static void save(void)
{
	carry_put("settings", memory, memory_length);
}

HOST_MODULE(settings_module) = {
	.name = "settings",
	.order = HOST_ORDER_BOARD,
	.options = options,
	.faults = faults,
	.start = start,
	.save = save,
};
