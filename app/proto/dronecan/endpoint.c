/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/endpoint.h"

#include <string.h>

/* Everything this device listens to. */
static const struct dronecan_subscription subscriptions[] = {
	{.type = &dronecan_get_node_info_type, .kind = DRONECAN_REQUEST, .from = DRONECAN_FROM_ALL},
	{.type = &dronecan_get_node_info_type,
         .kind = DRONECAN_RESPONSE,
         .from = DRONECAN_FROM_OWN_ID},
	{.type = &dronecan_node_status_type,
         .kind = DRONECAN_MESSAGE,
         .from = DRONECAN_FROM_OWN_ID},
	{.type = &dronecan_get_transport_stats_type, .kind = DRONECAN_REQUEST},
	{.type = &dronecan_restart_node_type, .kind = DRONECAN_REQUEST},
	{.type = &dronecan_param_get_set_type, .kind = DRONECAN_REQUEST},
	{.type = &dronecan_param_execute_opcode_type, .kind = DRONECAN_REQUEST},
	{.type = &dronecan_file_begin_firmware_update_type, .kind = DRONECAN_REQUEST},
	{.type = &dronecan_file_read_type, .kind = DRONECAN_RESPONSE},
	{.type = &dronecan_dynamic_node_id_allocation_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_indication_lights_command_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_hardpoint_command_type, .kind = DRONECAN_MESSAGE},
	{.type = &dronecan_actuator_array_command_type, .kind = DRONECAN_MESSAGE},
	{
		.type = &dronecan_tunnel_targetted_type,
		.kind = DRONECAN_MESSAGE,
		.is_ours = dronecan_tunnel_is_ours,
	},
};

#define SUBSCRIPTIONS_COUNT (sizeof(subscriptions) / sizeof(subscriptions[0]))
_Static_assert(SUBSCRIPTIONS_COUNT <= DRONECAN_SUBSCRIPTIONS_MAX, "every subscription fits");

void dronecan_endpoint_init(struct dronecan_endpoint *self, int64_t now_us,
                            const struct dronecan_endpoint_config *config,
                            struct pharos_device *device)
{
	dronecan_transport_init(&self->transport, subscriptions, SUBSCRIPTIONS_COUNT,
	                        config->node_id, config->fd, config->seed);
	dronecan_node_init(&self->node, now_us, &config->node, &self->transport, device);
	dronecan_tunnel_init(&self->tunnel);
	dronecan_lights_init(&self->lights, now_us, &config->lights, device);
	dronecan_firmware_init(&self->firmware, &self->node, config->no_update);
}

static void clear(struct dronecan_outbox *out)
{
	out->node.count = 0;
	out->firmware.event = DRONECAN_FIRMWARE_NOTHING;
	out->tunnel_received = false;
}

void dronecan_endpoint_receive(struct dronecan_endpoint *self, int64_t now_us,
                               const struct dronecan_frame *frame, struct dronecan_outbox *out)
{
	struct dronecan_transfer transfer;

	clear(out);
	if (!dronecan_transport_receive(&self->transport, now_us, frame, &transfer)) {
		return;
	}
	if (transfer.type == &dronecan_tunnel_targetted_type) {
		out->tunnel_received = dronecan_tunnel_receive(&self->tunnel, now_us, &transfer,
		                                               &self->scratch, &out->tunnel);
		return;
	}
	dronecan_node_receive(&self->node, now_us, &transfer, &out->node);
	dronecan_lights_receive(&self->lights, now_us, &transfer);
	dronecan_firmware_receive(&self->firmware, now_us, &transfer, &out->firmware);
}

static uint8_t health(const struct dronecan_endpoint *self)
{
	const struct thermal_report *thermal = &self->lights.device->lamps[0].illuminator.thermal;

	if (thermal->limit_ppm == 0 || thermal->dark) {
		return DRONECAN_NODE_STATUS_HEALTH_ERROR;
	}
	return self->node.clash.on ? DRONECAN_NODE_STATUS_HEALTH_WARNING
	                           : DRONECAN_NODE_STATUS_HEALTH_OK;
}

void dronecan_endpoint_report(struct dronecan_endpoint *self, int64_t now_us)
{
	const struct illuminator *illuminator = &self->lights.device->lamps[0].illuminator;
	const struct thermal_report *thermal = &illuminator->thermal;
	const struct dronecan_node_condition condition = {
		.health = health(self),
		.mode = self->firmware.state == DRONECAN_FIRMWARE_IDLE
	                        ? DRONECAN_NODE_STATUS_MODE_OPERATIONAL
	                        : DRONECAN_NODE_STATUS_MODE_SOFTWARE_UPDATE,
		.vendor_code = (uint16_t)illuminator_error_flags(illuminator),
	};
	const struct dronecan_lights_report report = {
		.on = illuminator->settings.enable,
		.temp_valid = thermal->temp_valid,
		.overheating = thermal->state != THERMAL_STATE_NORMAL,
		.temp_mdegc = thermal->temp_mdegc,
	};

	dronecan_node_set_condition(&self->node, now_us, &condition);
	dronecan_lights_set_report(&self->lights, now_us, &report);
}

void dronecan_endpoint_step(struct dronecan_endpoint *self, int64_t now_us,
                            struct dronecan_outbox *out)
{
	clear(out);
	dronecan_node_step(&self->node, now_us, &out->node);
	dronecan_lights_step(&self->lights, now_us, &self->transport);
	dronecan_tunnel_step(&self->tunnel, now_us, &self->transport);
	dronecan_firmware_step(&self->firmware, now_us, &out->firmware);
}

int64_t dronecan_endpoint_deadline_us(const struct dronecan_endpoint *self)
{
	const int64_t all_us[] = {
		dronecan_node_deadline_us(&self->node),
		dronecan_tunnel_deadline_us(&self->tunnel),
		dronecan_lights_deadline_us(&self->lights),
		dronecan_firmware_deadline_us(&self->firmware),
	};
	int64_t first_us = TIME_NEVER_US;

	for (size_t i = 0; i < sizeof(all_us) / sizeof(all_us[0]); i++) {
		first_us = all_us[i] < first_us ? all_us[i] : first_us;
	}
	return first_us;
}

bool dronecan_endpoint_next_frame(struct dronecan_endpoint *self, int64_t now_us,
                                  struct dronecan_frame *frame)
{
	dronecan_tunnel_step(&self->tunnel, now_us, &self->transport);
	return dronecan_transport_next_frame(&self->transport, now_us, frame);
}

void dronecan_endpoint_frame_sent(struct dronecan_endpoint *self)
{
	dronecan_transport_frame_sent(&self->transport);
}
