/* SPDX-License-Identifier: Apache-2.0 */
/* Every bound of the DroneCAN stack, and how the bounds relate. */
#ifndef PHAROS_PROTO_DRONECAN_LIMITS_H
#define PHAROS_PROTO_DRONECAN_LIMITS_H

#include "core/limits.h"
#include "proto/dronecan/dsdl.h"

/* DroneCAN specification, "CAN bus transport layer". */
#define DRONECAN_NODE_ID_MAX         127u
#define DRONECAN_PRIORITY_LOWEST     31u
#define DRONECAN_FRAME_SIZE_CLASSIC  8u
#define DRONECAN_FRAME_SIZE_FD       64u
#define DRONECAN_TRANSFER_ID_MASK    31u
#define DRONECAN_TRANSFER_TIMEOUT_US (2 * US_PER_S)
#define DRONECAN_SUBSCRIPTIONS_MAX   32u

/* Nodes times types that talk to us within seconds of each other; one is 32 bytes. */
#define DRONECAN_RX_SESSIONS    ((uint32_t)CONFIG_PHAROS_CAN_RX_SESSIONS)
/* Multi-frame transfers under way at once: ten nodes and some. */
#define DRONECAN_RX_BUFFERS     ((uint32_t)CONFIG_PHAROS_CAN_RX_TRANSFERS)
#define DRONECAN_RX_PAYLOAD_MAX 264u

/* Transfers waiting: 3 of each asker's tunnel, and an answer to each of ten tools at once. */
#define DRONECAN_TX_TRANSFERS   ((uint32_t)CONFIG_PHAROS_CAN_TX_TRANSFERS)
#define DRONECAN_TX_PAYLOAD_MAX 208u
/* Nobody waits longer for an answer; a bus that was off for longer starts with fresh ones. */
#define DRONECAN_TX_TIMEOUT_US  (1 * US_PER_S)
/* Types times targets whose transfer ids we count. */
#define DRONECAN_TX_COUNTERS    16u

/* The tunnel: askers at once, bytes that wait for each. */
#define DRONECAN_TUNNEL_CHANNELS   ((uint32_t)CONFIG_PHAROS_CAN_TUNNELS)
#define DRONECAN_TUNNEL_CHUNK      120u
#define DRONECAN_TUNNEL_BUFFER     1024u
#define DRONECAN_TUNNEL_TIMEOUT_US (3 * US_PER_S)
#define DRONECAN_TUNNEL_PRIORITY   16u
/* Transfers the tunnel leaves free for everything else. */
#define DRONECAN_TUNNEL_TX_RESERVE 10u

_Static_assert(DRONECAN_RX_SESSIONS <= 127u && DRONECAN_RX_BUFFERS <= 127u, "indices are int8_t");
_Static_assert(DRONECAN_RX_BUFFERS <= DRONECAN_RX_SESSIONS, "a buffer belongs to a session");
_Static_assert(DRONECAN_TX_TRANSFERS <= 127u, "indices are int8_t");
_Static_assert(DRONECAN_RX_PAYLOAD_MAX >= DRONECAN_PARAM_GET_SET_REQUEST_MAX_SIZE, "requests fit");
_Static_assert(DRONECAN_RX_PAYLOAD_MAX >= DRONECAN_FILE_BEGIN_FIRMWARE_UPDATE_REQUEST_MAX_SIZE,
               "requests fit");
_Static_assert(DRONECAN_RX_PAYLOAD_MAX >= DRONECAN_FILE_READ_RESPONSE_MAX_SIZE, "responses fit");
_Static_assert(DRONECAN_RX_PAYLOAD_MAX >= DRONECAN_TUNNEL_TARGETTED_MAX_SIZE, "tunnel fits");
_Static_assert(DRONECAN_TX_PAYLOAD_MAX >= DRONECAN_FILE_READ_REQUEST_MAX_SIZE, "requests fit");
_Static_assert(DRONECAN_TX_PAYLOAD_MAX >= DRONECAN_TUNNEL_TARGETTED_MAX_SIZE, "tunnel fits");
_Static_assert(DRONECAN_TX_PAYLOAD_MAX >= DRONECAN_DEBUG_LOG_MESSAGE_MAX_SIZE, "log fits");
_Static_assert(DRONECAN_TUNNEL_TX_RESERVE < DRONECAN_TX_TRANSFERS, "the tunnel may send");
/* DroneCAN refuses to reuse a transfer id within its time-out: 32 ids last that long. */
_Static_assert(DRONECAN_TX_TIMEOUT_US < DRONECAN_TRANSFER_TIMEOUT_US, "never sent when stale");

#endif
