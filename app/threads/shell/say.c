/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/shell/say.h"

#include <errno.h>

#include "core/decimal.h"

const struct device_who shell_who = {.way = SECURITY_WAY_SHELL};

void say_fixed(const struct shell *sh, const char *label, int64_t value, unsigned int decimals,
               const char *unit)
{
	char text[DECIMAL_TEXT_MAX];

	(void)decimal_print(text, value, decimals);
	shell_print(sh, "%-14s%s %s", label, text, unit);
}

int say_result(const struct shell *sh, enum device_result result, const char *status)
{
	if (result == DEVICE_ACCEPTED) {
		shell_print(sh, "ok");
		return 0;
	}
	if (result == DEVICE_EXCLUDED) {
		shell_error(sh, "the shell may not command (see: param get LGT_SRC_EXCL)");
		return -EACCES;
	}
	shell_error(sh, "not now: another source is in command (see: %s)", status);
	return -EBUSY;
}
