/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command for firmware updates: firmware.
 */
#include <zephyr/shell/shell.h>

#include "threads/firmware.h"

static int cmd_firmware(const struct shell *sh, size_t argc, char **argv)
{
	const struct firmware_status now = firmware_status_get();

	shell_print(sh, "%-12s%s", "running", now.confirmed ? "confirmed" : "on test");
	if (now.failure != NULL) {
		shell_print(sh, "%-12sfailed: %s", "update", now.failure);
	} else {
		shell_print(sh, "%-12s%s", "update", firmware_phase_name(now.phase));
	}
	if (now.bytes > 0) {
		shell_print(sh, "%-12s%u bytes, version %u.%u.%u+%u", "image", now.bytes,
		            now.version.major, now.version.minor, now.version.revision,
		            now.version.build);
	}
	return 0;
}

SHELL_CMD_ARG_REGISTER(firmware, NULL, "The firmware's image and its update", cmd_firmware, 1, 0);
