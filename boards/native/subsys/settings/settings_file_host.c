/* SPDX-License-Identifier: Apache-2.0 */
/* Settings in a file of the host, or in memory. */
#include <errno.h>
#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include <sys/stat.h>
#include <sys/types.h>

#include "devices/bridge.h"
#include "host/carry.h"
#include "host/control.h"
#include "host/device_id.h"
#include "host/kept_file.h"
#include "host/module.h"
#include "host/say.h"
#include "settings_medium.h"

enum {
	MEMORY_SIZE = CONFIG_SETTINGS_STORAGE_SIZE
};

static char path[PATH_MAX];
static struct kept_file file = {.fd = -1};
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

/*
 * A call to the disk. In real time the thread that makes it waits as for a slow flash, while a
 * helper of the host does it and all else goes on.
 */
struct call {
	void *buffer;
	const void *data;
	size_t offset;
	size_t length;
	bool is_cut;
	off_t result;
};

static void do_length(void *arg)
{
	((struct call *)arg)->result = kept_file_length(&file);
}

static void do_read(void *arg)
{
	struct call *call = arg;

	call->result = kept_file_read(&file, call->offset, call->buffer, call->length);
}

static void do_append(void *arg)
{
	struct call *call = arg;

	call->result = kept_file_append(&file, call->data, call->length);
}

static void do_replace(void *arg)
{
	struct call *call = arg;

	call->result = kept_file_replace(&file, call->data, call->length, call->is_cut);
}

static int run(void (*work)(void *arg), struct call *call)
{
	bridge_wait_for(work, call);
	return call->result > INT_MAX ? -EFBIG : (int)call->result;
}

static int file_length(void)
{
	return run(do_length, &(struct call){0});
}

static int file_read(size_t offset, void *buffer, size_t length)
{
	struct call call = {.buffer = buffer, .offset = offset, .length = length};
	const int rc = run(do_read, &call);

	return rc == 0 && is_lost(offset, length) ? -EIO : rc;
}

static int file_append(const void *data, size_t length)
{
	const int at = file_length();
	size_t through;
	int rc;

	if (at < 0) {
		return at;
	}
	through = allowed_at((size_t)at, length);
	rc = run(do_append, &(struct call){.data = data, .length = through});
	return rc == 0 && through < length ? -EIO : rc;
}

static int file_replace(const void *data, size_t length)
{
	struct call call = {.data = data, .length = allowed(length)};
	int rc;

	call.is_cut = call.length < length || allowed(1) != 1;
	rc = run(do_replace, &call);
	if (rc == 0) {
		lost.size = 0;
	}
	return rc;
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

static int open_file(void)
{
	struct host_error error;
	size_t size = 0;
	const int *carried = carry_get("settings/file", &size);

	if (kept_file_open(&file, path, size == sizeof(*carried) ? *carried : -1, &error) != 0) {
		host_say("--settings: %s", error.text);
		return -1;
	}
	device_id_keep_with(path);
	return 0;
}

/* Memory stands for the board's flash: a reset does not clear it. */
static int start(void)
{
	size_t size = 0;
	const void *carried = carry_get("settings", &size);

	(void)carry_register("settings lost", &lost, sizeof(lost));
	if (path[0] != '\0') {
		return open_file();
	}
	if (carried != NULL && size <= sizeof(memory)) {
		memcpy(memory, carried, size);
		memory_length = size;
	}
	return 0;
}

static void save(void)
{
	bridge_finish();
	if (path[0] != '\0') {
		carry_put("settings/file", &file.fd, sizeof(file.fd));
		carry_fd(file.fd);
		return;
	}
	carry_put("settings", memory, memory_length);
}

static void stop(void)
{
	bridge_finish();
	kept_file_close(&file);
}

HOST_MODULE(settings_module) = {
	.name = "settings",
	.order = HOST_ORDER_BOARD,
	.options = options,
	.faults = faults,
	.start = start,
	.save = save,
	.stop = stop,
};
