/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Settings: named values that survive a reset. The subset of Zephyr's API that the native port has;
 * semantics are those of Zephyr 3.4.
 *
 * A name is a path, "light/brightness". A module registers a handler for a subtree; loading calls
 * its h_set for each stored value, then its h_commit. From threads only.
 *
 * The native store is a file (`--settings PATH`), or memory that lasts as long as the process and
 * its resets. A value is written whole or not at all: after a cut at any instant, the old or the
 * new one is read, never a mix.
 */
#ifndef ZEPHYR_SETTINGS_SETTINGS_H
#define ZEPHYR_SETTINGS_SETTINGS_H

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include <zephyr/sys/iterable_sections.h>
#include <zephyr/sys/slist.h>

#define SETTINGS_MAX_DIR_DEPTH  8
#define SETTINGS_MAX_NAME_LEN   (8 * SETTINGS_MAX_DIR_DEPTH)
#define SETTINGS_MAX_VAL_LEN    256
#define SETTINGS_NAME_SEPARATOR '/'
#define SETTINGS_NAME_END       '='
/* Room for separators and the terminator. */
#define SETTINGS_EXTRA_LEN      ((SETTINGS_MAX_DIR_DEPTH - 1) + 2)

/* Copies at most len bytes of the stored value; returns how many, or -errno. */
typedef ssize_t (*settings_read_cb)(void *cb_arg, void *data, size_t len);

/* Any function may be NULL, except h_set when values of the subtree are stored.
 * key: the rest of the name after the subtree, NULL when nothing is left. Return 0 or -errno.
 */
#define SETTINGS_HANDLER_FIELDS                                                                    \
	const char *name;                                                                          \
	/* Returns the length of the value. */                                                     \
	int (*h_get)(const char *key, char *val, int val_len_max);                                 \
	int (*h_set)(const char *key, size_t len, settings_read_cb read_cb, void *cb_arg);         \
	int (*h_commit)(void);                                                                     \
	/* Calls export_func with the full name of each value. */                                  \
	int (*h_export)(int (*export_func)(const char *name, const void *val, size_t val_len))

struct settings_handler_static {
	SETTINGS_HANDLER_FIELDS;
};

struct settings_handler {
	SETTINGS_HANDLER_FIELDS;
	sys_snode_t node;
};

/* Registers at build time. */
#define SETTINGS_STATIC_HANDLER_DEFINE(_hname, _tree, _get, _set, _commit, _export)                \
	const STRUCT_SECTION_ITERABLE(settings_handler_static, settings_handler_##_hname) = {      \
		.name = (_tree),                                                                   \
		.h_get = (_get),                                                                   \
		.h_set = (_set),                                                                   \
		.h_commit = (_commit),                                                             \
		.h_export = (_export),                                                             \
	}

/* Opens the store; again: does nothing. 0, or -errno (-EBADMSG: the file is no settings file; it is
 * left as it is, and nothing can be saved).
 */
int settings_subsys_init(void);

/* cf stays the caller's and must live on. -EEXIST: the subtree has a handler. */
int settings_register(struct settings_handler *cf);

/* Hands what is stored to the handlers, then commits. 0, or the first error of a commit. */
int settings_load(void);
int settings_load_subtree(const char *subtree);

/* cb: as h_set, and param. Non-zero stops. 0 or -errno. */
typedef int (*settings_load_direct_cb)(const char *key, size_t len, settings_read_cb read_cb,
                                       void *cb_arg, void *param);
int settings_load_subtree_direct(const char *subtree, settings_load_direct_cb cb, void *param);

/* Writes one value, unless that is what is stored. It is stored for good when this returns 0.
 * val_len 0 deletes. -EINVAL: name or value too long; -ENOSPC; -EBUSY: called while loading; or
 * what the host said, and the old value stays.
 */
int settings_save_one(const char *name, const void *value, size_t val_len);
int settings_delete(const char *name);

/* Asks every handler to export. 0, or the first error. */
int settings_save(void);

int settings_commit(void);
int settings_commit_subtree(const char *subtree);

/* Does name begin with the whole words of key? *next: the rest after the separator, or NULL. 1:
 * yes. */
int settings_name_steq(const char *name, const char *key, const char **next);

/* Length of the first word of name; *next: the rest after the separator, or NULL. */
int settings_name_next(const char *name, const char **next);

/* The handler of the longest subtree that holds name, or NULL; *next as above. */
struct settings_handler_static *settings_parse_and_lookup(const char *name, const char **next);

#endif
