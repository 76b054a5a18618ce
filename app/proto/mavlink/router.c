/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/router.h"

#include "core/limits.h"
#include "proto/mavlink/dialect.h"
#include "proto/mavlink/internal.h"

#include <string.h>

void mavlink_router_set(struct mavlink_router *self, bool on)
{
	self->on = on;
	self->count = 0;
	memset(&self->seen, 0, sizeof(self->seen));
}

/* --- what went on already --------------------------------------------------------------------- */

/* FNV-1a, over header, payload, checksum and signature. */
static uint32_t hash_of(const struct mavlink_frame *frame)
{
	uint32_t hash = 2166136261u;

	for (uint16_t i = 0; i < frame->length; i++) {
		hash = (hash ^ frame->bytes[i]) * 16777619u;
	}
	return hash;
}

/* Nothing kept is older than the newest by more than MAVLINK_SEEN_US: 16 bits of ms tell. */
static void seen_expire(struct mavlink_seen_frames *self, int64_t now_us)
{
	const uint16_t now_ms = (uint16_t)(now_us / US_PER_MS);

	if (now_us - self->newest_us >= MAVLINK_SEEN_US) {
		self->count = 0;
		memset(self->of_link, 0, sizeof(self->of_link));
		return;
	}
	while (self->count > 0) {
		const struct mavlink_seen *const oldest = &self->frames[self->first];

		if ((uint16_t)(now_ms - oldest->at_ms) < MAVLINK_SEEN_US / US_PER_MS) {
			return;
		}
		self->of_link[oldest->link]--;
		self->first = (uint16_t)((self->first + 1) % MAVLINK_SEEN_MAX);
		self->count--;
	}
}

static bool seen_has(const struct mavlink_seen_frames *self, uint32_t hash)
{
	for (uint16_t i = 0; i < self->count; i++) {
		if (self->frames[(self->first + i) % MAVLINK_SEEN_MAX].hash == hash) {
			return true;
		}
	}
	return false;
}

static bool seen_has_room(const struct mavlink_seen_frames *self, uint8_t link)
{
	return self->count < MAVLINK_SEEN_MAX && self->of_link[link] < MAVLINK_SEEN_LINK_MAX;
}

static void seen_add(struct mavlink_seen_frames *self, int64_t now_us, uint8_t link, uint32_t hash)
{
	self->frames[(self->first + self->count) % MAVLINK_SEEN_MAX] = (struct mavlink_seen){
		.hash = hash, .at_ms = (uint16_t)(now_us / US_PER_MS), .link = link};
	self->count++;
	self->of_link[link]++;
	self->newest_us = now_us;
}

/* --- who is where ----------------------------------------------------------------------------- */

static bool is_silent(const struct mavlink_route *route, int64_t now_us)
{
	return now_us - route->heard_us >= MAVLINK_ROUTE_SILENCE_US;
}

static struct mavlink_route *route_find(struct mavlink_router *self,
                                        const struct mavlink_frame *frame)
{
	for (uint8_t i = 0; i < self->count; i++) {
		struct mavlink_route *const route = &self->routes[i];

		if (route->system_id == frame->system_id &&
		    route->component_id == frame->component_id) {
			return route;
		}
	}
	return NULL;
}

static uint8_t rank_of(const struct mavlink_route *route, int64_t now_us)
{
	return route->rank == MAVLINK_ROUTE_TRUSTED &&
	                       now_us - route->heard_us >= MAVLINK_ROUTE_TRUST_US
	               ? MAVLINK_ROUTE_VERIFIED
	               : route->rank;
}

/* A free place, or one that gives way to a sender of that rank; NULL: none. */
static struct mavlink_route *route_place(struct mavlink_router *self, int64_t now_us, uint8_t rank)
{
	struct mavlink_route *found = NULL;

	if (self->count < MAVLINK_ROUTES_MAX) {
		return &self->routes[self->count++];
	}
	for (uint8_t i = 0; i < self->count; i++) {
		struct mavlink_route *const route = &self->routes[i];

		const uint8_t its = rank_of(route, now_us);

		if (its > rank || (its == rank && !is_silent(route, now_us))) {
			continue;
		}
		if (found == NULL || its < rank_of(found, now_us) ||
		    (its == rank_of(found, now_us) && route->heard_us < found->heard_us)) {
			found = route;
		}
	}
	return found;
}

