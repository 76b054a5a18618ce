/* SPDX-License-Identifier: Apache-2.0 */
/* The whole endpoint as a device under test, and a tool at node 10 that talks to it. */
#ifndef TESTS_PROTO_DRONECAN_DEVICE_H
#define TESTS_PROTO_DRONECAN_DEVICE_H

#include "bus.h"

#include "proto/dronecan/endpoint.h"

#define NODE   68
#define TOOL   10
#define SECOND ((int64_t)US_PER_S)
#define MS     ((int64_t)US_PER_MS)

static const struct dronecan_endpoint_config device_config = {
	.node =
		{
			.unique_id = {0x11, 0x12, 0x13, 0x14, 0x15, 0x16, 0x21, 0x22, 0x23, 0x24,
                                      0x25, 0x26, 0x31, 0x32, 0x33, 0x34},
			.name = "org.pharos.light",
			.software_major = 1,
			.software_minor = 2,
			.hardware_major = 3,
			.hardware_minor = 4,
			.vcs_commit = 0xDEADBEEF,
		},
	.lights =
		{
			.light_id = 254,
			.hardpoint_id = 0,
			.brightness_actuator_id = 9,
			.pan_actuator_id = 10,
			.tilt_actuator_id = 11,
		},
	.node_id = NODE,
	.seed = 12345,
};

static struct dronecan_endpoint device;
static struct pharos_device core; /* what it is an endpoint of */
static struct device_effects effects;
static struct dronecan_outbox device_out;
static struct dronecan_transport tool;
static struct bus device_bus;

/* What the tool listens to. */
static const struct dronecan_subscription tool_subscriptions[] = {
	{.type = &dronecan_node_status_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_dynamic_node_id_allocation_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_tunnel_targetted_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_hardpoint_status_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_device_temperature_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_debug_log_message_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_param_get_set_type, .kind = DRONECAN_RESPONSE},
	{.type = &dronecan_param_execute_opcode_type, .kind = DRONECAN_RESPONSE},
	{.type = &dronecan_restart_node_type, .kind = DRONECAN_RESPONSE},
	{.type = &dronecan_get_transport_stats_type, .kind = DRONECAN_RESPONSE},
};

/* node_id 0: the device asks the allocator. */
static inline void device_start(uint8_t node_id, bool fd)
{
	static struct dronecan_endpoint_config config;

	config = device_config;
	config.node_id = node_id;
	config.fd = fd;
	params_init(&core.params);
	core.params.values[PARAM_GMB_ENABLE] = 1;
	pharos_device_init(&core, 0, &(struct device_config){.gimbal = true});
	params_init(&core.params);
	dronecan_endpoint_init(&device, 0, &config, &core);
	dronecan_transport_init(&tool, tool_subscriptions, ARRAY_SIZE(tool_subscriptions), TOOL, fd,
	                        1);
}

/* The device's frames from now on. */
static inline void device_frames(int64_t now_us)
{
	device_bus.count = 0;
	while (device_bus.count < BUS_FRAMES_MAX &&
	       dronecan_endpoint_next_frame(&device, now_us,
	                                    &device_bus.frames[device_bus.count])) {
		device_bus.count++;
		dronecan_endpoint_frame_sent(&device);
	}
}

static inline void device_step(int64_t now_us)
{
	dronecan_endpoint_step(&device, now_us, &device_out);
	device_frames(now_us);
}

/* What the core has been asked for since the last call. */
static inline void device_effects(void)
{
	memset(&effects, 0, sizeof(effects));
	(void)pharos_device_take(&core, &effects);
}

/* The tool sends; the outbox is that of the last frame. */
static inline void tool_sends(int64_t now_us, const struct dronecan_type *type,
                              enum dronecan_kind kind, const uint8_t *data, size_t size)
{
	struct bus bus;

	bus_send(&bus, &tool, now_us, type, kind, kind == DRONECAN_MESSAGE ? 0 : NODE, data, size);
	for (size_t i = 0; i < bus.count; i++) {
		dronecan_endpoint_receive(&device, now_us, &bus.frames[i], &device_out);
	}
	device_frames(now_us);
}

/* Whether the device's frames hold a transfer of this type; *out is the last such. */
static inline bool tool_hears(int64_t now_us, const struct dronecan_type *type,
                              struct dronecan_transfer *out)
{
	struct dronecan_transfer transfer;
	static uint8_t data[DRONECAN_RX_PAYLOAD_MAX];
	bool heard = false;

	for (size_t i = 0; i < device_bus.count; i++) {
		if (dronecan_transport_receive(&tool, now_us, &device_bus.frames[i], &transfer) &&
		    transfer.type == type) {
			heard = true;
			*out = transfer;
			memcpy(data, transfer.data, transfer.size);
			out->data = data;
		}
	}
	return heard;
}

#endif
