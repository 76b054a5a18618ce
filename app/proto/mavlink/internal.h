/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the endpoint's files share: commands, streams, texts, and rows that every component has.
 */
#ifndef PHAROS_PROTO_MAVLINK_INTERNAL_H
#define PHAROS_PROTO_MAVLINK_INTERNAL_H

#include "core/device.h"
#include "proto/mavlink/endpoint.h"
#include "proto/mavlink/identity.h"

/* --- command.c: receivers of COMMAND_LONG and COMMAND_INT, commands of every component ---------
 */
void mavlink_command_long(const struct mavlink_context *context, const struct mavlink_frame *frame);
void mavlink_command_int(const struct mavlink_context *context, const struct mavlink_frame *frame);
void mavlink_command_cancel(const struct mavlink_context *context,
                            const struct mavlink_frame *frame);

uint8_t mavlink_set_message_interval(const struct mavlink_context *context,
                                     const struct mavlink_command *command,
                                     struct mavlink_reply *reply);
uint8_t mavlink_get_message_interval(const struct mavlink_context *context,
                                     const struct mavlink_command *command,
                                     struct mavlink_reply *reply);
uint8_t mavlink_request_message(const struct mavlink_context *context,
                                const struct mavlink_command *command, struct mavlink_reply *reply);

/* --- result.c: the device's door, as MAVLink knows it ----------------------------------------- */

/* Who sent what is being received. */
struct device_who mavlink_who(const struct mavlink_context *context);

/* MAV_RESULT. */
uint8_t mavlink_result(enum device_result result);

/* --- preflight.c: commands of an illuminator that maintain it ------------------------------------
 */
uint8_t mavlink_preflight_reboot(const struct mavlink_context *context,
                                 const struct mavlink_command *command,
                                 struct mavlink_reply *reply);
uint8_t mavlink_preflight_storage(const struct mavlink_context *context,
                                  const struct mavlink_command *command,
                                  struct mavlink_reply *reply);

/* --- stream.c --------------------------------------------------------------------------------- */

/* Row of a message in the component's table; NULL: it has no such message. */
const struct mavlink_message_row *mavlink_message_find(const struct mavlink_component *component,
                                                       uint32_t id);

/* All streams of a new component: default intervals, due at once. */
void mavlink_streams_init(struct mavlink_component *component, int64_t now_us);

/* The same for one link. */
void mavlink_streams_reset(struct mavlink_component *component, int64_t now_us, uint8_t link);

/*
 * interval_us: MAVLINK_INTERVAL_OFF or > 0. links: bit per link. On the context's own link the
 * message counts as asked for.
 */
void mavlink_stream_set(const struct mavlink_context *context,
                        const struct mavlink_message_row *row, uint8_t links, int32_t interval_us);

int32_t mavlink_stream_interval_us(const struct mavlink_context *context,
                                   const struct mavlink_message_row *row);

/* Sends what is due. The context's component and link are set here. false: no room left. */
bool mavlink_streams_step(struct mavlink_context *context);

/* When the next stream of any component is due. */
int64_t mavlink_streams_due_us(const struct mavlink_endpoint *endpoint);

/* --- endpoint.c ------------------------------------------------------------------------------- */

/*
 * Does a relay speak for itself here? A modem (component 68, or RADIO_STATUS and RADIO, whoever's
 * ids they carry), a bridge or a tunnel node (240 … 242); and a HEARTBEAT of an onboard computer
 * (191 … 194), since routers that run there say they are ground stations, and in version 1.
 */
bool mavlink_is_relay(const struct mavlink_frame *frame);

/* RADIO_STATUS, RADIO: about the link that they come on, and nobody else's business. */
bool mavlink_is_link_report(uint32_t message_id);

/* Are these ids exactly those of one of our components? */
bool mavlink_is_ours(const struct mavlink_endpoint *endpoint, uint8_t system, uint8_t component);

/* What a link is spoken to in. With a key it is 2, since 1 can't be signed. */
uint8_t mavlink_link_version(const struct mavlink_endpoint *endpoint, uint8_t link);

/* --- admission.c ------------------------------------------------------------------------------ */
#ifdef CONFIG_PHAROS_SIGNING
/* May our components hear the frame? SETUP_SIGNING is dealt with here. */
bool mavlink_admit(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                   const struct mavlink_frame *frame);
bool mavlink_is_signing(const struct mavlink_endpoint *self);

/* Appends a signature; the bytes that it has. */
size_t mavlink_sign(struct mavlink_endpoint *self, int64_t now_us, uint8_t link, uint8_t *bytes,
                    size_t length);

/* Hands out what is to be stored, when it is time; and when that is. */
void mavlink_signing_step(struct mavlink_endpoint *self, int64_t now_us,
                          struct mavlink_outbox *out);
int64_t mavlink_signing_due_us(const struct mavlink_endpoint *self);
#else
static inline bool mavlink_admit(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                                 const struct mavlink_frame *frame)
{
	(void)self, (void)now_us, (void)link, (void)frame;
	return true;
}
static inline bool mavlink_is_signing(const struct mavlink_endpoint *self)
{
	(void)self;
	return false;
}
static inline size_t mavlink_sign(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                                  uint8_t *bytes, size_t length)
{
	(void)self, (void)now_us, (void)link, (void)bytes, (void)length;
	return 0;
}
static inline void mavlink_signing_step(struct mavlink_endpoint *self, int64_t now_us,
                                        struct mavlink_outbox *out)
{
	(void)self, (void)now_us, (void)out;
}
static inline int64_t mavlink_signing_due_us(const struct mavlink_endpoint *self)
{
	(void)self;
	return TIME_NEVER_US;
}
#endif

