/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Router: which links a received frame goes on to, unchanged. Sans-IO; whoever asks sends.
 *
 * Broadcasts, and messages that no dialect has, go to every other link; addressed ones only where
 * their target was heard, if that is another link. What is for one of our components, and
 * SETUP_SIGNING, goes nowhere. Signatures are the business of those that the frames reach.
 *
 * Each sender has the link that it was first heard on, until it has been silent there for
 * MAVLINK_ROUTE_SILENCE_US. Its frames that come in elsewhere have gone in a circle (two links into
 * one network, a neighbour that echoes) and go no further; so nothing goes round for ever.
 *
 * A full table reuses the place of a sender that is silent, or of which only unverified frames
 * came; the longest silent first. If there is none, the new sender's frames go nowhere.
 *
 * With a key, only what is rightly signed makes a route or keeps one: else anybody could draw away
 * what is meant for another. What is not goes on all the same, for others to judge.
 *
 * Context: the thread that owns it. Spec: mavlink.io/en/guide/routing.html.
 */
#ifndef PHAROS_PROTO_MAVLINK_ROUTER_H
#define PHAROS_PROTO_MAVLINK_ROUTER_H

#include "proto/mavlink/frame.h"

#include <stdbool.h>
#include <stdint.h>

struct mavlink_route {
	int64_t heard_us; /* on link */
	uint8_t system_id;
	uint8_t component_id;
	uint8_t link;
	bool verified; /* a frame of a known message has come */
};

struct mavlink_router_stats {
	uint32_t forwarded;   /* frames that went on, to one link or more */
	uint32_t opaque;      /* of these, of a message that no dialect has */
	uint32_t unreachable; /* addressed to someone not heard on another link */
	uint32_t circled;
	uint32_t no_room;
};

struct mavlink_router {
	struct mavlink_router_stats stats;
	bool on;
	uint8_t count;
	struct mavlink_route routes[MAVLINK_ROUTES_MAX];
};

/* A received frame, and what the endpoint knows about it. */
struct mavlink_passage {
	const struct mavlink_frame *frame; /* not of one of our components */
	struct mavlink_target target;
	uint8_t link;     /* that it came on */
	uint8_t links;    /* bit per link that is up */
	bool is_ours;     /* addressed to one of our components */
	bool makes_route; /* else its sender might be anybody: it goes on, and nothing is learned */
};

/* off: nothing is forwarded, and what was known is forgotten. */
void mavlink_router_set(struct mavlink_router *self, bool on);

/* Bit per link that the frame is to go to. */
uint8_t mavlink_router_take(struct mavlink_router *self, int64_t now_us,
                            const struct mavlink_passage *passage);

/* A link goes, and whoever was there. */
void mavlink_router_link_down(struct mavlink_router *self, uint8_t link);

#endif
