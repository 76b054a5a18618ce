/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/endpoint.h"

#include "core/assert.h"
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

#include <string.h>

void mavlink_endpoint_init(struct mavlink_endpoint *self,
                           const struct mavlink_endpoint_config *config)
{
	PHAROS_ASSERT(config->system_id != 0);
	PHAROS_ASSERT((uint32_t)config->links >> MAVLINK_LINKS_MAX == 0);
	memset(self, 0, sizeof(*self));
	self->config = *config;
	self->due_us = TIME_NEVER_US;
	mavlink_texts_init(&self->texts);
	mavlink_vehicle_init(&self->vehicle, config->adopt);
	mavlink_endpoint_set_routing(self, config->routing);
}

static const struct mavlink_component *component_find(const struct mavlink_endpoint *self,
                                                      uint8_t id)
{
	for (uint8_t i = 0; i < self->component_count; i++) {
		if (self->components[i].id == id) {
			return &self->components[i];
		}
	}
	return NULL;
}

void mavlink_endpoint_add(struct mavlink_endpoint *self, int64_t now_us, uint8_t id,
                          const struct mavlink_profile *profile, void *service)
{
	PHAROS_ASSERT(self->component_count < MAVLINK_COMPONENTS_MAX);
	PHAROS_ASSERT(id != 0 && component_find(self, id) == NULL);
	PHAROS_ASSERT(profile->message_count <= MAVLINK_MESSAGES_MAX);

	struct mavlink_component *const component = &self->components[self->component_count++];

	component->profile = profile;
	component->service = service;
	component->id = id;
	mavlink_streams_init(component, now_us);
	self->due_us = now_us;
}

void mavlink_endpoint_set_system_id(struct mavlink_endpoint *self, uint8_t system_id)
{
	PHAROS_ASSERT(system_id != 0);
	self->config.system_id = system_id;
}

void mavlink_endpoint_set_secure_links(struct mavlink_endpoint *self, uint8_t links)
{
	self->config.secure_links = links;
}

void mavlink_endpoint_set_routing(struct mavlink_endpoint *self, bool on)
{
	self->config.routing = on;
#ifdef CONFIG_PHAROS_ROUTING
	mavlink_router_set(&self->router, on);
#endif
}

void mavlink_endpoint_link_up(struct mavlink_endpoint *self, int64_t now_us, uint8_t link)
{
	PHAROS_ASSERT(link < MAVLINK_LINKS_MAX);
	self->config.links |= (uint8_t)(1u << link);
	self->links[link].version = 0;
	for (uint8_t i = 0; i < self->component_count; i++) {
		self->components[i].asked[link] = 0;
		mavlink_streams_reset(&self->components[i], now_us, link);
		self->due_us = now_us;
	}
}

void mavlink_endpoint_link_down(struct mavlink_endpoint *self, uint8_t link)
{
	PHAROS_ASSERT(link < MAVLINK_LINKS_MAX);
	self->config.links &= (uint8_t) ~(1u << link);
#ifdef CONFIG_PHAROS_ROUTING
	mavlink_router_link_down(&self->router, link);
#endif
}

bool mavlink_is_ours(const struct mavlink_endpoint *self, uint8_t system, uint8_t component)
{
	return system == self->config.system_id && component_find(self, component) != NULL;
}

uint8_t mavlink_link_version(const struct mavlink_endpoint *self, uint8_t link)
{
	return self->links[link].version == 1 && !mavlink_is_signing(self) ? 1 : 2;
}

#ifdef CONFIG_PHAROS_ROUTING
/* Only of one that is admitted does it count. */
static bool is_trusted(const struct mavlink_endpoint *self, const struct mavlink_frame *frame,
                       const struct mavlink_target *target)
{
	return mavlink_is_signing(self) ||
	       ((frame->message_id == MAVLINK_MSG_ID_COMMAND_LONG ||
	         frame->message_id == MAVLINK_MSG_ID_COMMAND_INT) &&
	        mavlink_is_ours(self, target->system_id, target->component_id));
}
#endif

/* Bit per link that a frame goes on to. admitted: it makes a route, with a key as without. */
static uint8_t forward(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                       const struct mavlink_frame *frame, bool admitted)
{
#ifdef CONFIG_PHAROS_ROUTING
	if (self->config.routing) {
		const struct mavlink_target target = mavlink_frame_target(frame);
		const struct mavlink_passage passage = {
			.frame = frame,
			.target = target,
			.link = link,
			.links = self->config.links,
			.is_ours = mavlink_is_ours(self, target.system_id, target.component_id),
			.is_trusted = is_trusted(self, frame, &target),
			.makes_route = admitted,
		};

		return mavlink_router_take(&self->router, now_us, &passage);
	}
#endif
	return 0;
}

