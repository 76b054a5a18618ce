/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command: mavlink.
 */
#include <errno.h>

#include <zephyr/shell/shell.h>

#include "threads/links.h"
#include "threads/mavlink_node.h"
#include "threads/shell/call.h"

/* What the shell's thread prints, copied in the command thread. */
struct mavlink_view {
	uint8_t system_id;
	uint8_t component_count;
	uint8_t components[MAVLINK_COMPONENTS_MAX];
	uint8_t links;
	struct mavlink_vehicle vehicle;
	struct mavlink_link link[MAVLINK_LINKS_MAX];
};

static int copy_endpoint(struct pharos_device *device, void *argument)
{
	const struct mavlink_endpoint *const endpoint = mavlink_node_endpoint();
	struct mavlink_view *const view = argument;

	view->system_id = endpoint->config.system_id;
	view->component_count = endpoint->component_count;
	view->links = endpoint->config.links;
	view->vehicle = endpoint->vehicle;
	for (uint8_t i = 0; i < endpoint->component_count; i++) {
		view->components[i] = endpoint->components[i].id;
	}
	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		view->link[link] = endpoint->links[link];
	}
	return 0;
}

static int cmd_mavlink(const struct shell *sh, size_t argc, char **argv)
{
	struct mavlink_view view;

	if (!shell_call(sh, copy_endpoint, &view, NULL)) {
		return -EAGAIN;
	}
	shell_print(sh, "%-14s%u, %s", "system id", view.system_id,
	            mavlink_vehicle_state_name(view.vehicle.state));
	for (uint8_t i = 0; i < view.component_count; i++) {
		shell_print(sh, "%-14s%u", "component id", view.components[i]);
	}
	for (uint8_t link = 0; link < LINKS_MAX; link++) {
		const struct mavlink_link *const its = &view.link[link];

		if ((view.links & 1u << link) != 0) {
			shell_print(sh, "%-14sMAVLink %u, rx %u frames, %u commands, tx %u frames",
			            links_name(link), its->version == 1 ? 1 : 2,
			            its->stats.rx_frames, its->stats.rx_commands,
			            its->stats.tx_frames);
		}
	}
	return 0;
}

SHELL_CMD_ARG_REGISTER(mavlink, NULL, "System id, components and links", cmd_mavlink, 1, 0);
