/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/dronecan/transport.h"

#include <string.h>

#include "core/assert.h"

#define NONE (-1)

#define TAIL_START  0x80u
#define TAIL_END    0x40u
#define TAIL_TOGGLE 0x20u
#define CRC_SIZE    2u

static const uint8_t fd_lengths[] = {12, 16, 20, 24, 32, 48, 64};

uint32_t dronecan_random(uint32_t *state)
{
	/* Marsaglia, "Xorshift RNGs", 2003: the triple 13, 17, 5. */
	uint32_t x = *state;

	x ^= x << 13;
	x ^= x >> 17;
	x ^= x << 5;
	*state = x;
	return x;
}

void dronecan_transport_init(struct dronecan_transport *self,
                             const struct dronecan_subscription *subscriptions, size_t count,
                             uint8_t node_id, bool fd, uint32_t seed)
{
	PHAROS_ASSERT(count <= DRONECAN_SUBSCRIPTIONS_MAX);
	PHAROS_ASSERT(node_id <= DRONECAN_NODE_ID_MAX);
	for (size_t i = 0; i < count; i++) {
		PHAROS_ASSERT(subscriptions[i].type->max_size <= DRONECAN_RX_PAYLOAD_MAX ||
		              subscriptions[i].kind == DRONECAN_RESPONSE);
	}
	memset(self, 0, sizeof(*self));
	self->subscriptions = subscriptions;
	self->subscriptions_count = count;
	self->node_id = node_id;
	self->fd = fd;
	self->random = (seed != 0) ? seed : 1u;
	self->delivered = NONE;
	self->tx_current = NONE;
}

void dronecan_transport_set_node_id(struct dronecan_transport *self, uint8_t node_id)
{
	PHAROS_ASSERT(node_id >= 1u && node_id <= DRONECAN_NODE_ID_MAX);
	self->node_id = node_id;
}

/* Bytes of a frame that holds at least size; classic and small FD lengths are exact. */
static size_t frame_length(size_t size)
{
	if (size <= DRONECAN_FRAME_SIZE_CLASSIC) {
		return size;
	}
	for (size_t i = 0; i < sizeof(fd_lengths); i++) {
		if (size <= fd_lengths[i]) {
			return fd_lengths[i];
		}
	}
	return DRONECAN_FRAME_SIZE_FD;
}

static size_t frame_room(const struct dronecan_tx *tx)
{
	return (tx->fd ? DRONECAN_FRAME_SIZE_FD : DRONECAN_FRAME_SIZE_CLASSIC) - 1u;
}

static bool is_single(const struct dronecan_tx *tx)
{
	return tx->size <= frame_room(tx);
}

/* Payload and, with several frames, its CRC. */
static size_t total_size(const struct dronecan_tx *tx)
{
	return tx->size + (is_single(tx) ? 0u : CRC_SIZE);
}

/* The CRC covers FD's padding of the last frame. */
static uint16_t transfer_crc(const struct dronecan_tx *tx)
{
	static const uint8_t zero;
	uint16_t crc = dronecan_crc(tx->type->crc_seed, tx->data, tx->size);
	const size_t last = total_size(tx) % frame_room(tx);

	if (tx->fd && last != 0) {
		for (size_t i = last + 1u; i < frame_length(last + 1u); i++) {
			crc = dronecan_crc(crc, &zero, 1);
		}
	}
	return crc;
}

/* The next transfer id of messages of a type, or of requests of a type to a node. */
static uint8_t next_transfer_id(struct dronecan_transport *self, const struct dronecan_type *type,
                                uint8_t target)
{
	struct dronecan_counter *counter = NULL;

	for (size_t i = 0; i < DRONECAN_TX_COUNTERS; i++) {
		if (self->counters[i].type == type && self->counters[i].target == target) {
			counter = &self->counters[i];
		}
	}
	if (counter == NULL) {
		counter = &self->counters[self->counters_next];
		self->counters_next = (uint8_t)((self->counters_next + 1u) % DRONECAN_TX_COUNTERS);
		*counter = (struct dronecan_counter){.type = type, .target = target};
	}
	const uint8_t id = counter->next;

	counter->next = (id + 1u) & DRONECAN_TRANSFER_ID_MASK;
	return id;
}

