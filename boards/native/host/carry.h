/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What survives a reset. A reset of the board is an exec of this program by itself, so that nothing
 * of the device's memory survives by accident; the world around it (sockets, board time, heat,
 * recorder) is carried over in a memfd, by name.
 *
 * Fixed-size plain data (no pointers): carry_register() in the module's start hook. Anything else:
 * carry_put() in its save hook and carry_get() in its start hook. Descriptors: carry_fd() in the
 * save hook, and the number as part of the data.
 */
#ifndef NATIVE_HOST_CARRY_H_
#define NATIVE_HOST_CARRY_H_

#include <stdbool.h>
#include <stddef.h>

#define CARRY_ALIGNMENT 8

/* Saved at each reset under this name; carried data, if there is any of this size, is copied in:
 * true then. */
bool carry_register(const char *name, void *data, size_t size);

/* Save hooks only. */
void carry_put(const char *name, const void *data, size_t size);

/* Save hooks only: this descriptor stays open over the exec (all others are close-on-exec). */
void carry_fd(int fd);

/* What was saved under this name and its size, aligned to CARRY_ALIGNMENT; NULL: nothing. Valid in
 * start hooks. */
const void *carry_get(const char *name, size_t *size);

/* This process's kernel was started by a reset, not by power-on. */
bool carry_is_reset(void);

/* main() only. */
void carry_load(char *const argv[]);
void carry_done(void);

/* Save hooks, memfd, exec. port_reset() calls it. */
_Noreturn void carry_exec(void);

#endif
