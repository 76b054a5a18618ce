/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/can_node.h"

#include <string.h>

#include <zephyr/drivers/hwinfo.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/printk.h>
#include <zephyr/sys/reboot.h>

#include <pharos/drivers/light.h>

#include "threads/can_link.h"
#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/firmware.h"
#include "threads/identity.h"
#include "threads/storage.h"
#include "threads/tunnel_link.h"
#include "threads/vcs_commit.h"
#include "version.h"

LOG_MODULE_REGISTER(can_node);

#define LOG_GAP_US      (1 * US_PER_S)
/* The ids of DroneCAN's frames: message types, "not a service", destinations, anonymous types. */
#define TYPE_SHIFT      8
#define MESSAGE_MASK    0x00FFFF80u
#define SERVICE_MASK    0x00007F80u
#define SERVICE         0x00000080u
#define ANONYMOUS_MASK  0x000003FFu
#define ANONYMOUS_TYPES 3u

static struct pharos_device *device;
static bool active;
static struct dronecan_endpoint_config config;
static struct dronecan_endpoint endpoint;
static struct dronecan_outbox out;
static int64_t log_us;
static bool to_send;         /* there may be frames to send */
static bool update_complete; /* the block that is being stored is the last */

/* --- configuration ---------------------------------------------------------------------------- */

static struct can_link_filter messages(const struct dronecan_type *type)
{
	return (struct can_link_filter){.id = (uint32_t)type->id << TYPE_SHIFT,
	                                .mask = MESSAGE_MASK};
}

/* Only what concerns this light reaches it: a busy bus costs no more than that. */
static void listen(void)
{
	const struct dronecan_lights_config *const lights = &endpoint.lights.config;
	const uint32_t node_id = endpoint.transport.node_id;
	struct can_link_filter filters[CAN_LINK_FILTERS_MAX];
	size_t count = 0;

	if (node_id == 0) {
		const uint32_t type = dronecan_dynamic_node_id_allocation_type.id & ANONYMOUS_TYPES;

		filters[count++] = messages(&dronecan_dynamic_node_id_allocation_type);
		filters[count++] =
			(struct can_link_filter){.id = type << TYPE_SHIFT, .mask = ANONYMOUS_MASK};
	} else {
		filters[count++] = messages(&dronecan_tunnel_targetted_type);
		filters[count++] = (struct can_link_filter){
			.id = node_id << TYPE_SHIFT | SERVICE,
			.mask = SERVICE_MASK,
		};
		/* who else has our id */
		filters[count] = messages(&dronecan_node_status_type);
		filters[count].id |= node_id;
		filters[count++].mask |= DRONECAN_NODE_ID_MAX;
	}
	if (lights->light_id != DRONECAN_LIGHTS_ID_NONE) {
		filters[count++] = messages(&dronecan_indication_lights_command_type);
	}
	if (lights->hardpoint_id != DRONECAN_LIGHTS_ID_NONE) {
		filters[count++] = messages(&dronecan_hardpoint_command_type);
	}
	if (lights->brightness_actuator_id != DRONECAN_LIGHTS_ID_NONE ||
	    lights->pan_actuator_id != DRONECAN_LIGHTS_ID_NONE ||
	    lights->tilt_actuator_id != DRONECAN_LIGHTS_ID_NONE) {
		filters[count++] = messages(&dronecan_actuator_array_command_type);
	}
	can_link_listen(filters, count);
}

/* Servos are numbered from 1, so that 0 is none. */
static int16_t actuator_id(int32_t value)
{
	return value == 0 ? DRONECAN_LIGHTS_ID_NONE : (int16_t)value;
}

static struct dronecan_lights_config lights_config(const struct params *params)
{
	const int32_t *const values = params->values;

	_Static_assert(DRONECAN_LIGHTS_ID_NONE == -1, "as in the parameters");
	return (struct dronecan_lights_config){
		.light_id = (int16_t)values[PARAM_CAN_LIGHT_ID],
		.hardpoint_id = (int16_t)values[PARAM_CAN_HARDPT_ID],
		.brightness_actuator_id = actuator_id(values[PARAM_CAN_ACT_BRT]),
		.pan_actuator_id = actuator_id(values[PARAM_CAN_ACT_PAN]),
		.tilt_actuator_id = actuator_id(values[PARAM_CAN_ACT_TILT]),
	};
}

static void configure(void)
{
	const struct dronecan_lights_config lights = lights_config(&device->params);

	dronecan_lights_configure(&endpoint.lights, &lights);
	listen();
}

