/* SPDX-License-Identifier: Apache-2.0 */
/* The settings API over the host's store: in memory here, since the suite is started without
 * --settings. */
#include <errno.h>
#include <string.h>

#include <zephyr/kernel.h>
#include <zephyr/settings/settings.h>
#include <zephyr/ztest.h>

#include "subsys/settings/settings_store.h"

static uint32_t level;
static char label[16];
static size_t label_length;
static int commits;
static int sets;
static int refuse;
static int save_while_loading;

static int light_set(const char *key, size_t len, settings_read_cb read_cb, void *cb_arg)
{
	sets++;
	if (save_while_loading != 0) {
		save_while_loading = settings_save_one("light/level", "x", 1);
	}
	if (refuse != 0) {
		return refuse;
	}
	if (key == NULL) {
		return -ENOENT;
	}
	if (strcmp(key, "level") == 0) {
		return len == sizeof(level) &&
		                       read_cb(cb_arg, &level, sizeof(level)) == sizeof(level)
		               ? 0
		               : -EINVAL;
	}
	if (strcmp(key, "label") == 0) {
		const ssize_t count = read_cb(cb_arg, label, sizeof(label));

		label_length = count > 0 ? (size_t)count : 0;
		return count < 0 ? (int)count : 0;
	}
	return -ENOENT;
}

static int light_commit(void)
{
	commits++;
	return 0;
}

static int light_export(int (*export_func)(const char *name, const void *val, size_t val_len))
{
	const int rc = export_func("light/level", &level, sizeof(level));

	return rc != 0 ? rc : export_func("light/label", label, label_length);
}

SETTINGS_STATIC_HANDLER_DEFINE(light, "light", NULL, light_set, light_commit, light_export);

static int inner_sets;

static int inner_set(const char *key, size_t len, settings_read_cb read_cb, void *cb_arg)
{
	inner_sets++;
	return 0;
}

static struct settings_handler inner = {.name = "light/inner", .h_set = inner_set};
static struct settings_handler twin = {.name = "light", .h_set = inner_set};

/* As a reset does. */
static void restart(void)
{
	level = 0;
	memset(label, 0, sizeof(label));
	label_length = 0;
	commits = 0;
	sets = 0;
	inner_sets = 0;
	settings_host_heal();
	settings_store_close();
	zassert_equal(settings_subsys_init(), 0);
}

static void *setup(void)
{
	zassert_equal(settings_register(&inner), 0);
	return NULL;
}

static void before(void *fixture)
{
	refuse = 0;
	save_while_loading = 0;
	restart();
	zassert_equal(settings_delete("light/level"), 0);
	zassert_equal(settings_delete("light/label"), 0);
	zassert_equal(settings_delete("light/inner/x"), 0);
	zassert_equal(settings_delete("other"), 0);
	restart();
}

ZTEST_SUITE(settings, NULL, setup, before, NULL, NULL);

ZTEST(settings, test_saved_value_comes_back)
{
	const uint32_t value = 250000;

	zassert_equal(settings_save_one("light/level", &value, sizeof(value)), 0);
	zassert_equal(settings_save_one("light/label", "mast", 4), 0);
	restart();
	zassert_equal(settings_load(), 0);
	zassert_equal(level, 250000);
	zassert_equal(label_length, 4);
	zassert_mem_equal(label, "mast", 4);
	zassert_equal(commits, 1);
}

ZTEST(settings, test_deleted_value_does_not)
{
	const uint32_t value = 250000;

	zassert_equal(settings_save_one("light/level", &value, sizeof(value)), 0);
	zassert_equal(settings_delete("light/level"), 0);
	restart();
	zassert_equal(settings_load(), 0);
	zassert_equal(sets, 0);
	zassert_equal(commits, 1);
}

ZTEST(settings, test_save_exports_all)
{
	level = 7;
	memcpy(label, "abc", 3);
	label_length = 3;
	zassert_equal(settings_save(), 0);
	restart();
	zassert_equal(settings_load(), 0);
	zassert_equal(level, 7);
	zassert_equal(label_length, 3);
}

ZTEST(settings, test_longest_subtree_gets_the_value)
{
	zassert_equal(settings_save_one("light/inner/x", "1", 1), 0);
	restart();
	zassert_equal(settings_load(), 0);
	zassert_equal(inner_sets, 1);
	zassert_equal(sets, 0);
}

ZTEST(settings, test_a_subtree_has_one_handler)
{
	zassert_equal(settings_register(&twin), -EEXIST);
	zassert_equal(settings_register(&inner), -EEXIST);
}

ZTEST(settings, test_load_subtree)
{
	zassert_equal(settings_save_one("light/label", "a", 1), 0);
	zassert_equal(settings_save_one("light/inner/x", "1", 1), 0);
	restart();
	zassert_equal(settings_load_subtree("light/inner"), 0);
	zassert_equal(inner_sets, 1);
	zassert_equal(sets, 0);
	zassert_equal(commits, 0);
	zassert_equal(settings_load_subtree("light"), 0);
	zassert_equal(sets, 1);
	zassert_equal(commits, 1);
	/* whole words only */
	zassert_equal(settings_load_subtree("ligh"), 0);
	zassert_equal(sets, 1);
}

ZTEST(settings, test_value_without_a_handler_is_kept)
{
	zassert_equal(settings_save_one("other", "1", 1), 0);
	restart();
	zassert_equal(settings_load(), 0);
	zassert_equal(settings_save_one("light/label", "a", 1), 0);
	restart();
	zassert_equal(settings_load(), 0);
	zassert_equal(sets, 1);
}

