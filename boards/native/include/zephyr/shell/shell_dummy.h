/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A shell without a terminal, for tests: what commands print is kept.
 * Its source is boards/native/subsys/shell/shell_dummy.c, which a test adds to its own.
 */
#ifndef ZEPHYR_SHELL_SHELL_DUMMY_H
#define ZEPHYR_SHELL_SHELL_DUMMY_H

#include <zephyr/shell/shell.h>

const struct shell *shell_backend_dummy_get_ptr(void);

/* The output so far, terminated; *sizep its length. Empties the buffer for what comes next; the
 * text stays until then. Output beyond CONFIG_SHELL_BACKEND_DUMMY_BUF_SIZE - 1 bytes is lost.
 */
const char *shell_backend_dummy_get_output(const struct shell *sh, size_t *sizep);

void shell_backend_dummy_clear_output(const struct shell *sh);

/* Bytes as from a terminal; returns how many were taken. */
size_t shell_backend_dummy_push_input(const struct shell *sh, const void *data, size_t length);

#endif
