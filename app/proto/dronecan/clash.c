/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/clash.h"

#include <string.h>

#define FORGET_US     (10 * US_PER_S)
/* A question for each NodeStatus, no more. */
#define ASK_GAP_US    (900 * US_PER_MS)
#define ASK_WITHIN_US ((uint32_t)US_PER_S / 2u)
/* An answer takes 20 ms of the slowest bus. */
#define ANSWER_SLOTS  16u
#define ANSWER_US     (20 * US_PER_MS)
/* A NodeStatus of ours may come back a little later, no more. */
#define ECHO_S        2u
/* GetNodeInfo's response: NodeStatus 7, SoftwareVersion 15, then major, minor, unique id. */
#define UNIQUE_ID_AT  (7u + 15u + 2u)

void dronecan_clash_init(struct dronecan_clash *self)
{
	*self = (struct dronecan_clash){
		.ask_us = TIME_NEVER_US,
		.asked_us = -ASK_GAP_US,
		.answer_us = TIME_NEVER_US,
	};
}

static void hear(struct dronecan_clash *self, int64_t now_us)
{
	self->on = true;
	self->heard_us = now_us;
}

static void status(struct dronecan_clash *self, int64_t now_us,
                   struct dronecan_transport *transport, const struct dronecan_transfer *transfer)
{
	struct dronecan_node_status message;

	if (!dronecan_node_status_decode(&message, !transfer->fd, transfer->data, transfer->size)) {
		return;
	}
	const uint32_t ours_s = (uint32_t)(now_us / US_PER_S);

	/* Once there is a clash, what comes from our id is the other's. */
	if (self->on || message.uptime_sec > ours_s || message.uptime_sec + ECHO_S < ours_s) {
		hear(self, now_us);
	}
	if (!self->is_named && self->ask_us == TIME_NEVER_US &&
	    now_us - self->asked_us >= ASK_GAP_US) {
		self->asked_us = now_us;
		self->ask_us = now_us + dronecan_random(&transport->random) % ASK_WITHIN_US;
	}
}

void dronecan_clash_receive(struct dronecan_clash *self, int64_t now_us,
                            struct dronecan_transport *transport, const uint8_t *unique_id,
                            const struct dronecan_transfer *transfer)
{
	if (transfer->source != transport->node_id) {
		return;
	}
	if (transfer->type == &dronecan_node_status_type) {
		status(self, now_us, transport, transfer);
	} else if (transfer->type == &dronecan_get_node_info_type &&
	           transfer->kind == DRONECAN_RESPONSE &&
	           transfer->size >= UNIQUE_ID_AT + DRONECAN_UNIQUE_ID_SIZE &&
	           memcmp(&transfer->data[UNIQUE_ID_AT], unique_id, DRONECAN_UNIQUE_ID_SIZE) != 0) {
		memcpy(self->unique_id, &transfer->data[UNIQUE_ID_AT], DRONECAN_UNIQUE_ID_SIZE);
		self->is_named = true;
		hear(self, now_us);
	}
}

bool dronecan_clash_delays(struct dronecan_clash *self, int64_t now_us,
                           struct dronecan_transport *transport,
                           const struct dronecan_transfer *request)
{
	if (!self->on || request->source == transport->node_id ||
	    self->answer_us != TIME_NEVER_US) {
		return false;
	}
	self->waiting = *request;
	self->waiting.data = NULL;
	self->waiting.size = 0;
	self->answer_us =
		now_us + (int64_t)(dronecan_random(&transport->random) % ANSWER_SLOTS) * ANSWER_US;
	return true;
}

static void ask(struct dronecan_clash *self, int64_t now_us, struct dronecan_transport *transport)
{
	const struct dronecan_transfer request = {
		.type = &dronecan_get_node_info_type,
		.kind = DRONECAN_REQUEST,
		.target = transport->node_id,
		.priority = DRONECAN_PRIORITY_LOWEST - 1u,
	};

	self->ask_us = TIME_NEVER_US;
	/* No room: counted there, and the next NodeStatus is a second away. */
	(void)dronecan_transport_send(transport, now_us, &request);
}

bool dronecan_clash_step(struct dronecan_clash *self, int64_t now_us,
                         struct dronecan_transport *transport)
{
	if (self->ask_us <= now_us) {
		ask(self, now_us, transport);
	}
	if (self->on && now_us - self->heard_us >= FORGET_US) {
		self->on = false;
		self->is_named = false;
	}
	if (self->answer_us <= now_us) {
		self->answer_us = TIME_NEVER_US;
		return true;
	}
	return false;
}

int64_t dronecan_clash_deadline_us(const struct dronecan_clash *self)
{
	const int64_t first_us = self->ask_us < self->answer_us ? self->ask_us : self->answer_us;

	return self->on && self->heard_us + FORGET_US < first_us ? self->heard_us + FORGET_US
	                                                         : first_us;
}
