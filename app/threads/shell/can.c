/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Shell command for the CAN bus: can.
 */
#include <errno.h>

#include <zephyr/shell/shell.h>
#include <zephyr/sys/printk.h>

#include "threads/can_link.h"
#include "threads/can_node.h"
#include "threads/devices.h"
#include "threads/shell/call.h"
#include "threads/shell/can.h"

static const char *state_name(enum can_state state)
{
	switch (state) {
	case CAN_STATE_ERROR_ACTIVE:
		return "error-active";
	case CAN_STATE_ERROR_WARNING:
		return "error-warning";
	case CAN_STATE_ERROR_PASSIVE:
		return "error-passive";
	case CAN_STATE_BUS_OFF:
		return "bus-off";
	case CAN_STATE_STOPPED:
		return "stopped";
	}
	return "";
}

void shell_can_print(const struct shell *sh)
{
	const struct can_link_status link = can_link_status_get();

	if (devices.can_link == NULL) {
		return;
	}
	shell_print(sh, "can0    rx %u frames; overruns %u, bus errors %u", link.stats.rx_frames,
	            link.stats.rx_overruns, link.stats.bus_errors);
	shell_print(sh, "        tx %u frames; failed %u, waits %u", link.stats.tx_frames,
	            link.stats.tx_failed, link.stats.tx_waits);
	shell_print(sh, "        %s, error counters tx %u rx %u, bus-offs %u",
	            state_name(link.state), link.errors.tx_err_cnt, link.errors.rx_err_cnt,
	            link.stats.bus_offs);
}

static int copy_status(struct pharos_device *device, void *argument)
{
	can_node_status_get(argument);
	return 0;
}

/* 64-bit counts as the shell can print them. */
static unsigned int count(uint64_t value)
{
	return (unsigned int)value;
}

/* Two nodes with one id: people must give one of them another. */
static void print_clash(const struct shell *sh, const struct can_node_status *now)
{
	char unique_id[2 * DRONECAN_UNIQUE_ID_SIZE + 1] = "not known";

	if (!now->clash) {
		return;
	}
	for (size_t i = 0; now->is_other_named && i < DRONECAN_UNIQUE_ID_SIZE; i++) {
		snprintk(&unique_id[2 * i], 3, "%02x", now->other[i]);
	}
	shell_warn(sh, "%-14sanother node has it too; its unique id: %s", "", unique_id);
}

static int cmd_can(const struct shell *sh, size_t argc, char **argv)
{
	struct can_node_status now;

	if (devices.can_link == NULL) {
		shell_error(sh, "this board has no CAN");
		return -ENODEV;
	}
	if (!shell_call(sh, copy_status, &now, NULL)) {
		return -EAGAIN;
	}
	if (now.node_id == 0) {
		shell_print(sh, "%-14snone yet: asking the allocator", "node id");
	} else {
		shell_print(sh, "%-14s%u", "node id", now.node_id);
	}
	print_clash(sh, &now);
	shell_can_print(sh);
	shell_print(sh, "%-14srx %u, tx %u", "transfers", count(now.transport.transfers_rx),
	            count(now.transport.transfers_tx));
	shell_print(sh, "%-14smalformed %u, own id %u, lost %u, repeated %u, incomplete %u, CRC %u",
	            "refused", now.transport.rx_malformed, now.transport.rx_own_id,
	            now.transport.rx_without_start + now.transport.rx_wrong_toggle +
	                    now.transport.rx_wrong_id,
	            now.transport.rx_repeated, now.transport.rx_incomplete,
	            now.transport.rx_wrong_crc);
	shell_print(sh, "%-14srx %u, tx %u, late %u", "no room",
	            now.transport.rx_no_room + now.transport.rx_evicted,
	            now.transport.tx_no_room + now.transport.tx_evicted, now.transport.tx_expired);
	shell_print(sh, "%-14s%u opened, %u closed, %u refused; not MAVLink %u", "tunnels",
	            now.tunnel.opened, now.tunnel.closed, now.tunnel.refused, now.tunnel.foreign);
	shell_print(sh, "%-14s%u; applied %u, refused %u, repeated in vain %u, pan and tilt %u",
	            "lamp commands", now.lights.commands, now.lights.applied, now.lights.rejected,
	            now.lights.kept, now.lights.no_gimbal);
	shell_print(sh, "%-14s%u", "requests", now.requests);
	return 0;
}

SHELL_CMD_ARG_REGISTER(can, NULL, "The CAN bus and the DroneCAN node", cmd_can, 1, 0);
