/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/can_node.h"

#include <errno.h>
#include <string.h>

#include <zephyr/drivers/hwinfo.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>
#include <zephyr/sys/reboot.h>

#include <pharos/drivers/light.h>

#include "threads/can_link.h"
#include "threads/clock.h"
#include "threads/devices.h"
#include "threads/firmware.h"
#include "threads/identity.h"
#include "threads/mavlink_node.h"
#include "threads/storage.h"
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

/* Bytes that wait in a tunnel, up to which others' frames go there. */
#define TUNNEL_FORWARD_MAX (DRONECAN_TUNNEL_BUFFER / 2)

_Static_assert(TUNNEL_FORWARD_MAX >= MAVLINK_FRAME_MAX, "a forwarded frame fits");
_Static_assert(TUNNEL_LINKS_MAX == DRONECAN_TUNNEL_CHANNELS, "a link for each channel");

struct tunnel {
	bool up; /* MAVLink knows that somebody is there */
	int64_t heard_us;
	struct mavlink_framer framer;
	struct link_stats stats;
};

static bool active;
static struct dronecan_endpoint_config config;
static struct dronecan_endpoint endpoint;
static struct dronecan_outbox out;
static struct tunnel tunnels[TUNNEL_LINKS_MAX];
static struct can_node_stats stats;
static int64_t log_us;
static bool to_send;         /* there may be frames to send */
static bool update_complete; /* the block that is being stored is the last */
static uint32_t tunnels_up;  /* how many; none: nothing to look after */

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

void can_node_configure(const struct params *params)
{
	const struct dronecan_lights_config lights = lights_config(params);

	if (active) {
		dronecan_lights_configure(&endpoint.lights, &lights);
		listen();
	}
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

void can_node_init(struct command *command)
{
	const int32_t *const values = command->params.values;
	const int error =
		can_link_init((uint32_t)values[PARAM_CAN_BITRATE], values[PARAM_CAN_FD] != 0);

	if (error != 0) {
		return;
	}
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
		.lights = lights_config(&command->params),
		.node_id = (uint8_t)values[PARAM_CAN_NODE_ID],
		.fd = can_link_has_fd(),
		.no_update = firmware_unavailable(),
	};
	read_unique_id(config.node.unique_id);
	config.seed = seed_of(config.node.unique_id);
	dronecan_endpoint_init(&endpoint, clock_now_us(), &config, &command->params);
	for (size_t i = 0; i < TUNNEL_LINKS_MAX; i++) {
		mavlink_framer_init(&tunnels[i].framer);
	}
	active = true;
	listen();
	announce();
}

/* --- commands for the lamp -------------------------------------------------------------------- */

/* A repetition takes the light from nobody, but says that its sender is there. */
static void command_lamp(struct command *command, const struct dronecan_lights_action *action)
{
	const enum arbiter_source commander = command->arbiter.commander;

	if (action->repeated && commander != ARBITER_SOURCE_DRONECAN &&
	    commander != ARBITER_SOURCE_FALLBACK && commander != ARBITER_SOURCE_NONE) {
		stats.unchanged++;
		arbiter_heard(&command->arbiter, clock_now_us(), ARBITER_SOURCE_DRONECAN);
		return;
	}
	if (command_apply_all(command, ARBITER_SOURCE_DRONECAN, action->events,
	                      action->events_count)) {
		stats.applied++;
	} else {
		stats.refused++;
		dronecan_lights_forget(&endpoint.lights);
	}
}

static void command_gimbal(struct command *command, enum gimbal_axis_id axis,
                           const struct dronecan_lights_action *action)
{
	const enum arbiter_source commander = gimbal_node_commander(command);
	struct gimbal_event event = {.kind = GIMBAL_EVENT_AIM};
	enum gimbal_result result;

	if (!gimbal_node_is_active(command)) {
		stats.no_gimbal++;
		return;
	}
	if (action->repeated && commander != ARBITER_SOURCE_DRONECAN &&
	    commander != ARBITER_SOURCE_NONE) {
		stats.unchanged++;
		return;
	}
	event.aim[axis] = (struct gimbal_aim){
		.kind = GIMBAL_ANGLE,
		.value = gimbal_node_share_mdeg(command, axis, action->position_ppm),
	};
	if (command_point(command, ARBITER_SOURCE_DRONECAN, &event, &result) == ARBITER_GRANTED) {
		stats.applied++;
	} else {
		stats.refused++;
		dronecan_lights_forget(&endpoint.lights);
	}
}

