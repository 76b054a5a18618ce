/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdbool.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/settings/settings.h>

#include "devices/fault.h"
#include "settings_store.h"

LOG_MODULE_REGISTER(settings, CONFIG_SETTINGS_LOG_LEVEL);

BUILD_ASSERT(SETTINGS_MAX_NAME_LEN <= SETTINGS_RECORD_NAME_MAX, "a record holds the longest name");
BUILD_ASSERT(SETTINGS_MAX_VAL_LEN <= SETTINGS_RECORD_VALUE_MAX, "a record holds the longest value");

static K_MUTEX_DEFINE(settings_lock);
static sys_slist_t dynamic_handlers = SYS_SLIST_STATIC_INIT(&dynamic_handlers);
static struct settings_records store;
static bool is_open;
static bool loading;

/* --- names ------------------------------------------------------------------------------------ */

static bool is_end(char c)
{
	return c == '\0' || c == SETTINGS_NAME_END;
}

int settings_name_steq(const char *name, const char *key, const char **next)
{
	const size_t length = key == NULL ? 0 : strlen(key);

	if (next != NULL) {
		*next = NULL;
	}
	if (name == NULL || key == NULL || strncmp(name, key, length) != 0 ||
	    memchr(name, SETTINGS_NAME_END, length) != NULL) {
		return 0;
	}
	if (name[length] == SETTINGS_NAME_SEPARATOR) {
		if (next != NULL) {
			*next = &name[length + 1];
		}
		return 1;
	}
	return is_end(name[length]);
}

int settings_name_next(const char *name, const char **next)
{
	int length = 0;

	if (next != NULL) {
		*next = NULL;
	}
	if (name == NULL) {
		return 0;
	}
	while (!is_end(name[length]) && name[length] != SETTINGS_NAME_SEPARATOR) {
		length++;
	}
	if (next != NULL && name[length] == SETTINGS_NAME_SEPARATOR) {
		*next = &name[length + 1];
	}
	return length;
}

/* --- handlers --------------------------------------------------------------------------------- */

/* A registered handler as a static one: the fields before the list node are the same. */
static struct settings_handler_static *as_static(struct settings_handler *handler)
{
	return (struct settings_handler_static *)(void *)handler;
}

BUILD_ASSERT(offsetof(struct settings_handler, h_export) ==
                     offsetof(struct settings_handler_static, h_export),
             "both kinds of handler begin alike");

/* Calls visit for static handlers, then for registered ones, while it returns true. */
static void for_each_handler(bool (*visit)(struct settings_handler_static *handler, void *arg),
                             void *arg)
{
	struct settings_handler *handler;

	STRUCT_SECTION_FOREACH(settings_handler_static, fixed) {
		if (!visit(fixed, arg)) {
			return;
		}
	}
	SYS_SLIST_FOR_EACH_CONTAINER(&dynamic_handlers, handler, node) {
		if (!visit(as_static(handler), arg)) {
			return;
		}
	}
}

struct lookup {
	const char *name;
	struct settings_handler_static *best;
	const char *rest;
};

static bool visit_lookup(struct settings_handler_static *handler, void *arg)
{
	struct lookup *lookup = arg;
	const char *rest;

	/* Of two subtrees that hold the name, the longer one is within the other. */
	if (settings_name_steq(lookup->name, handler->name, &rest) != 0 &&
	    (lookup->best == NULL ||
	     settings_name_steq(handler->name, lookup->best->name, NULL) != 0)) {
		lookup->best = handler;
		lookup->rest = rest;
	}
	return true;
}

struct settings_handler_static *settings_parse_and_lookup(const char *name, const char **next)
{
	struct lookup lookup = {.name = name};

	for_each_handler(visit_lookup, &lookup);
	if (next != NULL) {
		*next = lookup.rest;
	}
	return lookup.best;
}

static bool visit_same_name(struct settings_handler_static *handler, void *arg)
{
	const char **name = arg;

	if (strcmp(handler->name, *name) == 0) {
		*name = NULL;
		return false;
	}
	return true;
}

int settings_register(struct settings_handler *cf)
{
	const char *name = cf->name;

	(void)k_mutex_lock(&settings_lock, K_FOREVER);
	for_each_handler(visit_same_name, &name);
	if (name != NULL) {
		sys_slist_append(&dynamic_handlers, &cf->node);
	}
	(void)k_mutex_unlock(&settings_lock);
	return name == NULL ? -EEXIST : 0;
}

struct commit {
	const char *subtree;
	int rc;
};

static bool visit_commit(struct settings_handler_static *handler, void *arg)
{
	struct commit *commit = arg;

	if (handler->h_commit != NULL &&
	    (commit->subtree == NULL ||
	     settings_name_steq(handler->name, commit->subtree, NULL) != 0)) {
		const int rc = handler->h_commit();

		commit->rc = commit->rc == 0 ? rc : commit->rc;
	}
	return true;
}

int settings_commit_subtree(const char *subtree)
{
	struct commit commit = {.subtree = subtree};

	for_each_handler(visit_commit, &commit);
	return commit.rc;
}

