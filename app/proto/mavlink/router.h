/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Router: which links a received frame goes on to, unchanged. Sans-IO; whoever asks sends.
 *
 * Broadcasts, and messages that no dialect has, go to every other link; addressed ones only where
 * their target was heard, if that is another link. What is for one of our components, and
 * SETUP_SIGNING, goes nowhere. Signatures are the business of those that the frames reach.
 *
 * RADIO_STATUS and RADIO are about the one link that they come on, and stay there.
 *
 * Nothing goes round for ever, whatever the network: bytes that were forwarded are not forwarded
 * again within MAVLINK_SEEN_US, on whatever link they come back; and there is an end to how many
 * frames are forwarded within that time, over all and from one link. Besides, each sender has the
 * link that it was first heard on, until it has been silent there for MAVLINK_ROUTE_SILENCE_US; its
 * frames that come in elsewhere (two links into one network, a neighbour that echoes) go no
 * further.
 *
 * Senders rank: of whom only unverified frames came; of whom verified ones came; who has commanded
 * one of our components, or is signed. In a full table a new sender takes the place of one that
 * ranks lower, or ranks the same and is silent; the longest silent of the lowest first. If there is
 * none, its frames go nowhere.
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

enum mavlink_route_rank {
	MAVLINK_ROUTE_UNVERIFIED,
	MAVLINK_ROUTE_VERIFIED, /* a frame of a known message has come */
	MAVLINK_ROUTE_TRUSTED,  /* has commanded us, or is signed */
};

struct mavlink_route {
	int64_t heard_us; /* on link */
	uint8_t system_id;
	uint8_t component_id;
	uint8_t link;
	uint8_t rank; /* mavlink_route_rank */
};

/* A frame that was forwarded. */
struct mavlink_seen {
	uint32_t hash;
	uint16_t at_ms; /* the low bits */
	uint8_t link;   /* that it came on */
};

/* Those of the last MAVLINK_SEEN_US, oldest first. */
struct mavlink_seen_frames {
	int64_t newest_us;
	uint16_t first;
	uint16_t count;
	uint16_t of_link[MAVLINK_LINKS_MAX];
	struct mavlink_seen frames[MAVLINK_SEEN_MAX];
};

struct mavlink_router_stats {
	uint32_t forwarded;   /* frames that went on, to one link or more */
	uint32_t opaque;      /* of these, of a message that no dialect has */
	uint32_t unreachable; /* addressed to someone not heard on another link */
	uint32_t circled;
	uint32_t no_room;
	uint32_t flooded; /* too many at a time */
};

struct mavlink_router {
	struct mavlink_router_stats stats;
	bool on;
	uint8_t count;
	struct mavlink_route routes[MAVLINK_ROUTES_MAX];
	struct mavlink_seen_frames seen;
};

/* A received frame, and what the endpoint knows about it. */
struct mavlink_passage {
	const struct mavlink_frame *frame; /* not of one of our components */
	struct mavlink_target target;
	uint8_t link;     /* that it came on */
	uint8_t links;    /* bit per link that is up */
	bool is_ours;     /* addressed to one of our components */
	bool is_trusted;  /* signed, or a command to one of our components */
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
