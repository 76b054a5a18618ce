/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command for what is forwarded between MAVLink links: route.
 */
#include <errno.h>

#include <zephyr/shell/shell.h>

#include "core/decimal.h"
#include "threads/clock.h"
#include "threads/links.h"
#include "threads/mavlink_node.h"
#include "threads/shell/call.h"

#define MS_DECIMALS 3

/* Too large for the shell's stack; the shell's thread only. */
static struct mavlink_router router;

static int copy_router(struct pharos_device *device, void *argument)
{
	router = mavlink_node_endpoint()->router;
	return 0;
}

static int cmd_route(const struct shell *sh, size_t argc, char **argv)
{
	if (!shell_call(sh, copy_router, NULL, NULL)) {
		return -EAGAIN;
	}
	const int64_t now_us = clock_now_us();
	const struct mavlink_router_stats *const stats = &router.stats;

	shell_print(sh, "%-16s%s", "routing", router.on ? "on" : "off (see: param get MAV_ROUTE)");
	shell_print(sh, "%-16s%u, %u of them of unknown messages", "forwarded", stats->forwarded,
	            stats->opaque);
	shell_print(sh, "%-16starget not heard %u, gone in a circle %u, no room %u, too many %u",
	            "not forwarded", stats->unreachable, stats->circled, stats->no_room,
	            stats->flooded);
	for (uint8_t i = 0; i < router.count; i++) {
		const struct mavlink_route *const route = &router.routes[i];
		char text[DECIMAL_TEXT_MAX];

		(void)decimal_print(text, (now_us - route->heard_us) / US_PER_MS, MS_DECIMALS);
		shell_print(sh, "%3u/%-11u%s, %s s ago", route->system_id, route->component_id,
		            links_name(route->link), text);
	}
	return 0;
}

SHELL_CMD_ARG_REGISTER(route, NULL, "Who is on which MAVLink link, and what was forwarded",
                       cmd_route, 1, 0);
