/* SPDX-License-Identifier: Apache-2.0 */
#include "core/assert.h"
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

#include <string.h>

/* param7 of 510, 511, 512: who gets the answer. NaN is how some clients say "not given". */
enum response_target {
	RESPONSE_DEFAULT,
	RESPONSE_REQUESTER,
	RESPONSE_BROADCAST,
};

bool mavlink_whole(float wire, uint32_t max, uint32_t *whole)
{
	/* max as a float may round up; the second comparison is exact. */
	if (!(wire >= 0.0f && wire < 4294967296.0f)) {
		return false;
	}
	*whole = (uint32_t)wire;
	return (float)*whole == wire && *whole <= max;
}

static bool response_links(const struct mavlink_context *context, float wire, uint8_t *links)
{
	uint32_t target = RESPONSE_DEFAULT;

	if (wire == wire && !mavlink_whole(wire, RESPONSE_BROADCAST, &target)) {
		return false;
	}
	*links = (uint8_t)(1u << context->link);
	if (target == RESPONSE_BROADCAST) {
		*links |= context->endpoint->config.links;
	}
	return true;
}

/* Message id of param1, if the component has that message. */
static const struct mavlink_message_row *message_of(const struct mavlink_context *context,
                                                    const struct mavlink_command *command)
{
	uint32_t id;

	if (!mavlink_whole(command->param[0], MAVLINK_MESSAGE_ID_MAX, &id)) {
		return NULL;
	}
	return mavlink_message_find(context->component, id);
}

/* interval of SET_MESSAGE_INTERVAL: -1 off, 0 default, else µs not faster than the fastest. */
static bool interval_of(float wire, int32_t default_us, int32_t *interval_us)
{
	uint32_t whole;

	if (wire == -1.0f) {
		*interval_us = MAVLINK_INTERVAL_OFF;
		return true;
	}
	if (!mavlink_whole(wire, INT32_MAX, &whole)) {
		return false;
	}
	*interval_us = whole == 0 ? default_us : (int32_t)whole;
	return whole == 0 || whole >= MAVLINK_INTERVAL_MIN_US;
}

uint8_t mavlink_set_message_interval(const struct mavlink_context *context,
                                     const struct mavlink_command *command,
                                     struct mavlink_reply *reply)
{
	const struct mavlink_message_row *const row = message_of(context, command);
	int32_t interval_us;
	uint8_t links;

	(void)reply;
	if (row == NULL || !interval_of(command->param[1], row->interval_us, &interval_us) ||
	    !response_links(context, command->param[6], &links)) {
		return MAV_RESULT_DENIED;
	}
	if ((row->flags & MAVLINK_MESSAGE_FIXED) != 0 && interval_us != row->interval_us) {
		return MAV_RESULT_DENIED;
	}
	mavlink_stream_set(context, row, links, interval_us);
	return MAV_RESULT_ACCEPTED;
}

static uint8_t reply_with(const struct mavlink_context *context,
                          const struct mavlink_message_row *row, float argument, uint8_t links,
                          struct mavlink_reply *reply)
{
	memset(reply->payload.bytes, 0, row->kind.length);

	const uint8_t result = row->fill(context, argument, reply->payload.bytes);

	if (result == MAV_RESULT_ACCEPTED) {
		reply->row = row;
		reply->links = links;
	}
	return result;
}

uint8_t mavlink_get_message_interval(const struct mavlink_context *context,
                                     const struct mavlink_command *command,
                                     struct mavlink_reply *reply)
{
	const struct mavlink_message_row *const row =
		mavlink_message_find(context->component, MAVLINK_MSG_ID_MESSAGE_INTERVAL);
	uint8_t links;

	if (row == NULL || !response_links(context, command->param[6], &links)) {
		return MAV_RESULT_DENIED;
	}
	return reply_with(context, row, command->param[0], links, reply);
}

uint8_t mavlink_request_message(const struct mavlink_context *context,
                                const struct mavlink_command *command, struct mavlink_reply *reply)
{
	const struct mavlink_message_row *const row = message_of(context, command);
	uint8_t links;

	if (row == NULL || !response_links(context, command->param[6], &links)) {
		return MAV_RESULT_DENIED;
	}
	return reply_with(context, row, command->param[1], links, reply);
}

static void acknowledge(const struct mavlink_context *context, uint16_t id, uint8_t result,
                        int32_t detail)
{
	static const struct mavlink_kind kind = MAVLINK_KIND(COMMAND_ACK);
	mavlink_command_ack_t ack;

	memset(&ack, 0, sizeof(ack));
	ack.command = id;
	ack.result = result;
	ack.progress = result == MAV_RESULT_IN_PROGRESS ? context->component->running.percent : 0;
	ack.result_param2 = detail;
	ack.target_system = context->source_system;
	ack.target_component = context->source_component;
	(void)mavlink_send(context, context->link, &kind, &ack);
}

static const struct mavlink_command_row *row_of(const struct mavlink_component *component,
                                                uint16_t id)
{
	for (uint8_t i = 0; i < component->profile->command_count; i++) {
		if (component->profile->commands[i].id == id) {
			return &component->profile->commands[i];
		}
	}
	return NULL;
}

static bool row_knows(const struct mavlink_command_row *row, const struct mavlink_command *command)
{
	return row->knows == NULL || row->knows(command);
}