/* --- text.c ----------------------------------------------------------------------------------- */
void mavlink_texts_init(struct mavlink_texts *self);

/* Sends what waits, from the first component. false: no room left. */
bool mavlink_texts_step(struct mavlink_context *context);

/* --- presence.c: rows that any component may have in its table ---------------------------------
 */
uint8_t mavlink_fill_heartbeat(const struct mavlink_context *context, float argument,
                               void *payload);
/* Up to size - 1 bytes and a 0; the field is zero already. */
void mavlink_copy_text(char *field, size_t size, const char *text);

uint8_t mavlink_fill_protocol_version(const struct mavlink_context *context, float argument,
                                      void *payload);
uint8_t mavlink_fill_message_interval(const struct mavlink_context *context, float argument,
                                      void *payload);
/* The serial number's first 16 hexadecimal digits. */
uint64_t mavlink_uid(const struct mavlink_identity *identity);
uint8_t mavlink_fill_identity(const struct mavlink_context *context, float argument, void *payload);
uint8_t mavlink_fill_version(const struct mavlink_context *context, float argument, void *payload);
void mavlink_ping(const struct mavlink_context *context, const struct mavlink_frame *frame);
/* TIMESYNC has come to have target ids as extensions; pymavlink 2.4.50 does not know them yet. */
#define MAVLINK_TIMESYNC_TARGET_SYSTEM    16
#define MAVLINK_TIMESYNC_TARGET_COMPONENT 17
void mavlink_timesync(const struct mavlink_context *context, const struct mavlink_frame *frame);

/* Between -most and most; NaN is not. */
static inline bool mavlink_is_within(float value, float most)
{
	return value >= -most && value <= most;
}

/* To the nearest; the value is known to fit. */
static inline int32_t mavlink_rounded(float value)
{
	return (int32_t)(value + (value < 0.0f ? -0.5f : 0.5f));
}

/* Rows that every component has in its tables; with them goes "proto/mavlink/dialect.h". */
#define MAVLINK_COMMON_COMMANDS                                                                    \
	{.id = MAV_CMD_REQUEST_MESSAGE, .run = mavlink_request_message},                           \
		{.id = MAV_CMD_SET_MESSAGE_INTERVAL, .run = mavlink_set_message_interval},         \
	{                                                                                          \
		.id = MAV_CMD_GET_MESSAGE_INTERVAL, .run = mavlink_get_message_interval            \
	}

#define MAVLINK_HEARTBEAT(period_us)                                                               \
	{                                                                                          \
		.kind = MAVLINK_KIND(HEARTBEAT), .interval_us = (period_us),                       \
		.flags = MAVLINK_MESSAGE_FIXED, .fill = mavlink_fill_heartbeat                     \
	}

#define MAVLINK_COMMON_MESSAGES                                                                    \
	{.kind = MAVLINK_KIND(COMPONENT_INFORMATION_BASIC),                                        \
	 .interval_us = MAVLINK_INTERVAL_OFF,                                                      \
	 .fill = mavlink_fill_identity},                                                           \
		{.kind = MAVLINK_KIND(AUTOPILOT_VERSION),                                          \
	         .interval_us = MAVLINK_INTERVAL_OFF,                                              \
	         .fill = mavlink_fill_version},                                                    \
		{.kind = MAVLINK_KIND(MESSAGE_INTERVAL),                                           \
	         .interval_us = MAVLINK_INTERVAL_OFF,                                              \
	         .flags = MAVLINK_MESSAGE_FIXED,                                                   \
	         .fill = mavlink_fill_message_interval},                                           \
	{                                                                                          \
		.kind = MAVLINK_KIND(PROTOCOL_VERSION), .interval_us = MAVLINK_INTERVAL_OFF,       \
		.fill = mavlink_fill_protocol_version                                              \
	}

#define MAVLINK_COMMON_RECEIVERS                                                                   \
	{.id = MAVLINK_MSG_ID_COMMAND_LONG,                                                        \
	 .target_system_offset = offsetof(mavlink_command_long_t, target_system),                  \
	 .target_component_offset = offsetof(mavlink_command_long_t, target_component),            \
	 .receive = mavlink_command_long},                                                         \
	{                                                                                          \
		.id = MAVLINK_MSG_ID_COMMAND_INT,                                                  \
		.target_system_offset = offsetof(mavlink_command_int_t, target_system),            \
		.target_component_offset = offsetof(mavlink_command_int_t, target_component),      \
		.receive = mavlink_command_int                                                     \
	}

/* Of a component that has parameters. */
#define MAVLINK_PARAM_RECEIVERS                                                                    \
	{.id = MAVLINK_MSG_ID_PARAM_REQUEST_READ,                                                  \
	 .target_system_offset = offsetof(mavlink_param_request_read_t, target_system),            \
	 .target_component_offset = offsetof(mavlink_param_request_read_t, target_component),      \
	 .receive = mavlink_params_request_read},                                                  \
		{.id = MAVLINK_MSG_ID_PARAM_REQUEST_LIST,                                          \
	         .target_system_offset = offsetof(mavlink_param_request_list_t, target_system),    \
	         .target_component_offset =                                                        \
	                 offsetof(mavlink_param_request_list_t, target_component),                 \
	         .receive = mavlink_params_request_list},                                          \
	{                                                                                          \
		.id = MAVLINK_MSG_ID_PARAM_SET,                                                    \
		.target_system_offset = offsetof(mavlink_param_set_t, target_system),              \
		.target_component_offset = offsetof(mavlink_param_set_t, target_component),        \
		.receive = mavlink_params_set                                                      \
	}

/* The whole number in a float of the wire. false: NaN, infinite, not whole, or out of 0…max. */
bool mavlink_whole(float wire, uint32_t max, uint32_t *whole);

#endif
