/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/allocation.h"

#include <string.h>

#include "core/assert.h"

#define PRIORITY 24u

void dronecan_allocation_init(struct dronecan_allocation *self, const uint8_t *unique_id,
                              uint8_t preferred_id)
{
	PHAROS_ASSERT(preferred_id <= DRONECAN_NODE_ID_MAX);
	memset(self, 0, sizeof(*self));
	memcpy(self->unique_id, unique_id, DRONECAN_UNIQUE_ID_SIZE);
	self->preferred_id = preferred_id;
	self->state = DRONECAN_ALLOCATION_DONE;
}

/* Anew for each transmission, as the specification asks. */
static int64_t random_us(struct dronecan_transport *transport, uint32_t min_ms, uint32_t max_ms)
{
	const uint32_t span_us = (max_ms - min_ms) * US_PER_MS;

	return (int64_t)min_ms * US_PER_MS + dronecan_random(&transport->random) % (span_us + 1u);
}

static void restart_request_timer(struct dronecan_allocation *self, int64_t now_us,
                                  struct dronecan_transport *transport)
{
	self->state = DRONECAN_ALLOCATION_REQUESTING;
	self->request_us =
		now_us + random_us(transport,
	                           DRONECAN_DYNAMIC_NODE_ID_ALLOCATION_MIN_REQUEST_PERIOD_MS,
	                           DRONECAN_DYNAMIC_NODE_ID_ALLOCATION_MAX_REQUEST_PERIOD_MS);
}

void dronecan_allocation_start(struct dronecan_allocation *self, int64_t now_us,
                               struct dronecan_transport *transport)
{
	self->confirmed = 0;
	restart_request_timer(self, now_us, transport);
}

/* Our unique id from offset on, as much as a request may hold. */
static void request(const struct dronecan_allocation *self, int64_t now_us,
                    struct dronecan_transport *transport, uint8_t offset)
{
	const size_t limit = DRONECAN_DYNAMIC_NODE_ID_ALLOCATION_MAX_LENGTH_OF_UNIQUE_ID_IN_REQUEST;
	const size_t left = DRONECAN_UNIQUE_ID_SIZE - (size_t)offset;
	struct dronecan_dynamic_node_id_allocation message = {
		.node_id = self->preferred_id,
		.first_part_of_unique_id = offset == 0,
		.unique_id_len = (uint8_t)((left < limit) ? left : limit),
	};
	struct dronecan_transfer transfer = {
		.type = &dronecan_dynamic_node_id_allocation_type,
		.kind = DRONECAN_MESSAGE,
		.priority = PRIORITY,
		.fd = false,
	};
	uint8_t data[DRONECAN_DYNAMIC_NODE_ID_ALLOCATION_MAX_SIZE];

	memcpy(message.unique_id, &self->unique_id[offset], message.unique_id_len);
	transfer.data = data;
	if (dronecan_dynamic_node_id_allocation_encode(&message, true, data, sizeof(data),
	                                               &transfer.size)) {
		/* No room: the request timer asks again. */
		(void)dronecan_transport_send(transport, now_us, &transfer);
	}
}

uint8_t dronecan_allocation_receive(struct dronecan_allocation *self, int64_t now_us,
                                    struct dronecan_transport *transport,
                                    const struct dronecan_transfer *transfer)
{
	struct dronecan_dynamic_node_id_allocation message;

	if (self->state == DRONECAN_ALLOCATION_DONE ||
	    !dronecan_dynamic_node_id_allocation_decode(&message, !transfer->fd, transfer->data,
	                                                transfer->size)) {
		return 0;
	}
	restart_request_timer(self, now_us, transport);
	if (transfer->source == 0 || message.unique_id_len == 0 ||
	    memcmp(message.unique_id, self->unique_id, message.unique_id_len) != 0) {
		return 0;
	}
	if (message.unique_id_len < DRONECAN_UNIQUE_ID_SIZE) {
		self->confirmed = message.unique_id_len;
		self->follow_up_us =
			now_us +
			random_us(transport,
		                  DRONECAN_DYNAMIC_NODE_ID_ALLOCATION_MIN_FOLLOWUP_DELAY_MS,
		                  DRONECAN_DYNAMIC_NODE_ID_ALLOCATION_MAX_FOLLOWUP_DELAY_MS);
		self->state = DRONECAN_ALLOCATION_FOLLOWING_UP;
		return 0;
	}
	if (message.node_id != 0) {
		self->state = DRONECAN_ALLOCATION_DONE;
	}
	return message.node_id;
}

void dronecan_allocation_step(struct dronecan_allocation *self, int64_t now_us,
                              struct dronecan_transport *transport)
{
	if (self->state == DRONECAN_ALLOCATION_DONE) {
		return;
	}
	/* Also when a follow-up is so late that the allocator has forgotten us. */
	if (now_us >= self->request_us) {
		restart_request_timer(self, now_us, transport);
		request(self, now_us, transport, 0);
		return;
	}
	if (self->state == DRONECAN_ALLOCATION_FOLLOWING_UP && now_us >= self->follow_up_us) {
		self->state = DRONECAN_ALLOCATION_REQUESTING;
		request(self, now_us, transport, self->confirmed);
	}
}

int64_t dronecan_allocation_deadline_us(const struct dronecan_allocation *self)
{
	switch (self->state) {
	case DRONECAN_ALLOCATION_DONE:
		return TIME_NEVER_US;
	case DRONECAN_ALLOCATION_REQUESTING:
		return self->request_us;
	case DRONECAN_ALLOCATION_FOLLOWING_UP:
		return self->follow_up_us;
	}
	return TIME_NEVER_US;
}
