/* SPDX-License-Identifier: Apache-2.0 */
#include "threads/tunnel_link.h"

#include <string.h>

#include <zephyr/kernel.h>

#include "threads/clock.h"
#include "threads/limits.h"

/* Bytes that wait in a tunnel, up to which others' frames go there. */
#define TUNNEL_FORWARD_MAX (DRONECAN_TUNNEL_BUFFER / 2)

_Static_assert(TUNNEL_FORWARD_MAX >= MAVLINK_FRAME_MAX, "a forwarded frame fits");
_Static_assert(TUNNEL_LINKS_MAX == DRONECAN_TUNNEL_CHANNELS, "a link for each channel");

struct tunnel_link {
	bool is_up;     /* somebody is there */
	bool is_opened; /* somebody new: to be told */
	bool is_closed; /* to be told */
	bool is_silent; /* what is unfinished is perhaps no frame */
	int64_t heard_us;
	struct mavlink_framer framer;
	struct link_stats stats;
};

static struct dronecan_tunnel *tunnel; /* NULL: no CAN */
static struct tunnel_link links[TUNNEL_LINKS_MAX];
static uint32_t links_up; /* how many; none: nothing to look after */
static bool written;

/* What the framer of a channel has not been given yet. */
static struct {
	const uint8_t *bytes;
	size_t size;
	uint8_t channel;
} rest;

void tunnel_links_init(struct dronecan_tunnel *its)
{
	tunnel = its;
	memset(links, 0, sizeof(links));
	links_up = 0;
	rest.size = 0;
	written = false;
	for (size_t i = 0; i < TUNNEL_LINKS_MAX; i++) {
		mavlink_framer_init(&links[i].framer);
	}
}

/* --- receiving -------------------------------------------------------------------------------- */

/* Somebody else may have been here before. */
static void open(struct tunnel_link *link)
{
	const struct mavlink_framer_stats kept = link->framer.stats;

	mavlink_framer_init(&link->framer);
	link->framer.stats = kept;
	links_up += link->is_up ? 0 : 1;
	link->is_up = true;
	link->is_opened = true;
}

void tunnel_links_put(const struct dronecan_tunnel_received *received)
{
	struct tunnel_link *const link = &links[received->channel];

	if (received->opened) {
		open(link);
	}
	if (received->size > 0) {
		link->heard_us = clock_now_us();
	}
	link->framer.opaque = link_is_opaque();
	link->stats.rx_bytes += (uint32_t)received->size;
	rest.bytes = received->data;
	rest.size = received->size;
	rest.channel = received->channel;
}

/* The next frame of a channel, from what has come or what silence has made one. */
static bool next_frame(uint8_t channel, struct mavlink_frame *frame)
{
	struct tunnel_link *const link = &links[channel];

	while (!mavlink_framer_next(&link->framer, frame)) {
		if (rest.size > 0 && rest.channel == channel) {
			const size_t used =
				mavlink_framer_write(&link->framer, rest.bytes, rest.size);

			rest.bytes += used;
			rest.size -= used;
		} else if (!link->is_silent || !mavlink_framer_idle(&link->framer, frame)) {
			link->is_silent = false;
			return false;
		} else {
			break;
		}
	}
	link->stats.rx_frames++;
	return true;
}

static bool next_of(uint8_t channel, struct tunnel_event *event)
{
	struct tunnel_link *const link = &links[channel];

	event->link = TUNNEL_LINK0 + channel;
	if (link->is_closed) {
		link->is_closed = false;
		links_up--;
		event->kind = TUNNEL_DOWN;
		return true;
	}
	if (link->is_opened) {
		link->is_opened = false;
		event->kind = TUNNEL_UP;
		return true;
	}
	event->kind = TUNNEL_FRAME;
	return (link->is_silent || rest.size > 0) && next_frame(channel, &event->frame);
}

bool tunnel_links_next(struct tunnel_event *event)
{
	for (uint8_t channel = 0; links_up > 0 && channel < TUNNEL_LINKS_MAX; channel++) {
		if (next_of(channel, event)) {
			return true;
		}
	}
	return false;
}

/* --- time ------------------------------------------------------------------------------------- */

void tunnel_links_step(void)
{
	const int64_t now_us = clock_now_us();

	for (uint8_t channel = 0; links_up > 0 && channel < TUNNEL_LINKS_MAX; channel++) {
		struct tunnel_link *const link = &links[channel];

		if (link->is_up && !tunnel->channels[channel].open) {
			link->is_up = false;
			link->is_closed = true;
		}
		link->is_silent = mavlink_framer_pending(&link->framer) &&
		                  now_us - link->heard_us >= MAVLINK_FRAMER_IDLE_US;
	}
}

int64_t tunnel_links_deadline_us(void)
{
	int64_t deadline_us = TIME_NEVER_US;

	for (size_t i = 0; links_up > 0 && i < TUNNEL_LINKS_MAX; i++) {
		const int64_t idle_us = links[i].heard_us + MAVLINK_FRAMER_IDLE_US;

		/* what is still unfinished after that stays so until more comes */
		if (mavlink_framer_pending(&links[i].framer) && idle_us > clock_now_us()) {
			deadline_us = MIN(deadline_us, idle_us);
		}
	}
	return deadline_us;
}

/* --- sending ---------------------------------------------------------------------------------- */

bool tunnel_links_written(void)
{
	const bool any = written;

	written = false;
	return any;
}

/* At most `most` bytes then wait. 1: written. 0: nobody is there. -ENOBUFS. */
static int write(uint8_t channel, size_t most, const uint8_t *frame, size_t length)
{
	struct link_stats *const stats = &links[channel].stats;
	const int64_t now_us = clock_now_us();

	if (tunnel == NULL || !dronecan_tunnel_is_open(tunnel, now_us, channel)) {
		return 0;
	}
	if (dronecan_tunnel_waiting(tunnel, channel) + length > most ||
	    !dronecan_tunnel_write(tunnel, now_us, channel, frame, length)) {
		return -ENOBUFS;
	}
	written = true;
	stats->tx_frames++;
	stats->tx_bytes += (uint32_t)length;
	return 1;
}

int tunnel_link_send(uint8_t channel, const uint8_t *frame, size_t length)
{
	const int result = write(channel, SIZE_MAX, frame, length);

	links[channel].stats.tx_dropped += result < 0 ? 1 : 0;
	return MIN(result, 0);
}

int tunnel_link_forward(uint8_t channel, const uint8_t *frame, size_t length)
{
	const int result = write(channel, TUNNEL_FORWARD_MAX, frame, length);

	links[channel].stats.forward_dropped += result < 0 ? 1 : 0;
	links[channel].stats.forwarded += result > 0 ? 1 : 0;
	return MIN(result, 0);
}

int tunnel_link_stats_get(uint8_t channel, struct link_stats *stats)
{
	const unsigned int key = irq_lock();

	*stats = links[channel].stats;
	stats->framing = link_framing_of(&links[channel].framer.stats);
	irq_unlock(key);
	return tunnel != NULL ? 0 : -ENODEV;
}