struct direct {
	int calls;
	size_t length;
	char key[16];
	char value[16];
};

static int direct_cb(const char *key, size_t len, settings_read_cb read_cb, void *cb_arg,
                     void *param)
{
	struct direct *direct = param;

	direct->calls++;
	direct->length = len;
	(void)strncpy(direct->key, key, sizeof(direct->key) - 1);
	/* a shorter read gets the beginning */
	zassert_equal(read_cb(cb_arg, direct->value, 3), 3);
	return 0;
}

ZTEST(settings, test_load_subtree_direct)
{
	struct direct direct = {0};

	zassert_equal(settings_save_one("light/label", "abcdef", 6), 0);
	zassert_equal(settings_load_subtree_direct("light", direct_cb, &direct), 0);
	zassert_equal(direct.calls, 1);
	zassert_equal(direct.length, 6);
	zassert_equal(strcmp(direct.key, "label"), 0);
	zassert_equal(strcmp(direct.value, "abc"), 0);
	zassert_equal(commits, 0);
	zassert_equal(sets, 0);
}

ZTEST(settings, test_refused_value_does_not_stop_the_others)
{
	zassert_equal(settings_save_one("light/label", "a", 1), 0);
	zassert_equal(settings_save_one("light/inner/x", "1", 1), 0);
	restart();
	refuse = -EINVAL;
	zassert_equal(settings_load(), 0);
	zassert_equal(inner_sets, 1);
	zassert_equal(sets, 1);
	zassert_equal(commits, 1);
}

ZTEST(settings, test_save_while_loading_is_refused)
{
	zassert_equal(settings_save_one("light/label", "a", 1), 0);
	restart();
	save_while_loading = 1;
	zassert_equal(settings_load(), 0);
	zassert_equal(save_while_loading, -EBUSY);
}

ZTEST(settings, test_bad_arguments)
{
	char name[SETTINGS_RECORD_NAME_MAX + 2];
	static const char value[SETTINGS_RECORD_VALUE_MAX + 1];

	memset(name, 'n', sizeof(name) - 1);
	name[sizeof(name) - 1] = '\0';
	zassert_equal(settings_save_one(NULL, "1", 1), -EINVAL);
	zassert_equal(settings_save_one("light/label", NULL, 1), -EINVAL);
	zassert_equal(settings_save_one("", "1", 1), -EINVAL);
	zassert_equal(settings_save_one(name, "1", 1), -EINVAL);
	zassert_equal(settings_save_one("light/label", value, sizeof(value)), -EINVAL);
	zassert_equal(settings_save_one("light/label", value, sizeof(value) - 1), 0);
}

ZTEST(settings, test_before_init_nothing_is_saved)
{
	settings_store_close();
	zassert_equal(settings_save_one("light/label", "a", 1), -ENODEV);
	zassert_equal(settings_load(), -ENODEV);
}

ZTEST(settings, test_torn_write_leaves_the_old_value)
{
	struct settings_store_status status;

	/* A record of this value is 12 + 11 + 3 bytes. */
	for (uint64_t cut = 0; cut < 26; cut++) {
		before(NULL);
		zassert_equal(settings_save_one("light/label", "old", 3), 0);
		settings_host_tear(cut, 1);
		zassert_equal(settings_save_one("light/label", "new", 3), -EIO);
		/* Power is off: */
		zassert_equal(settings_save_one("light/label", "two", 3), -EIO);
		settings_store_status(&status);
		zassert_equal(status.stats.errors, 2);
		restart();
		zassert_equal(settings_load(), 0);
		zassert_mem_equal(label, "old", 3, "cut %d", (int)cut);
	}
	before(NULL);
	zassert_equal(settings_save_one("light/label", "old", 3), 0);
	settings_host_tear(32, 1);
	zassert_equal(settings_save_one("light/label", "new", 3), 0);
	restart();
	zassert_equal(settings_load(), 0);
	zassert_mem_equal(label, "new", 3);
}

ZTEST(settings, test_status_without_a_file)
{
	struct settings_store_status status;

	settings_store_status(&status);
	zassert_is_null(status.path);
}

/* Examples from <zephyr/settings/settings.h> of Zephyr 3.4. */
ZTEST(settings, test_name_steq)
{
	const char *next;

	zassert_equal(settings_name_steq("bt/btmesh/iv", "bt", &next), 1);
	zassert_equal(strcmp(next, "btmesh/iv"), 0);
	zassert_equal(settings_name_steq("bt/btmesh/iv", "bt/btmesh/iv", &next), 1);
	zassert_is_null(next);
	zassert_equal(settings_name_steq("bt/btmesh/iv", "bt/", &next), 0);
	zassert_is_null(next);
	zassert_equal(settings_name_steq("bt/btmesh/iv", "bta", &next), 0);
	zassert_equal(settings_name_steq("bt", "bt/btmesh", &next), 0);
	zassert_equal(settings_name_steq("bt=1", "bt", &next), 1);
	zassert_is_null(next);
	zassert_equal(settings_name_steq(NULL, "bt", &next), 0);
}

ZTEST(settings, test_name_next)
{
	const char *next;

	zassert_equal(settings_name_next("bt/btmesh/iv", &next), 2);
	zassert_equal(strcmp(next, "btmesh/iv"), 0);
	zassert_equal(settings_name_next("btmesh", &next), 6);
	zassert_is_null(next);
	zassert_equal(settings_name_next("bt=1/2", &next), 2);
	zassert_is_null(next);
	zassert_equal(settings_name_next(NULL, &next), 0);
}