/* The first frame of a peer decides what a link is spoken to in; version 2, once heard, stays. */
static void link_heard(struct mavlink_link *link, const struct mavlink_frame *frame)
{
	link->stats.rx_frames++;
	if (frame->version > link->version && !mavlink_is_relay(frame)) {
		link->version = frame->version;
	}
}

static bool is_for(const struct mavlink_endpoint *self, const struct mavlink_component *component,
                   const struct mavlink_receiver_row *row, const struct mavlink_frame *frame)
{
	uint8_t system = 0;
	uint8_t id = 0;

	if (row->target_system_offset != MAVLINK_NO_TARGET) {
		system = mavlink_frame_byte(frame, row->target_system_offset);
	}
	if (row->target_component_offset != MAVLINK_NO_TARGET) {
		id = mavlink_frame_byte(frame, row->target_component_offset);
	}
	return (system == 0 || system == self->config.system_id) &&
	       (id == 0 || id == component->id);
}

static void deliver(const struct mavlink_context *context, const struct mavlink_frame *frame)
{
	const struct mavlink_profile *const profile = context->component->profile;

	for (uint8_t i = 0; i < profile->receiver_count; i++) {
		const struct mavlink_receiver_row *const row = &profile->receivers[i];

		if (row->id == frame->message_id &&
		    is_for(context->endpoint, context->component, row, frame)) {
			row->receive(context, frame);
		}
	}
}

void mavlink_endpoint_receive(struct mavlink_endpoint *self, int64_t now_us, uint8_t link,
                              const uint8_t *bytes, size_t length, struct mavlink_outbox *out)
{
	struct mavlink_frame frame;

	PHAROS_ASSERT(link < MAVLINK_LINKS_MAX);
	mavlink_outbox_clear(out);
	if (!mavlink_frame_view(bytes, length, &frame)) {
		self->links[link].stats.rx_malformed++;
		return;
	}
	if (mavlink_is_ours(self, frame.system_id, frame.component_id)) {
		self->links[link].stats.rx_echoes++;
		return;
	}
	link_heard(&self->links[link], &frame);

	const bool admitted = mavlink_admit(self, now_us, link, &frame);

	out->forward = forward(self, now_us, link, &frame, admitted);
	if (!admitted) {
		return;
	}

	struct mavlink_context context = {
		.endpoint = self,
		.out = out,
		.now_us = now_us,
		.link = link,
		.source_system = frame.system_id,
		.source_component = frame.component_id,
		.is_signed = frame.has_signature && mavlink_is_signing(self),
	};

	for (uint8_t i = 0; i < self->component_count; i++) {
		context.component = &self->components[i];
		deliver(&context, &frame);
	}
}

static bool services_step(struct mavlink_context *context)
{
	for (uint8_t i = 0; i < context->endpoint->component_count; i++) {
		context->component = &context->endpoint->components[i];
		if (context->component->profile->step != NULL &&
		    !context->component->profile->step(context)) {
			return false;
		}
	}
	return true;
}

static int64_t services_due_us(const struct mavlink_endpoint *self)
{
	int64_t due_us = TIME_NEVER_US;

	for (uint8_t i = 0; i < self->component_count; i++) {
		const struct mavlink_component *const component = &self->components[i];

		if (component->profile->deadline_us != NULL) {
			const int64_t its_us = component->profile->deadline_us(component->service);

			due_us = its_us < due_us ? its_us : due_us;
		}
	}
	return due_us;
}

static size_t append_number(char *text, size_t length, uint8_t number)
{
	for (uint8_t unit = 100; unit > 0; unit /= 10) {
		if (number >= unit || unit == 1) {
			text[length++] = (char)('0' + number / unit % 10);
		}
	}
	return length;
}

/* The system id is the vehicle's, or it is not, and people should know why. */
static void step_vehicle(struct mavlink_endpoint *self, int64_t now_us)
{
	static const char adopted[] = "System id is now the vehicle's: ";
	static const char several[] = "Several vehicles heard, system id stays ";
	char text[MAVLINK_TEXT_BYTES] = {0};

	_Static_assert(sizeof(several) + sizeof("255") <= sizeof(text), "the texts fit");
	if (!mavlink_vehicle_decide(&self->vehicle, now_us)) {
		return;
	}
	if (self->vehicle.state == MAVLINK_VEHICLE_SEVERAL) {
		memcpy(text, several, sizeof(several));
		(void)append_number(text, sizeof(several) - 1, self->config.system_id);
		(void)mavlink_endpoint_text(self, now_us, MAV_SEVERITY_WARNING, text);
	} else if (self->vehicle.system != self->config.system_id) {
		mavlink_endpoint_set_system_id(self, self->vehicle.system);
		memcpy(text, adopted, sizeof(adopted));
		(void)append_number(text, sizeof(adopted) - 1, self->config.system_id);
		(void)mavlink_endpoint_text(self, now_us, MAV_SEVERITY_INFO, text);
	}
}

