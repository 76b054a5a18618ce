/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light as a MAVLink node: the endpoint with its components, and what it wants done. Context:
 * the command thread, unless said otherwise.
 */
#ifndef PHAROS_THREADS_MAVLINK_NODE_H
#define PHAROS_THREADS_MAVLINK_NODE_H

#include <stddef.h>
#include <stdint.h>

#include "proto/mavlink/endpoint.h"
#include "proto/mavlink/gimbal_service.h"
#include "threads/command.h"

/* Before the threads start. */
void mavlink_node_init(struct command *command);

/* Parameters of MAVLink's group have changed, or been loaded. */
void mavlink_node_configure(const struct params *params);

/* A frame has come on a link. */
void mavlink_node_take(struct command *command, uint8_t link, const uint8_t *bytes, size_t length);

/* Someone else has stepped the core, which returned these. */
void mavlink_node_observe(const struct illuminator_outbox *actions);

/* Someone else has changed these parameters. */
void mavlink_node_params_changed(const struct param_set *changed);

/* Sends what is due. */
void mavlink_node_step(struct command *command);
int64_t mavlink_node_deadline_us(void);

/* A link comes or goes, as in mavlink_endpoint_link_up and _down. */
void mavlink_node_link_up(uint8_t link);
void mavlink_node_link_down(uint8_t link);

#ifdef CONFIG_PHAROS_SIGNING
/* For the shell: a signing key comes, or goes (all zero); from functions given to command_call().
 */
void mavlink_node_set_key(const struct mavlink_signing_record *record);
#endif

/* For the shell: from functions given to command_call(). */
const struct mavlink_endpoint *mavlink_node_endpoint(void);
#ifdef CONFIG_PHAROS_GIMBAL
/* Zeros where there is no gimbal. */
const struct mavlink_gimbal_stats *mavlink_node_gimbal_stats(void);
#endif

#endif
