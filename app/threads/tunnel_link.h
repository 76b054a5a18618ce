/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A channel of DroneCAN's tunnel as a link, like a UART: what the channel brings becomes frames,
 * and frames sent become what the channel takes. It comes when somebody opens it, and goes when
 * nobody has asked for a while. A build without CAN has none.
 *
 * Context: the command thread, unless said otherwise.
 */
#ifndef PHAROS_THREADS_TUNNEL_LINK_H
#define PHAROS_THREADS_TUNNEL_LINK_H

#include <errno.h>
#include <stdbool.h>
#include <stdint.h>

#include "core/limits.h"
#include "proto/dronecan/tunnel.h"
#include "proto/mavlink/framer.h"
#include "threads/link.h"

enum tunnel_event_kind {
	TUNNEL_UP, /* perhaps somebody else's than before */
	TUNNEL_DOWN,
	TUNNEL_FRAME, /* frame, until the next call */
};

struct tunnel_event {
	enum tunnel_event_kind kind;
	uint8_t link;
	struct mavlink_frame frame;
};

#ifdef CONFIG_CAN

/* tunnel: the channels, kept by reference. Before anything else. */
void tunnel_links_init(struct dronecan_tunnel *tunnel);

/* What a channel has brought; its data holds until tunnel_links_next() returns false. */
void tunnel_links_put(const struct dronecan_tunnel_received *received);

/* What has come of it; false: nothing more. */
bool tunnel_links_next(struct tunnel_event *event);

/* Looks for channels that have closed, and those that are silent amid a frame, which perhaps is
 * none. Then tunnel_links_next().
 */
void tunnel_links_step(void);
int64_t tunnel_links_deadline_us(void);

/* Whether bytes have been written since the last call. */
bool tunnel_links_written(void);

/* As links_send(), links_forward() and links_stats_get() (any thread) of the link TUNNEL_LINK0 +
 * channel.
 */
int tunnel_link_send(uint8_t channel, const uint8_t *frame, size_t length);
int tunnel_link_forward(uint8_t channel, const uint8_t *frame, size_t length);
int tunnel_link_stats_get(uint8_t channel, struct link_stats *stats);

#else

static inline bool tunnel_links_next(struct tunnel_event *event)
{
	return false;
}

static inline void tunnel_links_step(void)
{
}

static inline int64_t tunnel_links_deadline_us(void)
{
	return TIME_NEVER_US;
}

static inline int tunnel_link_send(uint8_t channel, const uint8_t *frame, size_t length)
{
	return -ENODEV;
}

static inline int tunnel_link_forward(uint8_t channel, const uint8_t *frame, size_t length)
{
	return -ENODEV;
}

static inline int tunnel_link_stats_get(uint8_t channel, struct link_stats *stats)
{
	return -ENODEV;
}

#endif

#endif