static void perform_lights(struct command *command)
{
	for (uint8_t i = 0; i < out.lights.count; i++) {
		const struct dronecan_lights_action *const action = &out.lights.actions[i];

		switch (action->kind) {
		case DRONECAN_LIGHTS_EVENTS:
			command_lamp(command, action);
			break;
		case DRONECAN_LIGHTS_PAN:
			command_gimbal(command, GIMBAL_PAN, action);
			break;
		case DRONECAN_LIGHTS_TILT:
			command_gimbal(command, GIMBAL_TILT, action);
			break;
		}
	}
}

/* --- the node --------------------------------------------------------------------------------- */

static void save_all(const struct params *params)
{
	const struct param_set all = params_settable();

	storage_save_params(params, &all);
}

static void perform_node(struct command *command)
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
			save_all(&command->params);
			break;
		case DRONECAN_NODE_PARAMS_CHANGED:
			command_params_changed(command, &action->changed);
			break;
		case DRONECAN_NODE_ID_ALLOCATED:
			LOG_INF("node id %u allocated", action->node_id);
			listen();
			announce();
			break;
		}
	}
}

void can_node_report(const struct illuminator *illuminator)
{
	if (active) {
		dronecan_endpoint_report(&endpoint, clock_now_us(), illuminator);
	}
}

void can_node_log(const char *text)
{
	const int64_t now_us = clock_now_us();

	if (!active) {
		return;
	}
	if (now_us < log_us) {
		stats.log_skipped++;
		return;
	}
	log_us = now_us + LOG_GAP_US;
	to_send = true;
	(void)dronecan_node_log(&endpoint.node, now_us, DRONECAN_DEBUG_LOG_LEVEL_WARNING, "light",
	                        text);
}

/* --- firmware update -------------------------------------------------------------------------- */

/* The image's next block, or the end. */
static void update_done(struct command *command, const char *failure)
{
	const int64_t now_us = clock_now_us();

	to_send = true;
	if (failure != NULL) {
		dronecan_firmware_stop(&endpoint.firmware);
		can_node_log(failure);
	} else if (update_complete) {
		dronecan_firmware_stop(&endpoint.firmware);
		dronecan_node_restart(&endpoint.node, now_us);
	} else {
		dronecan_firmware_next(&endpoint.firmware, now_us);
	}
	can_node_report(&command->illuminator);
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
		can_node_log("update failed: file server");
		break;
	}
}

/* --- tunnels ---------------------------------------------------------------------------------- */

static void take_frames(struct command *command, uint8_t channel)
{
	struct tunnel *const tunnel = &tunnels[channel];
	struct mavlink_frame frame;

	tunnel->framer.opaque = link_is_opaque();
	while (mavlink_framer_next(&tunnel->framer, &frame)) {
		tunnel->stats.rx_frames++;
		mavlink_node_take(command, TUNNEL_LINK0 + channel, frame.bytes, frame.length);
	}
}

/* Somebody else may have been here before. */
static void tunnel_up(struct command *command, uint8_t channel)
{
	struct tunnel *const tunnel = &tunnels[channel];
	const struct mavlink_framer_stats kept = tunnel->framer.stats;

	mavlink_framer_init(&tunnel->framer);
	tunnel->framer.stats = kept;
	tunnels_up += tunnel->up ? 0 : 1;
	tunnel->up = true;
	mavlink_node_link_up(TUNNEL_LINK0 + channel);
}

static void perform_tunnel(struct command *command)
{
	struct tunnel *const tunnel = &tunnels[out.tunnel.channel];

	if (!out.tunnel_received) {
		return;
	}
	if (out.tunnel.opened) {
		tunnel_up(command, out.tunnel.channel);
	}
	for (size_t used = 0; used < out.tunnel.size;) {
		used += mavlink_framer_write(&tunnel->framer, out.tunnel.data + used,
		                             out.tunnel.size - used);
		tunnel->heard_us = clock_now_us();
		take_frames(command, out.tunnel.channel);
	}
	tunnel->stats.rx_bytes += (uint32_t)out.tunnel.size;
}

