/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Names as people type them: in either case.
 */
#ifndef PHAROS_THREADS_SHELL_NAMES_H
#define PHAROS_THREADS_SHELL_NAMES_H

#include <stdbool.h>

/* The name begins with the word. */
bool names_begin(const char *name, const char *word);

/* The name is the word. */
bool names_equal(const char *name, const char *word);

#endif
