/* SPDX-License-Identifier: Apache-2.0 */
#include "host/sysfs.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/module.h"

enum {
	FOUND_SIZE = 128 /* names in an error's line */
};

static const char *root = "/sys";

bool sysfs_is_real(void)
{
	return strcmp(root, "/sys") == 0;
}

/* --- attributes ---------------------------------------------------------------------------------
 */

static int open_attribute(const char *folder, const char *attribute, int flags)
{
	char path[2 * SYSFS_PATH_SIZE];

	if ((size_t)snprintf(path, sizeof(path), "%s/%s", folder, attribute) >= sizeof(path)) {
		errno = ENAMETOOLONG;
		return -1;
	}
	return open(path, flags | O_CLOEXEC);
}

int sysfs_read(const char *folder, const char *attribute, char line[SYSFS_LINE_SIZE])
{
	const int fd = open_attribute(folder, attribute, O_RDONLY);
	ssize_t length;
	int error;

	if (fd < 0) {
		return -errno;
	}
	length = read(fd, line, SYSFS_LINE_SIZE);
	error = errno;
	close(fd);
	if (length < 0) {
		return -error;
	}
	if (length == 0 || length == SYSFS_LINE_SIZE) {
		return -EIO;
	}
	line[length] = '\0';
	line[strcspn(line, "\n")] = '\0';
	return 0;
}

int sysfs_read_number(const char *folder, const char *attribute, double *number)
{
	char line[SYSFS_LINE_SIZE];
	char *end;
	const int rc = sysfs_read(folder, attribute, line);

	if (rc != 0) {
		return rc;
	}
	*number = strtod(line, &end);
	return end == line || *end != '\0' || !isfinite(*number) ? -EIO : 0;
}

int sysfs_write(const char *folder, const char *attribute, const char *text)
{
	const int fd = open_attribute(folder, attribute, O_WRONLY | O_TRUNC);
	ssize_t length;
	int error;

	if (fd < 0) {
		return -errno;
	}
	length = write(fd, text, strlen(text));
	error = errno;
	close(fd);
	return length < 0 ? -error : 0;
}

bool sysfs_has(const char *folder, const char *attribute)
{
	const int fd = open_attribute(folder, attribute, O_PATH);

	if (fd >= 0) {
		close(fd);
	}
	return fd >= 0;
}

/* --- devices ------------------------------------------------------------------------------------
 */

/* The name of the device behind an entry: its link `device`, or the folder that it lies in, unless
 * that is one of entries only. Empty: there is none. */
static void name_device(const struct sysfs_class *class, const char *path,
                        char name[SYSFS_NAME_SIZE])
{
	char link[SYSFS_PATH_SIZE + 16];
	char real[PATH_MAX];

	(void)snprintf(link, sizeof(link), "%s/device", path);
	if (realpath(link, real) == NULL) {
		(void)snprintf(link, sizeof(link), "%s/..", path);
		if (realpath(path, real) == NULL || strrchr(real, '/') == NULL) {
			name[0] = '\0';
			return;
		}
		*strrchr(real, '/') = '\0';
		if (strcmp(basename(real), basename(class->folder)) == 0) {
			real[0] = '\0';
		}
	}
	(void)snprintf(name, SYSFS_NAME_SIZE, "%s", basename(real));
}

struct search {
	const struct sysfs_class *class;
	char name[SYSFS_PATH_SIZE];
	const char *device; /* NULL: any */
	unsigned int found;
	char all[FOUND_SIZE];     /* "lm75, coretemp" */
	char several[FOUND_SIZE]; /* "lm75@0-0048, lm75@0-0049" */
};

static void add_word(char list[FOUND_SIZE], const char *name, const char *device)
{
	const size_t used = strlen(list);

	(void)snprintf(list + used, FOUND_SIZE - used, "%s%s%s%s", used > 0 ? ", " : "", name,
	               device != NULL ? "@" : "", device != NULL ? device : "");
}

/* By its name; without one of its own, also by its entry, by the number of that, or by a path of
 * entry or device. */
