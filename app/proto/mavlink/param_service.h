/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The device's parameters over MAVLink: PARAM_REQUEST_READ by index and by name,
 * PARAM_REQUEST_LIST, PARAM_SET. Ground stations keep parameters by component, and ask each that
 * they hear until it has told some. So the table is shared out, and each share is a list of its
 * own, with its own indices: the gimbal's component has the gimbal's group, the illuminator all
 * else, and with it what decides whether there is a gimbal, GMB_ENABLE and GMB_COMPID.
 *
 * Every value is a REAL32 of the parameter's unit, which is the one type that every ground station
 * reads alike; integers bytewise are read so beside one autopilot only. A set is taken from REAL32,
 * and from any integer type of up to 32 bits, bytewise: that number of the same unit. A value
 * between two steps becomes the nearer one (core/param_units.h). No other type is taken.
 *
 * Every set of a parameter that exists is answered by a PARAM_VALUE with what is now in force. A
 * refused one by a PARAM_ERROR before it, where the link's version can carry it. A parameter that
 * does not exist is answered by a PARAM_ERROR alone, and only when the component itself was asked:
 * what is for every component may be another's.
 *
 * Of each component, a link has a set of values yet to be sent, bulk by mavlink_send_bulk. A list
 * puts all into it; so several lists at a time are one, and a value is the one in force when it
 * goes. Changes by others come to it as well, so that ground stations stay up to date.
 *
 * Context: the endpoint's. Spec: mavlink.io/en/services/parameter.html; common.xml 20…23, 345.
 */
#ifndef PHAROS_PROTO_MAVLINK_PARAM_SERVICE_H
#define PHAROS_PROTO_MAVLINK_PARAM_SERVICE_H

#include "core/device.h"
#include "proto/mavlink/endpoint.h"

struct mavlink_params_stats {
	uint32_t sets;
	uint32_t refused; /* of these */
	uint32_t unknown; /* reads and sets of what does not exist */
};

enum mavlink_params_share {
	MAVLINK_PARAMS_LIGHT,
	MAVLINK_PARAMS_GIMBAL,
};

/* Is the parameter (asserted to be one) in the share? Each is in one. */
bool mavlink_params_is(enum mavlink_params_share share, uint32_t index);

/* How many are. */
uint16_t mavlink_params_count(enum mavlink_params_share share);

struct mavlink_params {
	struct pharos_device *device;
	enum mavlink_params_share share;
	int64_t due_us;
	uint32_t answered; /* a change that a link's answer has told; PARAM_COUNT: none */
	uint8_t answered_link;
	struct param_set waiting[MAVLINK_LINKS_MAX];
	uint32_t next[MAVLINK_LINKS_MAX]; /* parameter to look from */
	struct mavlink_params_stats stats;
};

/* device outlives the service. */
void mavlink_params_init(struct mavlink_params *self, struct pharos_device *device,
                         enum mavlink_params_share share);

/* Receivers of 20, 21 and 23 for a component whose profile has params. */
void mavlink_params_request_read(const struct mavlink_context *context,
                                 const struct mavlink_frame *frame);
void mavlink_params_request_list(const struct mavlink_context *context,
                                 const struct mavlink_frame *frame);
void mavlink_params_set(const struct mavlink_context *context, const struct mavlink_frame *frame);

/* Those of these that are its own are to be told on the links (bit per link). */
void mavlink_params_changed(struct mavlink_params *self, int64_t now_us, uint8_t links,
                            const struct param_set *changed);

/* The device has changed these: to be told on every link but where the answer has done that. */
void mavlink_params_tell(struct mavlink_params *self, const struct mavlink_context *context,
                         const struct param_set *changed);

/* As the hooks of a profile. */
bool mavlink_params_step(struct mavlink_params *self, const struct mavlink_context *context);
int64_t mavlink_params_deadline_us(const struct mavlink_params *self);

#endif
