/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/internal.h"
#include "proto/mavlink/real.h"

#include <string.h>

const struct mavlink_message_row *mavlink_message_find(const struct mavlink_component *component,
                                                       uint32_t id)
{
	const struct mavlink_profile *const profile = component->profile;

	for (uint8_t i = 0; i < profile->message_count; i++) {
		if (profile->messages[i].kind.id == id) {
			return &profile->messages[i];
		}
	}
	return NULL;
}

static size_t row_index(const struct mavlink_component *component,
                        const struct mavlink_message_row *row)
{
	return (size_t)(row - component->profile->messages);
}

void mavlink_streams_reset(struct mavlink_component *component, int64_t now_us, uint8_t link)
{
	for (uint8_t i = 0; i < component->profile->message_count; i++) {
		component->streams[link][i] = (struct mavlink_stream){
			.next_us = now_us,
			.sent_us = (uint32_t)(now_us - MAVLINK_CHANGE_GAP_MIN_US),
			.interval_us = component->profile->messages[i].interval_us,
		};
	}
}

void mavlink_streams_init(struct mavlink_component *component, int64_t now_us)
{
	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		mavlink_streams_reset(component, now_us, link);
	}
}

/* The endpoint wakes no later than at_us. */
static void wake(struct mavlink_endpoint *endpoint, int64_t at_us)
{
	if (at_us < endpoint->due_us) {
		endpoint->due_us = at_us;
	}
}

void mavlink_stream_set(const struct mavlink_context *context,
                        const struct mavlink_message_row *row, uint8_t links, int32_t interval_us)
{
	const size_t index = row_index(context->component, row);

	context->component->asked[context->link] |= (uint16_t)(1u << index);
	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		if ((links & 1u << link) == 0) {
			continue;
		}

		struct mavlink_stream *const stream = &context->component->streams[link][index];

		/* The same again must not push the next message away. */
		if (stream->interval_us == interval_us) {
			continue;
		}
		stream->interval_us = interval_us;
		if (interval_us != MAVLINK_INTERVAL_OFF) {
			stream->next_us = context->now_us + interval_us;
			wake(context->endpoint, stream->next_us);
		}
	}
}

int32_t mavlink_stream_interval_us(const struct mavlink_context *context,
                                   const struct mavlink_message_row *row)
{
	return context->component->streams[context->link][row_index(context->component, row)]
	        .interval_us;
}

/* A default stream that the link's version can't carry is silent there. */
static bool is_carried(const struct mavlink_context *context, size_t index)
{
	const struct mavlink_component *const component = context->component;

	return component->profile->messages[index].kind.id <= MAVLINK_V1_MESSAGE_MAX ||
	       mavlink_link_version(context->endpoint, context->link) != 1 ||
	       (component->asked[context->link] & 1u << index) != 0;
}

/* The next time on the grid; a stream that fell behind starts a new grid. */
static void stream_advance(struct mavlink_stream *stream, int64_t now_us)
{
	stream->next_us += stream->interval_us;
	if (stream->next_us <= now_us) {
		stream->next_us = now_us + stream->interval_us;
	}
}

static void stream_send(const struct mavlink_context *context, size_t index,
                        struct mavlink_stream *stream)
{
	const struct mavlink_message_row *const row = &context->component->profile->messages[index];
	union mavlink_payload payload;

	if (is_carried(context, index)) {
		memset(payload.bytes, 0, row->kind.length);
		if (row->fill(context, NAN, payload.bytes) == 0) {
			mavlink_send_asked(context, context->link, &row->kind, payload.bytes);
		}
	}
	stream->sent_us = (uint32_t)context->now_us;
	stream_advance(stream, context->now_us);
}

static bool stream_is_live(const struct mavlink_endpoint *endpoint, uint8_t link,
                           const struct mavlink_stream *stream)
{
	return (endpoint->config.links & 1u << link) != 0 &&
	       stream->interval_us != MAVLINK_INTERVAL_OFF;
}

static bool component_step(struct mavlink_context *context)
{
	struct mavlink_component *const component = context->component;

	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		context->link = link;
		for (uint8_t i = 0; i < component->profile->message_count; i++) {
			struct mavlink_stream *const stream = &component->streams[link][i];

			if (!stream_is_live(context->endpoint, link, stream) ||
			    stream->next_us > context->now_us) {
				continue;
			}
			if (!mavlink_outbox_has_room(context->out)) {
				return false;
			}
			stream_send(context, i, stream);
		}
	}
	return true;
}

bool mavlink_streams_step(struct mavlink_context *context)
{
	for (uint8_t i = 0; i < context->endpoint->component_count; i++) {
		context->component = &context->endpoint->components[i];
		if (!component_step(context)) {
			return false;
		}
	}
	return true;
}

static int64_t component_due_us(const struct mavlink_endpoint *endpoint,
                                const struct mavlink_component *component)
{
	int64_t due_us = TIME_NEVER_US;

	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		for (uint8_t i = 0; i < component->profile->message_count; i++) {
			const struct mavlink_stream *const stream = &component->streams[link][i];

			if (stream_is_live(endpoint, link, stream) && stream->next_us < due_us) {
				due_us = stream->next_us;
			}
		}
	}
	return due_us;
}

int64_t mavlink_streams_due_us(const struct mavlink_endpoint *endpoint)
{
	int64_t due_us = TIME_NEVER_US;

	for (uint8_t i = 0; i < endpoint->component_count; i++) {
		const int64_t its_us = component_due_us(endpoint, &endpoint->components[i]);

		if (its_us < due_us) {
			due_us = its_us;
		}
	}
	return due_us;
}

void mavlink_changed(const struct mavlink_context *context)
{
	struct mavlink_component *const component = context->component;

	for (uint8_t link = 0; link < MAVLINK_LINKS_MAX; link++) {
		for (uint8_t i = 0; i < component->profile->message_count; i++) {
			struct mavlink_stream *const stream = &component->streams[link][i];
			const uint8_t flags = component->profile->messages[i].flags;

			if ((flags & MAVLINK_MESSAGE_ON_CHANGE) == 0 ||
			    !stream_is_live(context->endpoint, link, stream)) {
				continue;
			}

			/* The bits come again after 71 minutes: it is then told a little late. */
			const uint32_t since_us = (uint32_t)context->now_us - stream->sent_us;
			const int64_t at_us =
				since_us < MAVLINK_CHANGE_GAP_MIN_US
					? context->now_us + MAVLINK_CHANGE_GAP_MIN_US - since_us
					: context->now_us;

			if (at_us < stream->next_us) {
				stream->next_us = at_us;
			}
			wake(context->endpoint, stream->next_us);
		}
	}
}