int settings_commit(void)
{
	return settings_commit_subtree(NULL);
}

static bool visit_export(struct settings_handler_static *handler, void *arg)
{
	int *first_rc = arg;

	if (handler->h_export != NULL) {
		const int rc = handler->h_export(settings_save_one);

		*first_rc = *first_rc == 0 ? rc : *first_rc;
	}
	return true;
}

int settings_save(void)
{
	int rc = 0;

	for_each_handler(visit_export, &rc);
	return rc;
}

/* --- the store -------------------------------------------------------------------------------- */

int settings_subsys_init(void)
{
	int rc = 0;

	(void)k_mutex_lock(&settings_lock, K_FOREVER);
	if (!is_open) {
		rc = fault_pass(BOARD_CHIP_STORAGE);
	}
	if (!is_open && rc == 0) {
		rc = settings_records_open(&store, settings_host_medium());
		is_open = rc == 0;
	}
	(void)k_mutex_unlock(&settings_lock);
	if (rc == -EBADMSG) {
		LOG_ERR("%s is not a settings file: it is left as it is, nothing will be saved",
		        settings_host_medium()->path());
	} else if (rc != 0) {
		LOG_ERR("cannot read the settings: error %d", rc);
	} else if (store.lost) {
		LOG_ERR("nothing that was stored can be read");
	} else if (store.stats.broken > 0) {
		LOG_WRN("%u broken records left out", (unsigned int)store.stats.broken);
	}
	return rc;
}

void settings_store_close(void)
{
	(void)k_mutex_lock(&settings_lock, K_FOREVER);
	is_open = false;
	store.medium = NULL;
	(void)k_mutex_unlock(&settings_lock);
}

void settings_store_status(struct settings_store_status *status)
{
	(void)k_mutex_lock(&settings_lock, K_FOREVER);
	status->path = settings_host_medium()->path();
	status->used = is_open ? store.length : 0;
	status->live = is_open ? store.live : 0;
	status->stats = store.stats;
	(void)k_mutex_unlock(&settings_lock);
}

static ssize_t read_value(void *cb_arg, void *data, size_t len)
{
	const struct settings_record *record = cb_arg;
	const size_t count = MIN(len, record->value_length);

	memcpy(data, record->value, count);
	return (ssize_t)count;
}

/* One stored value to the handler of its subtree. A handler that refuses a value does not keep the
 * others from theirs.
 */
static void hand_over(const char *name, struct settings_record *record)
{
	const char *key;
	struct settings_handler_static *handler = settings_parse_and_lookup(name, &key);
	int rc;

	if (handler == NULL || handler->h_set == NULL) {
		return;
	}
	rc = handler->h_set(key, record->value_length, read_value, record);
	if (rc != 0) {
		LOG_ERR("%s was refused by its owner: error %d", name, rc);
	}
}

/* cb NULL: to the handlers. */
static int load(const char *subtree, settings_load_direct_cb cb, void *param)
{
	char name[SETTINGS_RECORD_NAME_MAX + 1];
	struct settings_record record;
	size_t cursor = 0;
	int rc = 0;

	if (!is_open) {
		return -ENODEV;
	}
	loading = true;
	while (rc == 0 && settings_records_next(&store, &cursor, &record)) {
		const char *key = name;

		memcpy(name, record.name, record.name_length);
		name[record.name_length] = '\0';
		if (subtree != NULL && settings_name_steq(name, subtree, &key) == 0) {
			continue;
		}
		if (cb == NULL) {
			hand_over(name, &record);
		} else {
			rc = cb(key, record.value_length, read_value, &record, param);
		}
	}
	loading = false;
	return store.lost ? -EIO : 0;
}

int settings_load_subtree(const char *subtree)
{
	int rc;

	(void)k_mutex_lock(&settings_lock, K_FOREVER);
	rc = load(subtree, NULL, NULL);
	if (rc == 0) {
		rc = settings_commit_subtree(subtree);
	}
	(void)k_mutex_unlock(&settings_lock);
	return rc;
}

int settings_load(void)
{
	return settings_load_subtree(NULL);
}

int settings_load_subtree_direct(const char *subtree, settings_load_direct_cb cb, void *param)
{
	int rc;

	(void)k_mutex_lock(&settings_lock, K_FOREVER);
	rc = load(subtree, cb, param);
	(void)k_mutex_unlock(&settings_lock);
	return rc;
}

int settings_save_one(const char *name, const void *value, size_t val_len)
{
	int rc;

	if (name == NULL || (value == NULL && val_len > 0)) {
		return -EINVAL;
	}
	(void)k_mutex_lock(&settings_lock, K_FOREVER);
	/* A save may move what is being loaded. */
	rc = loading ? -EBUSY : fault_pass(BOARD_CHIP_STORAGE);
	if (rc == 0) {
		rc = settings_records_save(&store, name, value, val_len);
	}
	(void)k_mutex_unlock(&settings_lock);
	return rc;
}

int settings_delete(const char *name)
{
	return settings_save_one(name, NULL, 0);
}