static bool is_called(const struct search *search, const char *path, const char *entry,
                      const char *name)
{
	char device[SYSFS_PATH_SIZE + 16];
	char real[PATH_MAX];
	char wanted[PATH_MAX];

	if (strcmp(name, search->name) == 0) {
		return true;
	}
	if (search->class->name != NULL) {
		return false;
	}
	if (search->name[0] != '/') {
		return strcmp(entry, search->name) == 0 ||
		       strcmp(entry + strlen(search->class->prefix), search->name) == 0;
	}
	(void)snprintf(device, sizeof(device), "%s/device", path);
	return realpath(search->name, wanted) != NULL &&
	       ((realpath(path, real) != NULL && strcmp(real, wanted) == 0) ||
	        (realpath(device, real) != NULL && strcmp(real, wanted) == 0));
}

/* True: the entry is one that is looked for. */
static bool look_at(struct search *search, const char *path, const char *entry)
{
	char line[SYSFS_LINE_SIZE];
	char device[SYSFS_NAME_SIZE];
	const char *name = device;

	name_device(search->class, path, device);
	if (search->class->name != NULL) {
		if (sysfs_read(path, search->class->name, line) != 0) {
			return false;
		}
		name = line;
	}
	add_word(search->all, name[0] != '\0' ? name : entry, NULL);
	if (!is_called(search, path, entry, name) ||
	    (search->device != NULL && strcmp(device, search->device) != 0 &&
	     strcmp(entry, search->device) != 0)) {
		return false;
	}
	add_word(search->several, name, device[0] != '\0' && name != device ? device : entry);
	return true;
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
	return strverscmp((*a)->d_name, (*b)->d_name);
}

static void look(struct search *search, char path[SYSFS_PATH_SIZE])
{
	const size_t prefix = strlen(search->class->prefix);
	char folder[SYSFS_PATH_SIZE];
	struct dirent **entries;
	int count;

	(void)snprintf(folder, sizeof(folder), "%s/%s", root, search->class->folder);
	count = scandir(folder, &entries, NULL, by_name);
	for (int i = 0; i < count; i++) {
		const char *entry = entries[i]->d_name;
		char whole[SYSFS_PATH_SIZE];

		if (strncmp(entry, search->class->prefix, prefix) == 0 &&
		    (size_t)snprintf(whole, sizeof(whole), "%s/%s", folder, entry) <
		            sizeof(whole) &&
		    look_at(search, whole, entry)) {
			search->found++;
			memcpy(path, whole, sizeof(whole));
		}
		free(entries[i]);
	}
	if (count >= 0) {
		free(entries);
	}
}

int sysfs_find(const struct sysfs_class *class, const char *called, char path[SYSFS_PATH_SIZE],
               struct host_error *error)
{
	struct search search = {.class = class};
	const char *at = strchr(called, '@');

	(void)snprintf(search.name, sizeof(search.name), "%.*s",
	               at != NULL ? (int)(at - called) : (int)strlen(called), called);
	search.device = at != NULL ? at + 1 : NULL;
	look(&search, path);
	if (search.found == 1) {
		return 0;
	}
	if (search.found > 1) {
		return host_error_set(error, "%u %ss are called %s; name one: %s", search.found,
		                      class->what, search.name, search.several);
	}
	return host_error_set(error, "no %s is called %s; there %s%s", class->what, called,
	                      search.all[0] != '\0' ? "are: " : "is none", search.all);
}

/* --- the module ---------------------------------------------------------------------------------
 */

static int parse_sysfs(const char *value, struct host_error *error)
{
	char real[PATH_MAX];

	if (value[0] != '/' || strlen(value) >= SYSFS_PATH_SIZE / 2) {
		return host_error_set(error, "\"%.60s\" is no absolute path shorter than %d", value,
		                      SYSFS_PATH_SIZE / 2);
	}
	/* by whatever name */
	root = realpath(value, real) != NULL && strcmp(real, "/sys") == 0 ? "/sys" : value;
	return 0;
}

static const struct host_option options[] = {
	{"sysfs", "FOLDER",
         "stands for /sys, for tests: files of --thermistor and --light are\n"
         "looked for there; only then they go with --time virtual",
         parse_sysfs},
	{0},
};

HOST_MODULE(sysfs_module) = {
	.name = "sysfs",
	.order = HOST_ORDER_BASE,
	.options = options,
};
