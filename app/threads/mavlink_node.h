/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light as a MAVLink node: the endpoint with its components, and what it wants done. Context:
 * the command thread, unless said otherwise.
 */
#ifndef PHAROS_THREADS_MAVLINK_NODE_H
#define PHAROS_THREADS_MAVLINK_NODE_H

#include <stddef.h>
#include <stdint.h>

#include "core/device.h"
#include "proto/mavlink/endpoint.h"
#include "proto/mavlink/gimbal_service.h"

/* With the parameters as loaded. */
void mavlink_node_init(struct pharos_device *device);

/* A frame has come on a link; it stays until mavlink_node_flush(). */
void mavlink_node_take(uint8_t link, const uint8_t *bytes, size_t length);

/* What the device did: tells it. */
void mavlink_node_tell(const struct device_effects *effects);

/* Makes texts of what people should know by now: what failed, what is stored no more. */
void mavlink_node_warn(void);

/* Makes what is due, as much as one outbox takes. */
void mavlink_node_step(void);
int64_t mavlink_node_deadline_us(void);

/* Sends what the calls above have made. After what the device did has been performed. */
void mavlink_node_flush(void);

/* A link comes or goes, as in mavlink_endpoint_link_up and _down. */
void mavlink_node_link_up(uint8_t link);
void mavlink_node_link_down(uint8_t link);

#ifdef CONFIG_PHAROS_SIGNING
/* For the shell: a signing key comes, or goes (all zero); from functions given to inbox_call(). */
void mavlink_node_set_key(const struct mavlink_signing_record *record);
#endif

/* For the shell: from functions given to inbox_call(). */
const struct mavlink_endpoint *mavlink_node_endpoint(void);
#ifdef CONFIG_PHAROS_GIMBAL
/* Zeros where there is no gimbal. */
const struct mavlink_gimbal_stats *mavlink_node_gimbal_stats(void);
#endif

#endif