/* The channels that have closed, and those that are silent amid a frame, which perhaps is none. */
static void step_tunnels(struct command *command)
{
	for (uint8_t channel = 0; channel < TUNNEL_LINKS_MAX; channel++) {
		struct tunnel *const tunnel = &tunnels[channel];
		struct mavlink_frame frame;

		if (tunnel->up && !endpoint.tunnel.channels[channel].open) {
			tunnel->up = false;
			tunnels_up--;
			mavlink_node_link_down(TUNNEL_LINK0 + channel);
		}
		while (mavlink_framer_pending(&tunnel->framer) &&
		       clock_now_us() - tunnel->heard_us >= MAVLINK_FRAMER_IDLE_US &&
		       mavlink_framer_idle(&tunnel->framer, &frame)) {
			tunnel->stats.rx_frames++;
			mavlink_node_take(command, TUNNEL_LINK0 + channel, frame.bytes,
			                  frame.length);
			take_frames(command, channel);
		}
	}
}

int can_node_tunnel_send(uint8_t channel, const uint8_t *frame, size_t length)
{
	struct link_stats *const its = &tunnels[channel].stats;
	const int64_t now_us = clock_now_us();

	if (!active || !dronecan_tunnel_is_open(&endpoint.tunnel, now_us, channel)) {
		return 0;
	}
	if (!dronecan_tunnel_write(&endpoint.tunnel, now_us, channel, frame, length)) {
		its->tx_dropped++;
		return -ENOBUFS;
	}
	to_send = true;
	its->tx_frames++;
	its->tx_bytes += (uint32_t)length;
	return 0;
}

int can_node_tunnel_forward(uint8_t channel, const uint8_t *frame, size_t length)
{
	struct link_stats *const its = &tunnels[channel].stats;
	const int64_t now_us = clock_now_us();

	if (!active || !dronecan_tunnel_is_open(&endpoint.tunnel, now_us, channel)) {
		return 0;
	}
	if (dronecan_tunnel_waiting(&endpoint.tunnel, channel) + length > TUNNEL_FORWARD_MAX ||
	    !dronecan_tunnel_write(&endpoint.tunnel, now_us, channel, frame, length)) {
		its->forward_dropped++;
		return -ENOBUFS;
	}
	to_send = true;
	its->forwarded++;
	its->tx_frames++;
	its->tx_bytes += (uint32_t)length;
	return 0;
}

int can_node_tunnel_stats(uint8_t channel, struct link_stats *copy)
{
	const unsigned int key = irq_lock();

	*copy = tunnels[channel].stats;
	copy->framing = link_framing_of(&tunnels[channel].framer.stats);
	irq_unlock(key);
	return active ? 0 : -ENODEV;
}

/* --- what the command thread calls ------------------------------------------------------------ */

static void perform(struct command *command)
{
	perform_node(command);
	perform_lights(command);
	perform_update();
	perform_tunnel(command);
}

void can_node_take(struct command *command, struct dronecan_frame *frame)
{
	dronecan_endpoint_receive(&endpoint, clock_now_us(), frame, &out);
	perform(command);
	to_send = true;
	can_link_frame_free(frame);
}

void can_node_flush(void)
{
	struct dronecan_frame frame;

	while (to_send && dronecan_endpoint_next_frame(&endpoint, clock_now_us(), &frame)) {
		if (!can_link_send(&frame)) {
			return;
		}
		dronecan_endpoint_frame_sent(&endpoint);
	}
	to_send = false;
}

void can_node_step(struct command *command)
{
	if (!active) {
		return;
	}
	if (dronecan_endpoint_deadline_us(&endpoint) <= clock_now_us()) {
		dronecan_node_set_bus_errors(&endpoint.node,
		                             can_link_status_get().stats.bus_errors);
		dronecan_endpoint_step(&endpoint, clock_now_us(), &out);
		perform(command);
		to_send = true;
	}
	if (tunnels_up > 0) {
		step_tunnels(command);
	}
}

int64_t can_node_deadline_us(void)
{
	int64_t deadline_us = active ? dronecan_endpoint_deadline_us(&endpoint) : TIME_NEVER_US;

	for (size_t i = 0; i < TUNNEL_LINKS_MAX && tunnels_up > 0; i++) {
		const int64_t idle_us = tunnels[i].heard_us + MAVLINK_FRAMER_IDLE_US;

		/* what is still unfinished after that stays so until more comes */
		if (mavlink_framer_pending(&tunnels[i].framer) && idle_us > clock_now_us()) {
			deadline_us = MIN(deadline_us, idle_us);
		}
	}
	return deadline_us;
}

void can_node_status_get(struct can_node_status *status)
{
	*status = (struct can_node_status){
		.node_id = endpoint.transport.node_id,
		.stats = stats,
		.transport = endpoint.transport.stats,
		.tunnel = endpoint.tunnel.stats,
		.lights = endpoint.lights.stats,
		.requests = endpoint.node.stats.requests,
	};
}
