/* SPDX-License-Identifier: Apache-2.0 */
#include "host/config.h"

#include <errno.h>
#include <ini.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "host/carry.h"
#include "host/module.h"

enum {
	TEXT_MAX = 65536,
	NAMES_MAX = 128,
};

static char *text; /* of the file; NULL: there is none */
static size_t text_length;
static char *values[NAMES_MAX]; /* options keep them */

struct reader {
	const char *path;
	int (*take)(const char *name, const char *value, struct host_error *error);
	struct host_error *error;
	size_t at;  /* in the text */
	int line;   /* the last one read */
	int failed; /* the line that error is about; 0: none */
	char *names[NAMES_MAX];
	int lines[NAMES_MAX];
	size_t count;
};

static void fail(struct reader *reader, const char *name, const char *reason)
{
	if (reader->failed == 0) {
		reader->failed = reader->line;
		(void)host_error_set(reader->error, "%s:%d: %s%s%s", reader->path, reader->line,
		                     name, name[0] != '\0' ? ": " : "", reason);
	}
}

/* As fgets(). */
static char *next_line(char *room, int size, void *stream)
{
	struct reader *reader = stream;
	const char *from = text + reader->at;
	const char *end = memchr(from, '\n', text_length - reader->at);
	const size_t length = end != NULL ? (size_t)(end - from) + 1 : text_length - reader->at;
	const size_t fits = length < (size_t)size ? length : (size_t)size - 1;

	if (length == 0) {
		return NULL;
	}
	reader->at += length;
	reader->line++;
	if (fits < length) {
		struct host_error reason;

		(void)host_error_set(&reason, "longer than %d bytes", size - 1);
		fail(reader, "", reason.text);
	} else if (memchr(from, '\0', length) != NULL) {
		fail(reader, "", "not text");
	}
	memcpy(room, from, fits);
	room[fits] = '\0';
	return room;
}

/* The line that has given the option already; 0: none. */
static int given(const struct reader *reader, const char *name)
{
	for (size_t i = 0; i < reader->count; i++) {
		if (strcmp(reader->names[i], name) == 0) {
			return reader->lines[i];
		}
	}
	return 0;
}

static int take_line(void *user, const char *section, const char *name, const char *value)
{
	struct reader *reader = user;
	struct host_error reason;
	const int before = given(reader, name);

	if (section[0] != '\0') {
		(void)host_error_set(&reason, "no section [%s]; options stand without one",
		                     section);
	} else if (before != 0) {
		(void)host_error_set(
			&reason,
			"given in line %d already (a line that begins with a blank goes "
			"on with the one before)",
			before);
	} else if (reader->count == NAMES_MAX) {
		(void)host_error_set(&reason, "more than %d options", NAMES_MAX);
	} else {
		char *const kept = strdup(value);
		char *const kept_name = strdup(name);

		if (kept == NULL || kept_name == NULL) {
			abort();
		}
		values[reader->count] = kept;
		reader->names[reader->count] = kept_name;
		reader->lines[reader->count++] = reader->line;
		if (reader->take(name, kept, &reason) == 0) {
			return 1;
		}
	}
	fail(reader, name, reason.text);
	return 0;
}

/* The file's bytes, or what a reset has kept of them. */
static int load(const char *path, struct host_error *error)
{
	size_t kept_length;
	const void *kept = carry_get("config", &kept_length);
	FILE *file;

	text = malloc(TEXT_MAX + 1);
	if (text == NULL) {
		return host_error_set(error, "%s: %s", path, strerror(ENOMEM));
	}
	if (kept != NULL && kept_length <= TEXT_MAX) {
		memcpy(text, kept, kept_length);
		text_length = kept_length;
		return 0;
	}
	file = fopen(path, "re");
	if (file == NULL) {
		return host_error_set(error, "%s: %s", path, strerror(errno));
	}
	errno = 0;
	text_length = fread(text, 1, TEXT_MAX + 1, file);
	if (ferror(file) || text_length > TEXT_MAX) {
		const int rc = host_error_set(error, "%s: %s", path,
		                              ferror(file) ? strerror(errno) : "more than 64 KiB");

		(void)fclose(file);
		return rc;
	}
	(void)fclose(file);
	return 0;
}

int config_read(const char *path,
                int (*take)(const char *name, const char *value, struct host_error *error),
                struct host_error *error)
{
	struct reader reader = {.path = path, .take = take, .error = error};
	int line;

	if (load(path, error) != 0) {
		return -1;
	}
	line = ini_parse_stream(next_line, &reader, take_line, &reader);
	for (size_t i = 0; i < reader.count; i++) {
		free(reader.names[i]);
	}
	if (line > 0 && (reader.failed == 0 || line < reader.failed)) {
		return host_error_set(error, "%s:%d: not as NAME = VALUE", path, line);
	}
	return reader.failed == 0 ? 0 : -1;
}

static void save(void)
{
	if (text != NULL) {
		carry_put("config", text, text_length);
	}
}

HOST_MODULE(config_module) = {
	.name = "config",
	.order = HOST_ORDER_BASE,
	.save = save,
};