void mavlink_endpoint_step(struct mavlink_endpoint *self, int64_t now_us,
                           struct mavlink_outbox *out)
{
	mavlink_outbox_clear(out);
	if (now_us < mavlink_endpoint_deadline_us(self)) {
		return;
	}

	step_vehicle(self, now_us);
	mavlink_signing_step(self, now_us, out);

	struct mavlink_context context = {.endpoint = self, .out = out, .now_us = now_us};

	if (mavlink_streams_step(&context) && mavlink_texts_step(&context)) {
		self->due_us = mavlink_streams_due_us(self);
		(void)services_step(&context);
	}
}

int64_t mavlink_endpoint_deadline_us(const struct mavlink_endpoint *self)
{
	const int64_t services_us = services_due_us(self);
	const int64_t vehicle_us = mavlink_vehicle_deadline_us(&self->vehicle);
	const int64_t signing_us = mavlink_signing_due_us(self);
	const int64_t due_us = services_us < self->due_us ? services_us : self->due_us;
	const int64_t other_us = vehicle_us < signing_us ? vehicle_us : signing_us;

	return other_us < due_us ? other_us : due_us;
}

void mavlink_endpoint_tell(struct mavlink_endpoint *self, int64_t now_us,
                           const struct device_effects *effects)
{
	struct mavlink_context context = {.endpoint = self, .now_us = now_us};

	for (uint8_t i = 0; i < self->component_count; i++) {
		context.component = &self->components[i];
		if (context.component->profile->tell != NULL) {
			context.component->profile->tell(&context, effects);
		}
	}
}

static bool send_in(const struct mavlink_context *context, uint8_t link, uint8_t version,
                    const struct mavlink_kind *kind, const void *payload)
{
	struct mavlink_outbox *const out = context->out;
	struct mavlink_link *const to = &context->endpoint->links[link];
	uint8_t *const sequence = &context->component->sequence[link];

	PHAROS_ASSERT(mavlink_outbox_has_room(out));

	const struct mavlink_sender sender = {
		.version = version,
		.sequence = *sequence,
		.system_id = context->endpoint->config.system_id,
		.component_id = context->component->id,
		.has_signature = mavlink_is_signing(context->endpoint),
	};
	uint8_t *const bytes = out->bytes + out->used;
	size_t length = mavlink_frame_build(bytes, &sender, kind, payload);

	if (length == 0) {
		return false;
	}
	if (sender.has_signature) {
		length += mavlink_sign(context->endpoint, context->now_us, link, bytes, length);
	}
	out->frames[out->count++] = (struct mavlink_outbox_frame){
		.offset = out->used,
		.length = (uint16_t)length,
		.link = link,
	};
	out->used = (uint16_t)(out->used + length);
	(*sequence)++;
	to->stats.tx_frames++;
	return true;
}

bool mavlink_send(const struct mavlink_context *context, uint8_t link,
                  const struct mavlink_kind *kind, const void *payload)
{
	return send_in(context, link, mavlink_link_version(context->endpoint, link), kind, payload);
}

void mavlink_send_asked(const struct mavlink_context *context, uint8_t link,
                        const struct mavlink_kind *kind, const void *payload)
{
	if (!mavlink_send(context, link, kind, payload)) {
		(void)send_in(context, link, 2, kind, payload);
	}
}

int64_t mavlink_bulk_due_us(const struct mavlink_endpoint *self, uint8_t link)
{
	return self->links[link].bulk_us;
}

/* Time that bytes take at bulk's part of the link's rate. */
static int64_t bulk_time_us(const struct mavlink_endpoint *self, uint8_t link, size_t length)
{
	const uint32_t configured = self->config.rates[link];
	const uint32_t rate = configured != 0 ? configured : MAVLINK_RATE_DEFAULT;

	return (int64_t)length * 100 * US_PER_S / ((int64_t)rate * MAVLINK_BULK_PERCENT);
}

bool mavlink_send_bulk(const struct mavlink_context *context, uint8_t link,
                       const struct mavlink_kind *kind, const void *payload)
{
	struct mavlink_link *const to = &context->endpoint->links[link];

	if (!mavlink_send(context, link, kind, payload)) {
		return false;
	}

	const struct mavlink_outbox *const out = context->out;
	const int64_t time_us =
		bulk_time_us(context->endpoint, link, out->frames[out->count - 1].length);

	/* A call that is a little late keeps the pace; a pause gives no credit. */
	if (to->bulk_us + time_us < context->now_us) {
		to->bulk_us = context->now_us;
	}
	to->bulk_us += time_us;
	return true;
}
