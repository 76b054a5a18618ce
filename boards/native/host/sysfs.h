/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernel's sysfs: attributes are files of one line, devices are folders. Numbers in the names
 * of folders (hwmon3) may change with every boot, so devices are found by what they are called.
 *
 * Everything here may wait for a slow bus: start hooks and helpers (host/helper.h) only.
 */
#ifndef NATIVE_HOST_SYSFS_H_
#define NATIVE_HOST_SYSFS_H_

#include <stdbool.h>
#include <stddef.h>

#include "host/error.h"

enum {
	SYSFS_PATH_SIZE = 192,
	SYSFS_NAME_SIZE = 64,
	SYSFS_LINE_SIZE = 96,
};

/* A folder of devices of one kind. */
struct sysfs_class {
	const char *folder; /* below /sys: "class/hwmon" */
	const char *prefix; /* of its entries: "hwmon" */
	const char *name; /* attribute with a device's name; NULL: only its device's name counts */
	const char *what; /* for people: "hwmon sensor" */
};

/* False: --sysfs says that another folder stands for /sys. */
bool sysfs_is_real(void);

/*
 * The one device of that class that is called so, as a path. By its name; NAME@DEVICE where several
 * have it: DEVICE is what the device that it belongs to is called (0-0048), or its entry (hwmon3).
 * Where the class has no names: by its device's, its entry (pwmchip0), the number of that, or a
 * path of entry or device. 0; or -1 with a reason: there is none, or several.
 */
int sysfs_find(const struct sysfs_class *class, const char *called, char path[SYSFS_PATH_SIZE],
               struct host_error *error);

/* The line of an attribute without its end. 0 or -errno; -EIO: it is empty or too long. */
int sysfs_read(const char *folder, const char *attribute, char line[SYSFS_LINE_SIZE]);

/* A decimal number, perhaps with a fraction. 0 or -errno; -EIO: it is none. */
int sysfs_read_number(const char *folder, const char *attribute, double *number);

/* 0 or -errno. */
int sysfs_write(const char *folder, const char *attribute, const char *text);

bool sysfs_has(const char *folder, const char *attribute);

#endif
