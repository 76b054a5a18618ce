/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the gimbal component hears of its vehicle, and asks it for. The vehicle is the autopilot
 * (component 1) of the device's own system id, whichever way that was found.
 *
 * While its heartbeats come, and GMB_ASK_DATA is set, a datum that has not come for
 * MAVLINK_GIMBAL_DATA_LOST_US is asked for every MAVLINK_GIMBAL_ASK_US, then more seldom.
 *
 * Context: the endpoint's, with a struct mavlink_gimbal as the component's service.
 */
#ifndef PHAROS_PROTO_MAVLINK_GIMBAL_VEHICLE_H
#define PHAROS_PROTO_MAVLINK_GIMBAL_VEHICLE_H

#include "proto/mavlink/endpoint.h"
#include "proto/mavlink/gimbal_service.h"

/* Is the sender the gimbal's manager, and is there one that is heard? */
bool mavlink_gimbal_is_manager(const struct mavlink_context *context);
bool mavlink_gimbal_is_managed(const struct mavlink_context *context);

/* Receivers of HEARTBEAT, 280, 281, 286, ATTITUDE and GLOBAL_POSITION_INT. */
void mavlink_gimbal_heartbeat(const struct mavlink_context *context,
                              const struct mavlink_frame *frame);
void mavlink_gimbal_manager_information(const struct mavlink_context *context,
                                        const struct mavlink_frame *frame);
void mavlink_gimbal_manager_status(const struct mavlink_context *context,
                                   const struct mavlink_frame *frame);
void mavlink_gimbal_autopilot_state(const struct mavlink_context *context,
                                    const struct mavlink_frame *frame);
void mavlink_gimbal_vehicle_attitude(const struct mavlink_context *context,
                                     const struct mavlink_frame *frame);
void mavlink_gimbal_vehicle_position(const struct mavlink_context *context,
                                     const struct mavlink_frame *frame);

/*
 * The event that points the beam from one place at another. The earth is flat enough for a beam.
 * false: the places are one, or too far apart.
 */
bool mavlink_gimbal_aim_at(const struct mavlink_place *from, const struct mavlink_place *to,
                           struct gimbal_event *event);

/* Has the datum not come for MAVLINK_GIMBAL_DATA_LOST_US? */
bool mavlink_gimbal_is_missing(const struct mavlink_gimbal *self, int64_t now_us,
                               enum mavlink_gimbal_datum datum);

/* The profile's step and deadline_us. */
bool mavlink_gimbal_ask(const struct mavlink_context *context);
int64_t mavlink_gimbal_ask_us(const void *service);

#endif
