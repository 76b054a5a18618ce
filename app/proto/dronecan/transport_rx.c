/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From frames to transfers. A transfer of several frames, by the tail byte of each:
 *
 *   data        CRC p0..p4 | p5..p11 | p12..
 *   tail        S-- 7      | --T 7   | -E- 7     S start, E end, T toggle, 7 the transfer id
 *
 * A session stands for one sender of one type (and kind). Between transfers it only remembers
 * which id comes next; a buffer is its own only while a transfer is under way:
 *
 *              start, id as expected              end, CRC right: deliver
 *   no session ---------> under way ---------------------------> idle, next_id + 1
 *                         |   ^ frame in turn                     |  ^
 *                         |   +--(append)                         |  |
 *                         | 2 s without an end, too long,         |  | start with the next id,
 *                         | wrong CRC, evicted: count             |  | or with any but the last
 *                         +-------------------------------------> +--+
 *
 * Three ids matter when a start comes: the expected one (take it), the one before (a frame that
 * the controller sent twice: not again), any other (transfers were lost on the bus: begin anew). A
 * frame that is no start can only continue; out of turn, by its toggle, it is refused and the
 * transfer waits on, since a repeated frame is followed by the right one.
 *
 * is_ours lets the first frame of a transfer say whom it concerns (a tunnel's target), so that a
 * busy bus of others' tunnels takes no buffers here; only its id is noted.
 */
#include "proto/dronecan/transport.h"

#include <string.h>

#include "core/assert.h"

#define NONE (-1)

#define TAIL_START  0x80u
#define TAIL_END    0x40u
#define TAIL_TOGGLE 0x20u
#define CRC_SIZE    2u

/* A frame's id and tail byte, taken apart. */
struct header {
	enum dronecan_kind kind;
	uint16_t type_id;
	uint8_t source;
	uint8_t target;
	uint8_t priority;
	uint8_t id;
	bool start;
	bool end;
	bool toggle;
};

uint16_t dronecan_crc(uint16_t crc, const uint8_t *data, size_t size)
{
	for (size_t i = 0; i < size; i++) {
		crc = (uint16_t)(crc ^ ((unsigned int)data[i] << 8));
		for (unsigned int bit = 0; bit < 8u; bit++) {
			const unsigned int shifted = (unsigned int)crc << 1;

			crc = (uint16_t)((crc & 0x8000u) ? shifted ^ 0x1021u : shifted);
		}
	}
	return crc;
}

static bool parse(const struct dronecan_frame *frame, struct header *out)
{
	const size_t limit = frame->fd ? DRONECAN_FRAME_SIZE_FD : DRONECAN_FRAME_SIZE_CLASSIC;

	if (frame->size < 1u || frame->size > limit || frame->id > 0x1FFFFFFFu) {
		return false;
	}
	const uint8_t tail = frame->data[frame->size - 1u];

	out->source = frame->id & 0x7Fu;
	out->priority = (frame->id >> 24) & 0x1Fu;
	out->id = tail & DRONECAN_TRANSFER_ID_MASK;
	out->start = (tail & TAIL_START) != 0;
	out->end = (tail & TAIL_END) != 0;
	out->toggle = (tail & TAIL_TOGGLE) != 0;
	if (frame->id & 0x80u) {
		out->kind = (frame->id & 0x8000u) ? DRONECAN_REQUEST : DRONECAN_RESPONSE;
		out->type_id = (frame->id >> 16) & 0xFFu;
		out->target = (frame->id >> 8) & 0x7Fu;
		if (out->source == 0 || out->target == 0) {
			return false;
		}
	} else {
		out->kind = DRONECAN_MESSAGE;
		out->target = 0;
		/* An anonymous frame has room for two bits of it, below its discriminator. */
		out->type_id = (uint16_t)((frame->id >> 8) & (out->source == 0 ? 0x3u : 0xFFFFu));
	}
	if (out->start && out->toggle) {
		return false;
	}
	if (out->source == 0) {
		return out->start && out->end;
	}
	/* The start of several frames holds the CRC; only the tail of a last one may be alone. */
	return out->end || frame->size > (out->start ? CRC_SIZE : 0u) + 1u;
}

static int find_subscription(const struct dronecan_transport *self, const struct header *header,
                             bool is_own_id)
{
	const enum dronecan_from not_from = is_own_id ? DRONECAN_FROM_OTHERS : DRONECAN_FROM_OWN_ID;

	for (size_t i = 0; i < self->subscriptions_count; i++) {
		if (self->subscriptions[i].kind == header->kind &&
		    self->subscriptions[i].type->id == header->type_id &&
		    self->subscriptions[i].from != not_from) {
			return (int)i;
		}
	}
	return NONE;
}

static struct dronecan_session *find_session(struct dronecan_transport *self, int subscription,
                                             uint8_t source)
{
	for (size_t i = 0; i < DRONECAN_RX_SESSIONS; i++) {
		struct dronecan_session *session = &self->sessions[i];

		if (session->used && session->subscription == subscription &&
		    session->source == source) {
			return session;
		}
	}
	return NULL;
}

static void release_buffer(struct dronecan_transport *self, struct dronecan_session *session)
{
	if (session->buffer != NONE) {
		self->buffer_taken[session->buffer] = false;
		session->buffer = NONE;
	}
}

/* Ends the transfer under way; the id after it is expected next. */
static void finish(struct dronecan_transport *self, struct dronecan_session *session)
{
	release_buffer(self, session);
	session->under_way = false;
	session->next_id = (session->next_id + 1u) & DRONECAN_TRANSFER_ID_MASK;
}

/* Transfers that will never end give back what they hold. */
static void expire(struct dronecan_transport *self, int64_t now_us)
{
	for (size_t i = 0; i < DRONECAN_RX_SESSIONS; i++) {
		struct dronecan_session *session = &self->sessions[i];

		if (session->used && session->under_way &&
		    now_us - session->started_us > DRONECAN_TRANSFER_TIMEOUT_US) {
			self->stats.rx_incomplete++;
			finish(self, session);
		}
	}
}

/* The oldest incomplete transfer of lower priority; NULL: there is none. */
static struct dronecan_session *find_victim(struct dronecan_transport *self, uint8_t priority,
                                            bool with_buffer)
{
	struct dronecan_session *victim = NULL;

	for (size_t i = 0; i < DRONECAN_RX_SESSIONS; i++) {
		struct dronecan_session *session = &self->sessions[i];

		if (session->used && session->under_way && session->priority > priority &&
		    (!with_buffer || session->buffer != NONE) &&
		    (victim == NULL || session->started_us < victim->started_us)) {
			victim = session;
		}
	}
	return victim;
}

/* A free session, else the one idle for longest, else a victim's. */
static struct dronecan_session *take_session(struct dronecan_transport *self, uint8_t priority)
{
	struct dronecan_session *idle = NULL;

	for (size_t i = 0; i < DRONECAN_RX_SESSIONS; i++) {
		struct dronecan_session *session = &self->sessions[i];

		if (!session->used) {
			return session;
		}
		if (!session->under_way &&
		    (idle == NULL || session->started_us < idle->started_us)) {
			idle = session;
		}
	}
	if (idle != NULL) {
		return idle;
	}
	struct dronecan_session *victim = find_victim(self, priority, false);

	if (victim != NULL) {
		self->stats.rx_evicted++;
		release_buffer(self, victim);
	}
	return victim;
}

static bool take_buffer(struct dronecan_transport *self, struct dronecan_session *session)
{
	for (size_t i = 0; i < DRONECAN_RX_BUFFERS; i++) {
		if (!self->buffer_taken[i]) {
			self->buffer_taken[i] = true;
			session->buffer = (int8_t)i;
			return true;
		}
	}
	struct dronecan_session *victim = find_victim(self, session->priority, true);

	if (victim == NULL) {
		return false;
	}
	self->stats.rx_evicted++;
	session->buffer = victim->buffer;
	victim->buffer = NONE;
	finish(self, victim);
	return true;
}

static unsigned int forward_distance(uint8_t from, uint8_t to)
{
	return ((unsigned int)to - from) & DRONECAN_TRANSFER_ID_MASK;
}

/* Whether the frame continues what the session expects; else counts why not. */
static bool is_expected(struct dronecan_transport *self, const struct dronecan_session *session,
                        const struct header *header, bool fd)
{
	if (header->id != session->next_id) {
		if (forward_distance(header->id, session->next_id) == 1u) {
			self->stats.rx_repeated++;
		} else {
			self->stats.rx_wrong_id++;
		}
		return false;
	}
	if (!session->under_way) {
		if (!header->start) {
			self->stats.rx_without_start++;
		}
		return header->start;
	}
	if (header->toggle != session->toggle || header->start || fd != session->fd) {
		self->stats.rx_wrong_toggle++;
		return false;
	}
	return true;
}

/*
 * Brings the session to where this frame may be taken, or says that it may not. A start with an id
 * that is neither the expected one nor the last one means that transfers were lost: begin anew.
 */
static bool synchronise(struct dronecan_transport *self, struct dronecan_session *session,
                        int64_t now_us, const struct header *header, bool fd)
{
	const bool stale = now_us - session->started_us > DRONECAN_TRANSFER_TIMEOUT_US;
	const bool jump = header->start && forward_distance(header->id, session->next_id) > 1u;

	if (stale || jump) {
		if (session->under_way) {
			self->stats.rx_incomplete++;
			finish(self, session);
		}
		if (!header->start) {
			self->stats.rx_without_start++;
			return false;
		}
		session->next_id = header->id;
	}
	return is_expected(self, session, header, fd);
}

static void fill(struct dronecan_transfer *out, const struct dronecan_transport *self,
                 int subscription, const struct header *header, bool fd)
{
	out->type = self->subscriptions[subscription].type;
	out->kind = header->kind;
	out->source = header->source;
	out->target = header->target;
	out->priority = header->priority;
	out->id = header->id;
	out->fd = fd;
}

/* Classic: a payload longer than its type is no such type. FD pads. */
static bool fits(const struct dronecan_transfer *transfer, size_t size)
{
	const struct dronecan_type *type = transfer->type;
	const size_t limit =
		(transfer->kind == DRONECAN_RESPONSE) ? type->max_response_size : type->max_size;

	return size <= limit + (transfer->fd ? DRONECAN_FRAME_SIZE_FD : 0u);
}

static bool begin(struct dronecan_transport *self, struct dronecan_session *session, int64_t now_us,
                  const struct header *header, const struct dronecan_frame *frame)
{
	expire(self, now_us);
	session->priority = header->priority;
	if (!take_buffer(self, session)) {
		self->stats.rx_no_room++;
		/* Its further frames are no news. */
		session->next_id = (header->id + 1u) & DRONECAN_TRANSFER_ID_MASK;
		session->started_us = now_us;
		return false;
	}
	session->under_way = true;
	session->started_us = now_us;
	session->toggle = false;
	session->fd = frame->fd;
	session->size = 0;
	session->crc = self->subscriptions[session->subscription].type->crc_seed;
	session->wire_crc = (uint16_t)(frame->data[0] | ((unsigned int)frame->data[1] << 8));
	return true;
}

/* One frame of several. True: the transfer is whole. */
static bool append(struct dronecan_transport *self, struct dronecan_session *session,
                   const struct header *header, const struct dronecan_frame *frame,
                   struct dronecan_transfer *out)
{
	const uint8_t *part = &frame->data[header->start ? CRC_SIZE : 0u];
	const size_t count = frame->size - 1u - (header->start ? CRC_SIZE : 0u);
	const size_t room = DRONECAN_RX_PAYLOAD_MAX - ((session->size < DRONECAN_RX_PAYLOAD_MAX)
	                                                       ? session->size
	                                                       : DRONECAN_RX_PAYLOAD_MAX);

	fill(out, self, session->subscription, header, frame->fd);
	/* What is beyond the buffer can only be FD's padding: it counts for the CRC alone. */
	memcpy(&self->buffers[session->buffer][DRONECAN_RX_PAYLOAD_MAX - room], part,
	       (count < room) ? count : room);
	session->size = (uint16_t)(session->size + count);
	session->crc = dronecan_crc(session->crc, part, count);
	session->toggle = !session->toggle;
	if (!fits(out, session->size)) {
		self->stats.rx_too_long++;
		finish(self, session);
		return false;
	}
	if (!header->end) {
		return false;
	}
	if (session->crc != session->wire_crc) {
		self->stats.rx_wrong_crc++;
		finish(self, session);
		return false;
	}
	out->data = self->buffers[session->buffer];
	out->size =
		(session->size < DRONECAN_RX_PAYLOAD_MAX) ? session->size : DRONECAN_RX_PAYLOAD_MAX;
	self->delivered = session->buffer;
	session->buffer = NONE;
	finish(self, session);
	return true;
}

/* A transfer in one frame. */
static bool deliver(struct dronecan_transport *self, int subscription, const struct header *header,
                    const struct dronecan_frame *frame, struct dronecan_transfer *out)
{
	fill(out, self, subscription, header, frame->fd);
	out->data = frame->data;
	out->size = frame->size - 1u;
	if (!fits(out, out->size)) {
		self->stats.rx_too_long++;
		return false;
	}
	return true;
}

/* False also when the first frame says that the transfer concerns somebody else. */
static bool concerns_us(const struct dronecan_transport *self, int subscription,
                        const struct header *header, const struct dronecan_frame *frame)
{
	const size_t skip = header->end ? 0u : CRC_SIZE;
	const struct dronecan_subscription *to = &self->subscriptions[subscription];

	return to->is_ours == NULL ||
	       to->is_ours(self->node_id, &frame->data[skip], frame->size - 1u - skip);
}

/* A start that concerns somebody else takes nothing, but its id counts. */
static void pass_by(struct dronecan_transport *self, struct dronecan_session *session,
                    int64_t now_us, const struct header *header)
{
	if (session == NULL) {
		return;
	}
	if (session->under_way) {
		self->stats.rx_incomplete++;
		finish(self, session);
	}
	session->started_us = now_us;
	session->next_id = (header->id + 1u) & DRONECAN_TRANSFER_ID_MASK;
}

/* The session of a start that is new here; NULL: no room. */
static struct dronecan_session *open_session(struct dronecan_transport *self, int64_t now_us,
                                             int subscription, const struct header *header)
{
	expire(self, now_us);
	struct dronecan_session *session = take_session(self, header->priority);

	if (session == NULL) {
		self->stats.rx_no_room++;
		return NULL;
	}
	*session = (struct dronecan_session){
		.started_us = now_us,
		.subscription = (uint8_t)subscription,
		.source = header->source,
		.priority = header->priority,
		.next_id = header->id,
		.buffer = NONE,
		.used = true,
	};
	return session;
}

/* A frame of a subscribed type from a node with an id. */
static bool receive(struct dronecan_transport *self, int64_t now_us, int subscription,
                    const struct header *header, const struct dronecan_frame *frame,
                    struct dronecan_transfer *out)
{
	struct dronecan_session *session = find_session(self, subscription, header->source);
	const bool filtered = self->subscriptions[subscription].is_ours != NULL;

	if (session == NULL && !header->start) {
		/* With a filter, most often the rest of somebody else's. */
		self->stats.rx_without_start += filtered ? 0u : 1u;
		return false;
	}
	if (header->start && !concerns_us(self, subscription, header, frame)) {
		pass_by(self, session, now_us, header);
		return false;
	}
	if (filtered && !header->start && !session->under_way) {
		return false;
	}
	if (session == NULL) {
		session = open_session(self, now_us, subscription, header);
		if (session == NULL) {
			return false;
		}
	} else if (!synchronise(self, session, now_us, header, frame->fd)) {
		return false;
	}
	if (header->start && header->end) {
		session->started_us = now_us;
		session->priority = header->priority;
		finish(self, session);
		return deliver(self, subscription, header, frame, out);
	}
	if (header->start && !begin(self, session, now_us, header, frame)) {
		return false;
	}
	return append(self, session, header, frame, out);
}

bool dronecan_transport_receive(struct dronecan_transport *self, int64_t now_us,
                                const struct dronecan_frame *frame, struct dronecan_transfer *out)
{
	struct header header;

	PHAROS_ASSERT(now_us >= 0 && now_us <= TIME_MAX_US);
	if (self->delivered != NONE) {
		self->buffer_taken[self->delivered] = false;
		self->delivered = NONE;
	}
	self->stats.frames_rx++;
	if (!parse(frame, &header)) {
		self->stats.rx_malformed++;
		return false;
	}
	const bool is_own_id = header.source != 0 && header.source == self->node_id;

	self->stats.rx_own_id += is_own_id ? 1u : 0u;
	if (header.kind != DRONECAN_MESSAGE && header.target != self->node_id) {
		return false;
	}
	const int subscription = find_subscription(self, &header, is_own_id);

	if (subscription == NONE) {
		return false;
	}
	const bool whole = (header.source == 0)
	                           ? deliver(self, subscription, &header, frame, out)
	                           : receive(self, now_us, subscription, &header, frame, out);

	self->stats.transfers_rx += whole ? 1u : 0u;
	return whole;
}

uint64_t dronecan_transport_rx_errors(const struct dronecan_transport *self)
{
	const struct dronecan_transport_stats *stats = &self->stats;

	return (uint64_t)stats->rx_malformed + stats->rx_own_id + stats->rx_without_start +
	       stats->rx_repeated + stats->rx_wrong_toggle + stats->rx_wrong_id +
	       stats->rx_incomplete + stats->rx_wrong_crc + stats->rx_too_long + stats->rx_evicted +
	       stats->rx_no_room;
}
