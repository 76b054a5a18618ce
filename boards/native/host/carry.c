/* SPDX-License-Identifier: Apache-2.0 */
#include "host/carry.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/buffer.h"
#include "host/module.h"

#define CARRY_VARIABLE "PHAROS_CARRY_FD"
#define CARRY_MAGIC    0x50434152u /* "PCAR" */

enum {
	REGISTERED_MAX = 64,
	NAME_MAX_LENGTH = 48
};

/* The memfd holds a sequence of these, each followed by its data and by zeros up to the next. */
struct record {
	uint32_t magic;
	uint32_t size;
	char name[NAME_MAX_LENGTH];
};

_Static_assert(sizeof(struct record) % CARRY_ALIGNMENT == 0, "what follows is aligned");

struct registered {
	const char *name;
	void *data;
	size_t size;
};

static struct registered registered[REGISTERED_MAX];
static size_t registered_count;
static struct buffer carried;
static struct buffer saved;
static bool is_reset;
static char *const *arguments;

static _Noreturn void fail(const char *what)
{
	fprintf(stderr, "pharos: reset: %s: %s\n", what, strerror(errno));
	_exit(1);
}

static size_t padding(size_t size)
{
	return (CARRY_ALIGNMENT - size % CARRY_ALIGNMENT) % CARRY_ALIGNMENT;
}

void carry_put(const char *name, const void *data, size_t size)
{
	static const uint8_t zeros[CARRY_ALIGNMENT];
	struct record record = {.magic = CARRY_MAGIC, .size = (uint32_t)size};

	if (strlen(name) >= sizeof(record.name) || size > UINT32_MAX / 2) {
		abort();
	}
	memcpy(record.name, name, strlen(name));
	buffer_append(&saved, &record, sizeof(record), SIZE_MAX / 2);
	buffer_append(&saved, data, size, SIZE_MAX / 2);
	buffer_append(&saved, zeros, padding(size), SIZE_MAX / 2);
}

const void *carry_get(const char *name, size_t *size)
{
	struct record record;

	for (size_t at = carried.head; at + sizeof(record) <= carried.tail;) {
		memcpy(&record, carried.data + at, sizeof(record));
		at += sizeof(record);
		if (record.magic != CARRY_MAGIC || record.size > carried.tail - at) {
			break;
		}
		if (strncmp(record.name, name, sizeof(record.name)) == 0) {
			*size = record.size;
			return carried.data + at;
		}
		at += record.size + padding(record.size);
	}
	*size = 0;
	return NULL;
}

bool carry_register(const char *name, void *data, size_t size)
{
	size_t found;
	const void *old = carry_get(name, &found);

	if (registered_count == REGISTERED_MAX) {
		abort();
	}
	registered[registered_count++] = (struct registered){name, data, size};
	if (old == NULL || found != size) {
		return false;
	}
	memcpy(data, old, size);
	return true;
}

void carry_fd(int fd)
{
	const int flags = fcntl(fd, F_GETFD);

	if (flags >= 0) {
		fcntl(fd, F_SETFD, flags & ~FD_CLOEXEC);
	}
}

bool carry_is_reset(void)
{
	return is_reset;
}

static bool read_all(int fd, size_t size)
{
	uint8_t *room = buffer_reserve(&carried, size, size);

	while (buffer_length(&carried) < size) {
		const ssize_t n =
			pread(fd, room + carried.tail, size - carried.tail, (off_t)carried.tail);

		if (n <= 0) {
			return false;
		}
		carried.tail += (size_t)n;
	}
	return true;
}

void carry_load(char *const argv[])
{
	const char *variable = getenv(CARRY_VARIABLE);
	struct stat status;
	int fd;

	arguments = argv;
	if (variable == NULL) {
		return;
	}
	fd = atoi(variable);
	unsetenv(CARRY_VARIABLE);
	/* Somebody else's descriptor is no memfd of ours: seals are set on ours only. */
	if (fd <= STDERR_FILENO || fcntl(fd, F_GET_SEALS) < 0 ||
	    (fcntl(fd, F_GET_SEALS) & F_SEAL_WRITE) == 0 || fstat(fd, &status) != 0) {
		return;
	}
	is_reset = status.st_size > 0 && read_all(fd, (size_t)status.st_size);
	close(fd);
}

void carry_done(void)
{
	buffer_free(&carried);
}

/* A descriptor number may not be one of the three standard ones, even if these were closed. */
static int open_memfd(void)
{
	const int fd = memfd_create("pharos-carry", MFD_CLOEXEC | MFD_ALLOW_SEALING);
	int high;

	if (fd < 0) {
		fail("memfd_create");
	}
	high = fcntl(fd, F_DUPFD, STDERR_FILENO + 1);
	if (high < 0) {
		fail("dup");
	}
	close(fd);
	return high;
}

_Noreturn void carry_exec(void)
{
	char number[16];
	int fd;

	saved.head = 0;
	saved.tail = 0;
	for (size_t i = 0; i < registered_count; i++) {
		carry_put(registered[i].name, registered[i].data, registered[i].size);
	}
	host_save();
	fd = open_memfd();
	while (buffer_length(&saved) > 0) {
		const ssize_t n = write(fd, buffer_bytes(&saved), buffer_length(&saved));

		if (n < 0) {
			fail("write");
		}
		buffer_consume(&saved, (size_t)n);
	}
	if (fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW) != 0) {
		fail("seal");
	}
	snprintf(number, sizeof(number), "%d", fd);
	setenv(CARRY_VARIABLE, number, 1);
	execv("/proc/self/exe", arguments);
	fail("exec");
}