uint8_t dronecan_transport_last_id(const struct dronecan_transport *self,
                                   const struct dronecan_type *type, uint8_t target)
{
	for (size_t i = 0; i < DRONECAN_TX_COUNTERS; i++) {
		if (self->counters[i].type == type && self->counters[i].target == target) {
			return (self->counters[i].next - 1u) & DRONECAN_TRANSFER_ID_MASK;
		}
	}
	return DRONECAN_TRANSFER_ID_MASK;
}

static uint32_t frame_id(struct dronecan_transport *self, const struct dronecan_transfer *transfer)
{
	const uint32_t id = ((uint32_t)transfer->priority << 24) | self->node_id;
	const uint32_t type_id = transfer->type->id;

	switch (transfer->kind) {
	case DRONECAN_MESSAGE:
		if (self->node_id == 0) {
			const uint32_t discriminator = dronecan_random(&self->random) & 0x3FFFu;

			return id | (discriminator << 10) | ((type_id & 0x3u) << 8);
		}
		return id | (type_id << 8);
	case DRONECAN_REQUEST:
		return id | (type_id << 16) | 0x8000u | ((uint32_t)transfer->target << 8) | 0x80u;
	case DRONECAN_RESPONSE:
		return id | (type_id << 16) | ((uint32_t)transfer->target << 8) | 0x80u;
	}
	return id;
}

static void forget(struct dronecan_transport *self, size_t index)
{
	self->tx[index].used = false;
	if (self->tx_current == (int8_t)index) {
		self->tx_current = NONE;
	}
}

/* A started one goes too: its peer's time-out has nearly run out. */
static void expire(struct dronecan_transport *self, int64_t now_us)
{
	for (size_t i = 0; i < DRONECAN_TX_TRANSFERS; i++) {
		if (self->tx[i].used && now_us - self->tx[i].queued_us > DRONECAN_TX_TIMEOUT_US) {
			self->stats.tx_expired++;
			forget(self, i);
		}
	}
}

/* A free place, else that of the newest of the lowest priority of which nothing was sent. */
static struct dronecan_tx *take_place(struct dronecan_transport *self, uint8_t priority)
{
	struct dronecan_tx *victim = NULL;

	for (size_t i = 0; i < DRONECAN_TX_TRANSFERS; i++) {
		struct dronecan_tx *tx = &self->tx[i];

		if (!tx->used) {
			return tx;
		}
		if (tx->sent != 0 || tx->priority <= priority) {
			continue;
		}
		if (victim == NULL || tx->priority > victim->priority ||
		    (tx->priority == victim->priority && tx->order > victim->order)) {
			victim = tx;
		}
	}
	if (victim != NULL) {
		self->stats.tx_evicted++;
		forget(self, (size_t)(victim - self->tx));
	}
	return victim;
}

bool dronecan_transport_send(struct dronecan_transport *self, int64_t now_us,
                             const struct dronecan_transfer *transfer)
{
	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	PHAROS_ASSERT(transfer->size <= DRONECAN_TX_PAYLOAD_MAX);
	PHAROS_ASSERT(transfer->priority <= DRONECAN_PRIORITY_LOWEST);
	PHAROS_ASSERT((transfer->target == 0) == (transfer->kind == DRONECAN_MESSAGE));
	if (self->node_id == 0 && (transfer->kind != DRONECAN_MESSAGE || transfer->type->id > 3u ||
	                           transfer->size >= DRONECAN_FRAME_SIZE_CLASSIC)) {
		return false;
	}
	expire(self, now_us);
	struct dronecan_tx *tx = take_place(self, transfer->priority);

	if (tx == NULL) {
		self->stats.tx_no_room++;
		return false;
	}
	tx->queued_us = now_us;
	tx->frame_id = frame_id(self, transfer);
	tx->order = self->tx_order++;
	tx->type = transfer->type;
	tx->size = (uint16_t)transfer->size;
	tx->sent = 0;
	tx->target = transfer->target;
	tx->priority = transfer->priority;
	tx->id = (transfer->kind == DRONECAN_RESPONSE)
	                 ? transfer->id
	                 : next_transfer_id(self, transfer->type, transfer->target);
	tx->used = true;
	tx->toggle = false;
	tx->fd = self->fd && transfer->fd;
	if (transfer->size > 0) {
		memcpy(tx->data, transfer->data, transfer->size);
	}
	tx->crc = transfer_crc(tx);
	return true;
}

