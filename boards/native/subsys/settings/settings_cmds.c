/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>

#include <zephyr/settings/settings.h>
#include <zephyr/shell/shell.h>

#include "settings_store.h"

static int list_one(const char *key, size_t len, settings_read_cb read_cb, void *cb_arg,
                    void *param)
{
	shell_print((const struct shell *)param, "%s  %zu bytes", key == NULL ? "" : key, len);
	return 0;
}

static int cmd_list(const struct shell *sh, size_t argc, char **argv)
{
	return settings_load_subtree_direct(argc > 1 ? argv[1] : NULL, list_one, (void *)sh);
}

static int dump_one(const char *key, size_t len, settings_read_cb read_cb, void *cb_arg,
                    void *param)
{
	uint8_t value[SETTINGS_MAX_VAL_LEN];
	const ssize_t count = read_cb(cb_arg, value, sizeof(value));

	/* Only the value of this very name: below it there is a rest. */
	if (key == NULL && count > 0) {
		shell_hexdump((const struct shell *)param, value, (size_t)count);
		return 1;
	}
	return 0;
}

static int cmd_read(const struct shell *sh, size_t argc, char **argv)
{
	return settings_load_subtree_direct(argv[1], dump_one, (void *)sh);
}

static int cmd_delete(const struct shell *sh, size_t argc, char **argv)
{
	const int rc = settings_delete(argv[1]);

	if (rc != 0) {
		shell_error(sh, "%s: not deleted: error %d", argv[1], rc);
	}
	return rc;
}

static int cmd_status(const struct shell *sh, size_t argc, char **argv)
{
	struct settings_store_status status;

	settings_store_status(&status);
	if (status.path == NULL) {
		shell_print(sh, "in memory: lost when the process ends");
	} else {
		shell_print(sh, "file %s", status.path);
	}
	shell_print(sh, "%zu of %d bytes, %zu of use", status.used, CONFIG_SETTINGS_STORAGE_SIZE,
	            status.live);
	shell_print(sh, "writes %u, compactions %u, errors %u, broken records %u",
	            (unsigned int)status.stats.writes, (unsigned int)status.stats.compactions,
	            (unsigned int)status.stats.errors, (unsigned int)status.stats.broken);
	return 0;
}

SHELL_STATIC_SUBCMD_SET_CREATE(settings_commands,
	SHELL_CMD_ARG(delete, NULL, "<name>: delete a value", cmd_delete, 2, 0),
	SHELL_CMD_ARG(list, NULL, "[subtree]: names that are stored", cmd_list, 1, 1),
	SHELL_CMD_ARG(read, NULL, "<name>: a value, in hexadecimal", cmd_read, 2, 0),
	SHELL_CMD_ARG(status, NULL, "Where settings are kept, and counters", cmd_status, 1, 0),
	SHELL_SUBCMD_SET_END
);
SHELL_CMD_REGISTER(settings, &settings_commands, "Stored settings", NULL);
