/* SPDX-License-Identifier: Apache-2.0 */
/* What the host says while the light runs goes through the device's log. */
#include <zephyr/init.h>
#include <zephyr/logging/log.h>

#include "host/say.h"

LOG_MODULE_REGISTER(host);

static void to_log(const char *text)
{
	LOG_WRN("%s", text);
}

static int host_log_init(void)
{
	host_say_through(to_log);
	return 0;
}

SYS_INIT(host_log_init, APPLICATION, 99);
