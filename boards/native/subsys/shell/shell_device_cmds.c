/* SPDX-License-Identifier: Apache-2.0 */
#include <zephyr/device.h>
#include <zephyr/shell/shell.h>

static int cmd_list(const struct shell *sh, size_t argc, char **argv)
{
	STRUCT_SECTION_FOREACH(device, dev) {
		shell_print(sh, "%-20s %s", dev->name,
		            device_is_ready(dev) ? "ready" : "not ready");
	}
	return 0;
}

SHELL_STATIC_SUBCMD_SET_CREATE(device_commands,
	SHELL_CMD_ARG(list, NULL, "Devices, and whether they are ready", cmd_list, 1, 0),
	SHELL_SUBCMD_SET_END
);
SHELL_CMD_REGISTER(device, &device_commands, "Devices", NULL);
