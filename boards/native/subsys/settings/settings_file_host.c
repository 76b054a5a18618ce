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

/* The fault: how many bytes still get through, and which word a cut has left unreadable. */
static uint64_t bytes_left;
static size_t word_size = 1;
static struct {
	size_t at;
	size_t size; /* 0: none */
} lost;
static bool is_armed;
static bool is_dead;

void settings_host_tear(uint64_t bytes, size_t word)
{
	bytes_left = bytes;
	word_size = word;
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

/* The same, where the bytes are appended to a content of `at` bytes. */
static size_t allowed_at(size_t at, size_t length)
{
	const size_t through = allowed(length);

	if (through < length && through % word_size != 0) {
		lost.at = at + through - through % word_size;
		lost.size = word_size;
	}
	return through;
}

static bool is_lost(size_t offset, size_t length)
{
	return lost.size != 0 && offset < lost.at + lost.size && lost.at < offset + length;
}

/* --- in memory -------------------------------------------------------------------------------- */

static int memory_size(void)
{
	return (int)memory_length;
}

static int memory_read(size_t offset, void *buffer, size_t length)
{
	if (is_lost(offset, length)) {
		return -EIO;
	}
	memcpy(buffer, &memory[offset], length);
	return 0;
}

static int memory_append(const void *data, size_t length)
{
	if (length > sizeof(memory) - memory_length) {
		return -ENOSPC;
	}
	const size_t count = allowed_at(memory_length, length);

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
	lost.size = 0;
	return 0;
}

static const char *memory_path(void)
{
	return NULL;
}

static const struct settings_medium memory_medium = {
	.length = memory_size,
	.read = memory_read,
	.append = memory_append,
	.replace = memory_replace,
	.path = memory_path,
};

/* --- in a file -------------------------------------------------------------------------------- */

static int file_length(void)
{
	struct stat status;

	if (stat(path, &status) != 0) {
		return errno == ENOENT ? 0 : -errno;
	}
	return status.st_size > INT_MAX ? -EFBIG : (int)status.st_size;
}

static int file_read(size_t offset, void *buffer, size_t length)
{
	const int fd = open(path, O_RDONLY | O_CLOEXEC);
	size_t done = 0;
	ssize_t count = 0;

	if (fd < 0) {
		return -errno;
	}
	while (done < length && (count = pread(fd, (uint8_t *)buffer + done, length - done,
	                                       (off_t)(offset + done))) > 0) {
		done += (size_t)count;
	}
	const int rc = count < 0 ? -errno : done < length || is_lost(offset, length) ? -EIO : 0;

	(void)close(fd);
	return rc;
}

/* through: how many bytes reach the disk. */
static int write_all(int fd, const uint8_t *data, size_t length, size_t through)
{
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

	return fd < 0 ? -errno
	              : finish(fd, write_all(fd, data, length,
	                                     allowed_at((size_t)file_length(), length)));
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
	rc = finish(fd, write_all(fd, data, length, allowed(length)));
	if (rc == 0 && allowed(1) != 1) {
		rc = -EIO;
	}
	if (rc == 0 && rename(new_path, path) != 0) {
		rc = -errno;
	}
	if (rc == 0) {
		lost.size = 0;
	}
	return rc == 0 ? sync_directory() : rc;
}

static const char *file_path(void)
{
	return path;
}

static const struct settings_medium file_medium = {
	.length = file_length,
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
	int64_t word = 1;

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
	if (!control_integer(call, "byte", 0, INT64_MAX, &byte) ||
	    !control_integer_or(call, "word", 1, SETTINGS_WORD, &word)) {
		return CONTROL_ERROR;
	}
	settings_host_tear((uint64_t)byte, (size_t)word);
	return CONTROL_OK;
}

static const struct control_fault faults[] = {
	{"storage",
         "kind torn with byte: writing fails after that many more bytes, until a reset, and a word "
         "of "
         "so many bytes (word, default 1) that was only begun cannot be read; kind none",
         set_fault},
	{0},
};

/* Memory stands for the board's flash: a reset does not clear it. */
static int start(void)
{
	size_t size = 0;
	const void *carried = carry_get("settings", &size);

	(void)carry_register("settings lost", &lost, sizeof(lost));
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
