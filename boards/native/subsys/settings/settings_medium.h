/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where settings are kept: between the kernel's side and the host's. No header of either is
 * included.
 *
 * A medium holds one string of bytes, as a flash does: words of up to SETTINGS_WORD bytes, each
 * programmed once. A word that was being programmed when power failed may be such that nobody can
 * read it any more (its checksum is wrong), until the content is replaced. Functions return 0 or
 * -errno.
 */
#ifndef SETTINGS_MEDIUM_H
#define SETTINGS_MEDIUM_H

#include <stddef.h>
#include <stdint.h>

/* Whole words of any flash that there is: 8 bytes on an STM32G4, 32 on an H7. */
#define SETTINGS_WORD 32u

struct settings_medium {
	/* Of the content, or -errno. */
	int (*length)(void);
	/* Bytes of the content. -EIO: they are in a word that cannot be read, among others. */
	int (*read)(size_t offset, void *buffer, size_t length);
	/* Whole words. After a cut or an error any number of the bytes may be there, the last word
	 * unreadable. */
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
 * a reset. word: 1…SETTINGS_WORD, the bytes of a word of this flash; one that was only begun cannot
 * be read from then on.
 */
void settings_host_tear(uint64_t bytes, size_t word);
void settings_host_heal(void);

#endif
