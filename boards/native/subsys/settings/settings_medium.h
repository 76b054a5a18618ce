/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where settings are kept: between the kernel's side and the host's. No header of either is
 * included.
 *
 * A medium holds one string of bytes. Functions return 0 (read: the length) or -errno.
 */
#ifndef SETTINGS_MEDIUM_H
#define SETTINGS_MEDIUM_H

#include <stddef.h>
#include <stdint.h>

struct settings_medium {
	/* The whole content. -EFBIG: more than max bytes. */
	int (*read)(void *buffer, size_t max);
	/* After a cut or an error, any number of the bytes may be there. */
	int (*append)(const void *data, size_t length);
	/* After a cut or an error, the old content is there, or the new one. */
	int (*replace)(const void *data, size_t length);
	/* "PATH", or NULL: in memory. */
	const char *(*path)(void);
};

/* The host's: the file of --settings, or memory. */
const struct settings_medium *settings_host_medium(void);

/* The fault: power fails after `bytes` more bytes have reached the medium (putting a replaced
 * content in force counts as one). From then on every write is -EIO, until settings_host_heal() or
 * a reset.
 */
void settings_host_tear(uint64_t bytes);
void settings_host_heal(void);

#endif
