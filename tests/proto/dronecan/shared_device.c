/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The DroneCAN endpoint over a real device, as a shared library for test_peer.py: frames in,
 * frames out, time by hand. Bytes from the tunnel come back with each bit inverted.
 */
#include "core/assert.h"
#include "proto/dronecan/endpoint.h"

#include <stdlib.h>
#include <string.h>

static struct dronecan_endpoint endpoint;
static struct dronecan_endpoint_config config = {
	.node =
		{
			.unique_id = {0xA0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
			.name = "org.pharos.light",
			.software_major = 1,
			.software_minor = 2,
			.hardware_major = 3,
			.hardware_minor = 4,
		},
	.lights = {.light_id = 254,
                   .hardpoint_id = 0,
                   .brightness_actuator_id = 9,
                   .pan_actuator_id = 10,
                   .tilt_actuator_id = 11},
};
static struct pharos_device device;
static int32_t actions[8]; /* how often each node action was asked for */
static int32_t params_changed;

_Noreturn void pharos_assert_failed(const char *file, int line)
{
	(void)file;
	(void)line;
	abort();
}

void device_start(uint8_t node_id, bool fd, uint32_t seed)
{
	config.node_id = node_id;
	config.fd = fd;
	config.seed = seed;
	memset(actions, 0, sizeof(actions));
	params_changed = 0;
	params_init(&device.params);
	pharos_device_init(&device, 0, &(struct device_config){.gimbal = false});
	dronecan_endpoint_init(&endpoint, 0, &config, &device);
}

static void perform(int64_t now_us, const struct dronecan_outbox *out)
{
	uint8_t bytes[DRONECAN_TUNNEL_CHUNK];
	struct device_effects effects;

	if (pharos_device_take(&device, &effects) && !param_set_is_empty(&effects.params)) {
		params_changed++;
	}
	for (uint8_t i = 0; i < out->node.count; i++) {
		actions[out->node.actions[i].kind]++;
	}
	if (out->tunnel_received && out->tunnel.size > 0) {
		for (size_t i = 0; i < out->tunnel.size; i++) {
			bytes[i] = (uint8_t)~out->tunnel.data[i];
		}
		dronecan_tunnel_write(&endpoint.tunnel, now_us, out->tunnel.channel, bytes,
		                      out->tunnel.size);
	}
}

void device_receive(int64_t now_us, uint32_t id, bool fd, const uint8_t *data, uint8_t size)
{
	struct dronecan_frame frame = {.id = id, .fd = fd, .size = size};
	struct dronecan_outbox out;

	memcpy(frame.data, data, size);
	dronecan_endpoint_receive(&endpoint, now_us, &frame, &out);
	perform(now_us, &out);
}

void device_step(int64_t now_us)
{
	struct dronecan_outbox out;

	dronecan_endpoint_report(&endpoint, now_us);
	dronecan_endpoint_step(&endpoint, now_us, &out);
	perform(now_us, &out);
}

bool device_next(int64_t now_us, struct dronecan_frame *frame)
{
	const bool some = dronecan_endpoint_next_frame(&endpoint, now_us, frame);

	dronecan_endpoint_frame_sent(&endpoint);
	return some;
}

int32_t device_action_count(uint32_t kind)
{
	return actions[kind];
}

int32_t device_params_changed(void)
{
	return params_changed;
}

int32_t device_param(const char *name)
{
	int32_t value = 0;

	params_get(&device.params, params_find(name, strlen(name)), &value);
	return value;
}

int32_t device_brightness_ppm(void)
{
	const struct illuminator_settings *const lamp = &device.lamps[0].illuminator.settings;

	return lamp->enable ? (int32_t)lamp->brightness_ppm : 0;
}

uint64_t device_rx_errors(void)
{
	return dronecan_transport_rx_errors(&endpoint.transport);
}