/* The chip's own id; what it lacks of 16 bytes is zero. */
static void read_unique_id(uint8_t id[DRONECAN_UNIQUE_ID_SIZE])
{
	static const uint8_t zeros[DRONECAN_UNIQUE_ID_SIZE];
	const ssize_t length = hwinfo_get_device_id(id, DRONECAN_UNIQUE_ID_SIZE);

	if (length <= 0 || memcmp(id, zeros, sizeof(zeros)) == 0) {
		LOG_WRN("the chip has no id: two such lights need fixed node ids");
		memset(id, UINT8_MAX, DRONECAN_UNIQUE_ID_SIZE);
	}
}

/* Differs from light to light, so that their random times do. */
static uint32_t seed_of(const uint8_t id[DRONECAN_UNIQUE_ID_SIZE])
{
	const uint32_t high = dronecan_crc(0xFFFF, id, DRONECAN_UNIQUE_ID_SIZE / 2);
	const uint32_t low = dronecan_crc((uint16_t)high, id, DRONECAN_UNIQUE_ID_SIZE);

	return high << 16 | low;
}

/* A node without an id may not speak: it says so once it has one. */
static void announce(void)
{
	char text[IDENTITY_BOOT_TEXT_MAX];

	identity_boot_text(text);
	(void)dronecan_node_log(&endpoint.node, clock_now_us(), DRONECAN_DEBUG_LOG_LEVEL_INFO,
	                        "light", text);
}

void can_node_init(struct pharos_device *its)
{
	const int32_t *const values = its->params.values;
	const int error =
		can_link_init((uint32_t)values[PARAM_CAN_BITRATE], values[PARAM_CAN_FD] != 0);

	active = false;
	if (error != 0) {
		return;
	}
	log_us = 0;
	to_send = false;
	device = its;
	config = (struct dronecan_endpoint_config){
		.node =
			{
				.name = CONFIG_PHAROS_CAN_NODE_NAME,
				.software_major = PHAROS_VERSION_MAJOR,
				.software_minor = PHAROS_VERSION_MINOR,
				.hardware_major = CONFIG_PHAROS_HARDWARE_MAJOR,
				.hardware_minor = CONFIG_PHAROS_HARDWARE_MINOR,
				.vcs_commit = PHAROS_VCS_COMMIT,
			},
		.lights = lights_config(&device->params),
		.node_id = (uint8_t)values[PARAM_CAN_NODE_ID],
		.fd = can_link_has_fd(),
		.no_update = firmware_unavailable(),
	};
	read_unique_id(config.node.unique_id);
	config.seed = seed_of(config.node.unique_id);
	dronecan_endpoint_init(&endpoint, clock_now_us(), &config, device);
	dronecan_endpoint_report(&endpoint, clock_now_us());
	tunnel_links_init(&endpoint.tunnel);
	active = true;
	listen();
	announce();
}

/* --- the node --------------------------------------------------------------------------------- */

static void save_all(void)
{
	const struct param_set all = params_settable();

	storage_save_params(&device->params, &all);
}

static void perform_node(void)
{
	for (uint8_t i = 0; i < out.node.count; i++) {
		const struct dronecan_node_action *const action = &out.node.actions[i];

		switch (action->kind) {
		case DRONECAN_NODE_RESTART:
			light_off_now(devices.light);
			sys_reboot(SYS_REBOOT_COLD);
			break;
		case DRONECAN_NODE_SAVE:
		case DRONECAN_NODE_ERASE: /* all are at their defaults now */
			save_all();
			break;
		case DRONECAN_NODE_ID_ALLOCATED:
			LOG_INF("node id %u allocated", action->node_id);
			listen();
			announce();
			break;
		}
	}
}

/* A LogMessage of level WARNING, at most one a second. */
static void log_warning(const char *text)
{
	const int64_t now_us = clock_now_us();

	if (now_us < log_us) {
		return;
	}
	log_us = now_us + LOG_GAP_US;
	to_send = true;
	(void)dronecan_node_log(&endpoint.node, now_us, DRONECAN_DEBUG_LOG_LEVEL_WARNING, "light",
	                        text);
}

