/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

#include <string.h>

#define NS_PER_US 1000

/* MAVLink versions as PROTOCOL_VERSION writes them. */
#define PROTOCOL_VERSION_1 100
#define PROTOCOL_VERSION_2 200

/* Of every component. */
#define CAPABILITIES (MAV_PROTOCOL_CAPABILITY_MAVLINK2 | MAV_PROTOCOL_CAPABILITY_COMMAND_INT)

/* ardupilotmega.xml RADIO, what RADIO_STATUS was before; common.xml has left it out. */
#define MESSAGE_RADIO 166

bool mavlink_is_link_report(uint32_t message_id)
{
	return message_id == MAVLINK_MSG_ID_RADIO_STATUS || message_id == MESSAGE_RADIO;
}

bool mavlink_is_relay(const struct mavlink_frame *frame)
{
	if (mavlink_is_link_report(frame->message_id)) {
		return true;
	}
	switch (frame->component_id) {
	case MAV_COMP_ID_TELEMETRY_RADIO:
	case MAV_COMP_ID_UDP_BRIDGE:
	case MAV_COMP_ID_UART_BRIDGE:
	case MAV_COMP_ID_TUNNEL_NODE:
		return true;
	case MAV_COMP_ID_ONBOARD_COMPUTER:
	case MAV_COMP_ID_ONBOARD_COMPUTER2:
	case MAV_COMP_ID_ONBOARD_COMPUTER3:
	case MAV_COMP_ID_ONBOARD_COMPUTER4:
		return frame->message_id == MAVLINK_MSG_ID_HEARTBEAT;
	default:
		return false;
	}
}

uint8_t mavlink_fill_heartbeat(const struct mavlink_context *context, float argument, void *payload)
{
	const struct mavlink_component *const component = context->component;
	mavlink_heartbeat_t *const heartbeat = payload;

	(void)argument;
	heartbeat->type = component->profile->type;
	heartbeat->autopilot = MAV_AUTOPILOT_INVALID;
	heartbeat->system_status = component->profile->system_status(component->service);
	heartbeat->mavlink_version = 3; /* minimal.xml <version> */
	return MAV_RESULT_ACCEPTED;
}

uint8_t mavlink_fill_protocol_version(const struct mavlink_context *context, float argument,
                                      void *payload)
{
	mavlink_protocol_version_t *const version = payload;
	const uint8_t spoken = mavlink_link_version(context->endpoint, context->link);

	(void)argument;
	version->version = spoken == 1 ? PROTOCOL_VERSION_1 : PROTOCOL_VERSION_2;
	version->min_version = PROTOCOL_VERSION_1;
	version->max_version = PROTOCOL_VERSION_2;
	return MAV_RESULT_ACCEPTED;
}

uint8_t mavlink_fill_message_interval(const struct mavlink_context *context, float argument,
                                      void *payload)
{
	mavlink_message_interval_t *const interval = payload;
	const struct mavlink_message_row *row;
	uint32_t id;

	if (!mavlink_whole(argument, UINT16_MAX, &id)) {
		return MAV_RESULT_DENIED;
	}
	row = mavlink_message_find(context->component, id);
	interval->message_id = (uint16_t)id;
	interval->interval_us = row == NULL ? 0 : mavlink_stream_interval_us(context, row);
	return MAV_RESULT_ACCEPTED;
}

void mavlink_copy_text(char *field, size_t size, const char *text)
{
	for (size_t i = 0; i + 1 < size && text[i] != '\0'; i++) {
		field[i] = text[i];
	}
}

static uint32_t capabilities(const struct mavlink_context *context)
{
	return CAPABILITIES | context->component->profile->capabilities;
}

static const struct mavlink_identity *identity_of(const struct mavlink_context *context)
{
	return context->component->profile->identity(context->component->service);
}

uint8_t mavlink_fill_identity(const struct mavlink_context *context, float argument, void *payload)
{
	const struct mavlink_identity *const identity = identity_of(context);
	mavlink_component_information_basic_t *const basic = payload;

	(void)argument;
	basic->capabilities = capabilities(context);
	basic->time_boot_ms = (uint32_t)(context->now_us / US_PER_MS);
	basic->time_manufacture_s = identity->time_manufacture_s;
	mavlink_copy_text(basic->vendor_name, sizeof(basic->vendor_name), identity->vendor_name);
	mavlink_copy_text(basic->model_name, sizeof(basic->model_name), identity->model_name);
	mavlink_copy_text(basic->software_version, sizeof(basic->software_version),
	                  identity->software_version);
	mavlink_copy_text(basic->hardware_version, sizeof(basic->hardware_version),
	                  identity->hardware_version);
	mavlink_copy_text(basic->serial_number, sizeof(basic->serial_number),
	                  identity->serial_number);
	return MAV_RESULT_ACCEPTED;
}

uint64_t mavlink_uid(const struct mavlink_identity *identity)
{
	const char *const serial_number = identity->serial_number;
	uint64_t uid = 0;

	for (size_t i = 0; i < 16 && serial_number[i] != '\0'; i++) {
		const char c = serial_number[i];

		if (c >= '0' && c <= '9') {
			uid = uid << 4 | (uint64_t)(c - '0');
		} else if (c >= 'a' && c <= 'f') {
			uid = uid << 4 | (uint64_t)(c - 'a' + 10);
		}
	}
	return uid;
}

uint8_t mavlink_fill_version(const struct mavlink_context *context, float argument, void *payload)
{
	const struct mavlink_identity *const identity = identity_of(context);
	mavlink_autopilot_version_t *const version = payload;

	(void)argument;
	version->capabilities = capabilities(context);
	version->flight_sw_version = identity->version_code;
	version->uid = mavlink_uid(identity);
	return MAV_RESULT_ACCEPTED;
}

/* A question has target 0/0, an answer has the asker's ids: only questions are answered. */
void mavlink_ping(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(PING);
	mavlink_ping_t ping;

	mavlink_frame_payload(frame, &ping, sizeof(ping));
	if (ping.target_system != 0 || ping.target_component != 0) {
		return;
	}
	ping.target_system = context->source_system;
	ping.target_component = context->source_component;
	(void)mavlink_send(context, context->link, &kind, &ping);
}

/* tc1 0 is a question; it comes back with our clock, the asker's mirrored. */
void mavlink_timesync(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	static const struct mavlink_kind kind = {
		.id = MAVLINK_MSG_ID_TIMESYNC,
		.crc_extra = MAVLINK_MSG_ID_TIMESYNC_CRC,
		.min_length = MAVLINK_MSG_ID_TIMESYNC_MIN_LEN,
		.length = MAVLINK_TIMESYNC_TARGET_COMPONENT + 1,
	};
	mavlink_timesync_t sync;
	uint8_t payload[MAVLINK_TIMESYNC_TARGET_COMPONENT + 1];

	mavlink_frame_payload(frame, &sync, sizeof(sync));
	if (sync.tc1 != 0) {
		return;
	}
	sync.tc1 = context->now_us * NS_PER_US;
	memcpy(payload, &sync, MAVLINK_MSG_ID_TIMESYNC_MIN_LEN);
	payload[MAVLINK_TIMESYNC_TARGET_SYSTEM] = context->source_system;
	payload[MAVLINK_TIMESYNC_TARGET_COMPONENT] = context->source_component;
	(void)mavlink_send(context, context->link, &kind, payload);
}