/* Has the component that command, and the message that it is about? */
static bool is_known(const struct mavlink_component *component,
                     const struct mavlink_command *command)
{
	const struct mavlink_command_row *const row = row_of(component, command->id);
	uint32_t id;

	switch (command->id) {
	case MAV_CMD_REQUEST_MESSAGE:
	case MAV_CMD_SET_MESSAGE_INTERVAL:
	case MAV_CMD_GET_MESSAGE_INTERVAL:
		return mavlink_whole(command->param[0], MAVLINK_MESSAGE_ID_MAX, &id) &&
		       mavlink_message_find(component, id) != NULL;
	default:
		return row != NULL && row_knows(row, command);
	}
}

/* While one that takes time runs, it isn't begun again, nor another one. */
static uint8_t run(const struct mavlink_context *context, const struct mavlink_command *command,
                   struct mavlink_reply *reply)
{
	const struct mavlink_command_row *const row = row_of(context->component, command->id);
	struct mavlink_running *const running = &context->component->running;

	if (row == NULL) {
		return MAV_RESULT_UNSUPPORTED;
	}
	if (!row_knows(row, command)) {
		return MAV_RESULT_DENIED;
	}
	if (row->cancel != NULL && running->command.id != 0) {
		const bool same =
			running->command.id == command->id &&
			memcmp(running->command.param, command->param, sizeof(command->param)) == 0;

		return same ? MAV_RESULT_IN_PROGRESS : MAV_RESULT_TEMPORARILY_REJECTED;
	}

	const uint8_t result = row->run(context, command, reply);

	if (result == MAV_RESULT_IN_PROGRESS) {
		PHAROS_ASSERT(row->cancel != NULL);
		*running = (struct mavlink_running){
			.command = *command,
			.link = context->link,
			.source_system = context->source_system,
			.source_component = context->source_component,
		};
	}
	return result;
}

/* State first, then the acknowledgement, then what was asked for. */
static void carry_out(const struct mavlink_context *context, const struct mavlink_command *command)
{
	struct mavlink_reply reply;

	if (command->to_all && !is_known(context->component, command)) {
		return;
	}
	reply.row = NULL;
	reply.detail = 0;

	const uint8_t result = run(context, command, &reply);

	if (result == MAVLINK_NO_ANSWER) {
		return;
	}
	context->endpoint->links[context->link].stats.rx_commands++;
	context->out->command = command->id;
	acknowledge(context, command->id, result, reply.detail);
	if (reply.row == NULL) {
		return;
	}
	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		if (link == context->link) {
			mavlink_send_asked(context, link, &reply.row->kind, reply.payload.bytes);
		} else if ((reply.links & 1u << link) != 0) {
			(void)mavlink_send(context, link, &reply.row->kind, reply.payload.bytes);
		}
	}
}

void mavlink_command_long(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	mavlink_command_long_t wire;

	mavlink_frame_payload(frame, &wire, sizeof(wire));

	const struct mavlink_command command = {
		.id = wire.command,
		.to_all = wire.target_component == 0,
		.param = {wire.param1, wire.param2, wire.param3, wire.param4, wire.param5,
	                  wire.param6, wire.param7},
	};

	carry_out(context, &command);
}

void mavlink_command_int(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	mavlink_command_int_t wire;

	mavlink_frame_payload(frame, &wire, sizeof(wire));

	const struct mavlink_command command = {
		.id = wire.command,
		.to_all = wire.target_component == 0,
		.param = {wire.param1, wire.param2, wire.param3, wire.param4, (float)wire.x,
	                  (float)wire.y, wire.z},
	};

	carry_out(context, &command);
}

/* --- commands that take time ------------------------------------------------------------------ */

/* The context of who waits for the running command. */
static struct mavlink_context waiting(const struct mavlink_context *context)
{
	const struct mavlink_running *const running = &context->component->running;
	struct mavlink_context asker = *context;

	PHAROS_ASSERT(running->command.id != 0);
	asker.link = running->link;
	asker.source_system = running->source_system;
	asker.source_component = running->source_component;
	return asker;
}

void mavlink_command_progress(const struct mavlink_context *context, uint8_t percent)
{
	const struct mavlink_context asker = waiting(context);
	struct mavlink_running *const running = &context->component->running;

	running->percent = percent;
	acknowledge(&asker, running->command.id, MAV_RESULT_IN_PROGRESS, 0);
}

void mavlink_command_done(const struct mavlink_context *context, uint8_t result, int32_t detail)
{
	const struct mavlink_context asker = waiting(context);
	struct mavlink_running *const running = &context->component->running;
	const uint16_t id = running->command.id;

	running->command.id = 0;
	acknowledge(&asker, id, result, detail);
}

/* Who cancels another's command is told as well. */
void mavlink_command_cancel(const struct mavlink_context *context,
                            const struct mavlink_frame *frame)
{
	const struct mavlink_running running = context->component->running;
	mavlink_command_cancel_t wire;

	mavlink_frame_payload(frame, &wire, sizeof(wire));
	if (running.command.id == 0 || running.command.id != wire.command ||
	    !row_of(context->component, wire.command)->cancel(context)) {
		return;
	}
	mavlink_command_done(context, MAV_RESULT_CANCELLED, 0);
	if (running.link != context->link || running.source_system != context->source_system ||
	    running.source_component != context->source_component) {
		acknowledge(context, wire.command, MAV_RESULT_CANCELLED, 0);
	}
}