void can_node_tell(const struct device_effects *effects)
{
	if (!active) {
		return;
	}
	if ((effects->statuses | effects->reports) != 0) {
		dronecan_endpoint_report(&endpoint, clock_now_us());
	}
	for (uint32_t kind = 0; effects->notices[0] >> kind != 0; kind++) {
		if ((effects->notices[0] & BIT(kind)) != 0) {
			log_warning(illuminator_notice_text((enum illuminator_notice_kind)kind));
		}
	}
	if (param_set_touches(&effects->params, PARAM_GROUP_DRONECAN)) {
		configure();
	}
}

/* Another node has our id, or has not any more. */
static void tell_clash(void)
{
	static bool told;
	const struct dronecan_clash *const clash = &endpoint.node.clash;
	char text[CAN_NODE_CLASH_TEXT_MAX];

	if (clash->on == told) {
		return;
	}
	told = clash->on;
	dronecan_endpoint_report(&endpoint, clock_now_us());
	if (clash->on) {
		can_node_clash_text(text);
		LOG_WRN("%s", text);
		log_warning(text);
	}
}

bool can_node_clash_text(char text[CAN_NODE_CLASH_TEXT_MAX])
{
	if (!endpoint.node.clash.on) {
		return false;
	}
	snprintk(text, CAN_NODE_CLASH_TEXT_MAX, "CAN node id %u is another node's too",
	         endpoint.transport.node_id);
	return true;
}

/* --- firmware update -------------------------------------------------------------------------- */

/* The image's next block, or the end. */
static void update_done(const char *failure)
{
	const int64_t now_us = clock_now_us();

	to_send = true;
	if (failure != NULL) {
		dronecan_firmware_stop(&endpoint.firmware);
		log_warning(failure);
	} else if (update_complete) {
		dronecan_firmware_stop(&endpoint.firmware);
		dronecan_node_restart(&endpoint.node, now_us);
	} else {
		dronecan_firmware_next(&endpoint.firmware, now_us);
	}
	dronecan_endpoint_report(&endpoint, now_us);
}

static void perform_update(void)
{
	switch (out.firmware.event) {
	case DRONECAN_FIRMWARE_NOTHING:
		break;
	case DRONECAN_FIRMWARE_BEGIN:
		update_complete = false;
		firmware_begin(update_done);
		break;
	case DRONECAN_FIRMWARE_BLOCK:
		update_complete = out.firmware.is_last;
		firmware_write(out.firmware.data, out.firmware.size, out.firmware.is_last);
		break;
	case DRONECAN_FIRMWARE_FAILED:
		firmware_abort(out.firmware.error == 0 ? "the file server is silent"
		                                       : "the file server reports an error");
		log_warning("update failed: file server");
		break;
	}
}

/* --- what the command thread calls ------------------------------------------------------------ */

static void perform(void)
{
	perform_node();
	tell_clash();
	perform_update();
	if (out.tunnel_received) {
		tunnel_links_put(&out.tunnel);
	}
	to_send = true;
}

void can_node_take(const struct dronecan_frame *frame)
{
	endpoint.firmware.is_taken = firmware_is_busy();
	dronecan_endpoint_receive(&endpoint, clock_now_us(), frame, &out);
	perform();
}

void can_node_flush(void)
{
	struct dronecan_frame frame;

	to_send = to_send || tunnel_links_written();
	while (to_send && dronecan_endpoint_next_frame(&endpoint, clock_now_us(), &frame)) {
		if (!can_link_send(&frame)) {
			return;
		}
		dronecan_endpoint_frame_sent(&endpoint);
	}
	to_send = false;
}

void can_node_step(void)
{
	if (can_node_deadline_us() <= clock_now_us()) {
		dronecan_node_set_bus_errors(&endpoint.node,
		                             can_link_status_get().stats.bus_errors);
		dronecan_endpoint_step(&endpoint, clock_now_us(), &out);
		perform();
	}
}

int64_t can_node_deadline_us(void)
{
	return active ? dronecan_endpoint_deadline_us(&endpoint) : TIME_NEVER_US;
}

void can_node_status_get(struct can_node_status *status)
{
	_Static_assert(sizeof(status->other) == sizeof(endpoint.node.clash.unique_id), "a copy");
	*status = (struct can_node_status){
		.node_id = endpoint.transport.node_id,
		.transport = endpoint.transport.stats,
		.tunnel = endpoint.tunnel.stats,
		.lights = endpoint.lights.stats,
		.requests = endpoint.node.stats.requests,
		.clash = endpoint.node.clash.on,
		.is_other_named = endpoint.node.clash.is_named,
	};
	memcpy(status->other, endpoint.node.clash.unique_id, sizeof(status->other));
}
