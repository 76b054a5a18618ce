/* SPDX-License-Identifier: Apache-2.0 */
#include "proto/mavlink/router.h"

#include "proto/mavlink/dialect.h"

#include <string.h>

void mavlink_router_set(struct mavlink_router *self, bool on)
{
	self->on = on;
	self->count = 0;
}

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

/* A free place, or one that may be reused; NULL: none. */
static struct mavlink_route *route_place(struct mavlink_router *self, int64_t now_us)
{
	struct mavlink_route *oldest = NULL;

	if (self->count < MAVLINK_ROUTES_MAX) {
		return &self->routes[self->count++];
	}
	for (uint8_t i = 0; i < self->count; i++) {
		struct mavlink_route *const route = &self->routes[i];

		if ((!route->verified || is_silent(route, now_us)) &&
		    (oldest == NULL || route->heard_us < oldest->heard_us)) {
			oldest = route;
		}
	}
	return oldest;
}

/* The sender's route; the frame may be the first, or the first after a silence. NULL: no room. */
static const struct mavlink_route *route_learn(struct mavlink_router *self, int64_t now_us,
                                               const struct mavlink_passage *passage, bool verified)
{
	const struct mavlink_frame *const frame = passage->frame;
	struct mavlink_route *route = route_find(self, frame);

	if (route != NULL && route->link != passage->link && !is_silent(route, now_us)) {
		return route;
	}
	if (route == NULL) {
		route = route_place(self, now_us);
		if (route == NULL) {
			return NULL;
		}
		route->verified = false;
	}
	*route = (struct mavlink_route){
		.heard_us = now_us,
		.system_id = frame->system_id,
		.component_id = frame->component_id,
		.link = passage->link,
		.verified = verified || route->verified,
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
	if (passage->is_ours || frame->message_id == MAVLINK_MSG_ID_SETUP_SIGNING) {
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
