/* SPDX-License-Identifier: Apache-2.0 */
/* Every bound of IMC, and how the bounds relate. RAM on the smallest board is spent here. */
#ifndef PHAROS_PROTO_IMC_LIMITS_H
#define PHAROS_PROTO_IMC_LIMITS_H

#include "core/limits.h"

/* Wire sizes: header, payload, checksum. A bigger payload than this is no packet for us. */
#define IMC_HEADER_SIZE 20u
#define IMC_FOOTER_SIZE 2u
#define IMC_PAYLOAD_MAX ((uint32_t)CONFIG_PHAROS_IMC_PAYLOAD_MAX)
#define IMC_PACKET_MAX  (IMC_HEADER_SIZE + IMC_PAYLOAD_MAX + IMC_FOOTER_SIZE)

/* A stream keeps an unfinished packet, and some room beside it so that it seldom moves bytes. */
#define IMC_STREAM_WINDOW (IMC_PACKET_MAX + 256u)

/* Who is known at once; another one is answered, but gets no heartbeats. */
#define IMC_PEERS_MAX       8u
#define IMC_PEER_SILENCE_US (30 * (int64_t)US_PER_S)
#define IMC_HEARTBEAT_US    (1 * (int64_t)US_PER_S)
#define IMC_ANNOUNCE_US     (10 * (int64_t)US_PER_S)

/* Links that carry a stream of packets, bit per link; numbers above are datagram links. */
#define IMC_STREAM_LINKS 8u

/* Bytes of a list that one message carries: entities, parameters, services. */
#define IMC_LIST_MAX 1024u

/* Packets and bytes that one call may send: a list of everything that the light has. */
#define IMC_OUTBOX_PACKETS 32u
#define IMC_OUTBOX_BYTES   (IMC_PACKET_MAX + 1024u)

/* Characters of a name that was asked for in vain, in the log. */
#define IMC_ACTUATION_NAME_MAX 15u

_Static_assert(IMC_OUTBOX_BYTES <= UINT16_MAX && IMC_STREAM_WINDOW <= UINT16_MAX,
               "offsets are 16 bits");
_Static_assert(IMC_OUTBOX_PACKETS >= IMC_PEERS_MAX + IMC_STREAM_LINKS + 1u + 12u,
               "heartbeats, the announcement and changed states fit");
_Static_assert(IMC_OUTBOX_PACKETS <= UINT8_MAX, "counts are 8 bits");

#endif