size_t dronecan_transport_room(const struct dronecan_transport *self)
{
	size_t count = 0;

	for (size_t i = 0; i < DRONECAN_TX_TRANSFERS; i++) {
		count += self->tx[i].used ? 0u : 1u;
	}
	return count;
}

/* By priority, then in order of arrival; a serial number comparison, as the order wraps. */
static bool goes_before(const struct dronecan_tx *a, const struct dronecan_tx *b)
{
	if (a->priority != b->priority) {
		return a->priority < b->priority;
	}
	return (int32_t)(a->order - b->order) < 0;
}

/* To a receiver both are one stream: type, kind and ends are the same. */
static bool same_stream(const struct dronecan_tx *a, const struct dronecan_tx *b)
{
	const uint32_t without_priority = 0x00FFFFFFu;

	return ((a->frame_id ^ b->frame_id) & without_priority) == 0;
}

static struct dronecan_tx *choose(struct dronecan_transport *self)
{
	struct dronecan_tx *best = NULL;

	for (size_t i = 0; i < DRONECAN_TX_TRANSFERS; i++) {
		struct dronecan_tx *tx = &self->tx[i];

		if (tx->used && (best == NULL || goes_before(tx, best))) {
			best = tx;
		}
	}
	if (best == NULL || best->sent != 0) {
		return best;
	}
	for (size_t i = 0; i < DRONECAN_TX_TRANSFERS; i++) {
		struct dronecan_tx *tx = &self->tx[i];

		if (tx->used && tx->sent != 0 && same_stream(tx, best)) {
			return tx;
		}
	}
	return best;
}

/* Bytes of payload and CRC that the next frame takes. */
static size_t next_part(const struct dronecan_tx *tx)
{
	const size_t left = total_size(tx) - tx->sent;

	return (left < frame_room(tx)) ? left : frame_room(tx);
}

static void build(const struct dronecan_tx *tx, struct dronecan_frame *frame)
{
	const size_t part = next_part(tx);
	const size_t total = total_size(tx);
	const size_t length = tx->fd ? frame_length(part + 1u) : part + 1u;
	const size_t crc = total - tx->size;
	unsigned int tail = tx->id;
	size_t at = 0;

	memset(frame, 0, sizeof(*frame));
	frame->id = tx->frame_id;
	frame->fd = tx->fd;
	frame->size = (uint8_t)length;
	if (tx->sent == 0) {
		tail |= TAIL_START;
		if (crc != 0) {
			frame->data[at++] = (uint8_t)tx->crc;
			frame->data[at++] = (uint8_t)(tx->crc >> 8);
		}
	}
	memcpy(&frame->data[at], &tx->data[tx->sent + at - crc], part - at);
	tail |= (tx->sent + part == total) ? TAIL_END : 0u;
	tail |= tx->toggle ? TAIL_TOGGLE : 0u;
	frame->data[length - 1u] = (uint8_t)tail;
}

bool dronecan_transport_next_frame(struct dronecan_transport *self, int64_t now_us,
                                   struct dronecan_frame *frame)
{
	expire(self, now_us);
	const struct dronecan_tx *tx = choose(self);

	if (tx == NULL) {
		self->tx_current = NONE;
		return false;
	}
	self->tx_current = (int8_t)(tx - self->tx);
	build(tx, frame);
	return true;
}

void dronecan_transport_frame_sent(struct dronecan_transport *self)
{
	if (self->tx_current == NONE) {
		return;
	}
	const size_t index = (size_t)self->tx_current;
	struct dronecan_tx *tx = &self->tx[index];

	self->stats.frames_tx++;
	tx->sent = (uint16_t)(tx->sent + next_part(tx));
	tx->toggle = !tx->toggle;
	if (tx->sent >= total_size(tx)) {
		self->stats.transfers_tx++;
		forget(self, index);
	}
}