/* The sender's route; the frame may be the first, or the first after a silence. NULL: no room. */
static const struct mavlink_route *route_learn(struct mavlink_router *self, int64_t now_us,
                                               const struct mavlink_passage *passage, bool verified)
{
	const uint8_t rank = passage->is_trusted ? MAVLINK_ROUTE_TRUSTED
	                     : verified          ? MAVLINK_ROUTE_VERIFIED
	                                         : MAVLINK_ROUTE_UNVERIFIED;
	const struct mavlink_frame *const frame = passage->frame;
	struct mavlink_route *route = route_find(self, frame);

	if (route != NULL && route->link != passage->link && !is_silent(route, now_us)) {
		return route;
	}
	if (route == NULL) {
		route = route_place(self, now_us, rank);
		if (route == NULL) {
			return NULL;
		}
		route->rank = MAVLINK_ROUTE_UNVERIFIED;
	}
	*route = (struct mavlink_route){
		.heard_us = now_us,
		.system_id = frame->system_id,
		.component_id = frame->component_id,
		.link = passage->link,
		.rank = rank > route->rank ? rank : route->rank,
	};
	return route;
}

/* Where the target was heard: one component, or any of its system. */
static uint8_t links_of(const struct mavlink_router *self, struct mavlink_target target)
{
	uint8_t links = 0;

	for (uint8_t i = 0; i < self->count; i++) {
		const struct mavlink_route *const route = &self->routes[i];

		if (route->system_id == target.system_id &&
		    (target.component_id == 0 || target.component_id == route->component_id)) {
			links |= (uint8_t)(1u << route->link);
		}
	}
	return links;
}

/* false: it went on before, or too much does; counted. */
static bool pass_once(struct mavlink_router *self, int64_t now_us,
                      const struct mavlink_passage *passage)
{
	const uint32_t hash = hash_of(passage->frame);

	seen_expire(&self->seen, now_us);
	if (seen_has(&self->seen, hash)) {
		self->stats.circled++;
		return false;
	}
	if (!seen_has_room(&self->seen, passage->link)) {
		self->stats.flooded++;
		return false;
	}
	seen_add(&self->seen, now_us, passage->link, hash);
	return true;
}

uint8_t mavlink_router_take(struct mavlink_router *self, int64_t now_us,
                            const struct mavlink_passage *passage)
{
	const struct mavlink_frame *const frame = passage->frame;
	uint8_t crc_extra;
	uint8_t links = passage->links;

	if (!self->on) {
		return 0;
	}

	const bool verified = mavlink_crc_extra(frame->message_id, &crc_extra);
	const struct mavlink_route *const route =
		passage->makes_route ? route_learn(self, now_us, passage, verified)
				     : route_find(self, frame);

	if (route == NULL && passage->makes_route) {
		self->stats.no_room++;
		return 0;
	}
	if (route != NULL && route->link != passage->link) {
		self->stats.circled++;
		return 0;
	}
	if (passage->is_ours || frame->message_id == MAVLINK_MSG_ID_SETUP_SIGNING ||
	    mavlink_is_link_report(frame->message_id)) {
		return 0;
	}
	if (passage->target.system_id != 0) {
		links &= links_of(self, passage->target);
	}
	links &= (uint8_t) ~(1u << passage->link);
	if (links == 0) {
		self->stats.unreachable += passage->target.system_id != 0;
		return 0;
	}
	if (!pass_once(self, now_us, passage)) {
		return 0;
	}
	self->stats.forwarded++;
	self->stats.opaque += !verified;
	return links;
}

void mavlink_router_link_down(struct mavlink_router *self, uint8_t link)
{
	uint8_t kept = 0;

	for (uint8_t i = 0; i < self->count; i++) {
		if (self->routes[i].link != link) {
			self->routes[kept++] = self->routes[i];
		}
	}
	self->count = kept;
}
