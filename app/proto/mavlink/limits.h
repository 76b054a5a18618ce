/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Every bound of the MAVLink endpoint, and how the bounds relate.
 */
#ifndef PHAROS_PROTO_MAVLINK_LIMITS_H
#define PHAROS_PROTO_MAVLINK_LIMITS_H

#include <stdint.h>

/* Wire sizes, MAVLink 2: header 10, payload up to 255, checksum 2, signature 13. Version 1: 6. */
#define MAVLINK_V1_HEADER       6
#define MAVLINK_V2_HEADER       10
#define MAVLINK_CHECKSUM_BYTES  2
#define MAVLINK_SIGNATURE_BYTES 13
#define MAVLINK_PAYLOAD_MAX     255
#define MAVLINK_FRAME_MAX       280
#define MAVLINK_V1_FRAME_MIN    (MAVLINK_V1_HEADER + MAVLINK_CHECKSUM_BYTES)
#define MAVLINK_V2_FRAME_MIN    (MAVLINK_V2_HEADER + MAVLINK_CHECKSUM_BYTES)
#define MAVLINK_V1_MESSAGE_MAX  255u
#define MAVLINK_MESSAGE_ID_MAX  0xFFFFFFu

/* A framer keeps a signature and an unfinished frame, and has room for one more. */
#define MAVLINK_FRAMER_WINDOW (2 * MAVLINK_FRAME_MAX + MAVLINK_SIGNATURE_BYTES)

/* Links: UARTs and tunnels over CAN. Components of this device, rows of one's message table. */
#ifdef CONFIG_CAN
#define MAVLINK_LINKS_MAX (CONFIG_PHAROS_UART_LINKS + CONFIG_PHAROS_CAN_TUNNELS)
#else
#define MAVLINK_LINKS_MAX CONFIG_PHAROS_UART_LINKS
#endif
#ifdef CONFIG_PHAROS_GIMBAL
#define MAVLINK_COMPONENTS_MAX 2
#else
#define MAVLINK_COMPONENTS_MAX 1
#endif
#define MAVLINK_MESSAGES_MAX 10

/* Frames that one received frame may cause: per component an answer and a message on each link. */
#define MAVLINK_ACK_FRAME_MAX (MAVLINK_V2_FRAME_MIN + 10 + MAVLINK_SIGNATURE_BYTES)
#define MAVLINK_STEP_FRAMES   (MAVLINK_COMPONENTS_MAX * (1 + MAVLINK_LINKS_MAX))
#define MAVLINK_STEP_BYTES                                                                         \
	(MAVLINK_COMPONENTS_MAX * (MAVLINK_ACK_FRAME_MAX + MAVLINK_LINKS_MAX * MAVLINK_FRAME_MAX))
#define MAVLINK_OUTBOX_FRAMES MAVLINK_STEP_FRAMES
#define MAVLINK_OUTBOX_BYTES  MAVLINK_STEP_BYTES

/* Streams: the fastest that may be asked for, and the least time between two reports of a change.
 */
#define MAVLINK_INTERVAL_MIN_US   1000
#define MAVLINK_CHANGE_GAP_MIN_US 100000

/* What a link carries when its rate is not known, 57600 baud, and the part of it that bulk takes.
 */
#define MAVLINK_RATE_DEFAULT 5760u
#define MAVLINK_BULK_PERCENT 46u

/* STATUSTEXT: waiting texts, and how often: a burst, then one per period; each kind once per gap.
 */
#define MAVLINK_TEXT_BYTES     50
#define MAVLINK_TEXTS_MAX      4
#define MAVLINK_TEXT_BURST     4
#define MAVLINK_TEXT_PERIOD_US 2000000
#define MAVLINK_NOTICE_KINDS   6
#define MAVLINK_NOTICE_GAP_US  10000000

/* Gimbal: how often the vehicle is asked for what does not come, at first and after so many times
 * in vain; when a datum counts as lost and when the vehicle or another manager does; and how often
 * the data are wanted.
 */
#define MAVLINK_GIMBAL_ASK_US          1000000
#define MAVLINK_GIMBAL_ASKS            10
#define MAVLINK_GIMBAL_ASK_AGAIN_US    30000000
#define MAVLINK_GIMBAL_DATA_LOST_US    2000000
#define MAVLINK_GIMBAL_VEHICLE_LOST_US 5000000
#define MAVLINK_GIMBAL_ATTITUDE_HZ     20
#define MAVLINK_GIMBAL_POSITION_HZ     2

/* Signing: senders that are followed at once, and how often the timestamp is stored. */
#define MAVLINK_SIGNING_STREAMS_MAX 32
#define MAVLINK_SIGNING_STORE_S     50

/* Routing: senders whose link is known, the silence after which they may have moved, and after
 * which it no longer counts that they have commanded.
 */
#define MAVLINK_ROUTES_MAX       32
#define MAVLINK_ROUTE_SILENCE_US 5000000
#define MAVLINK_ROUTE_TRUST_US   60000000

/* The same bytes within this time have gone in a circle. So many frames are forwarded within it at
 * most, and of these so many from one link: none is forgotten before.
 */
#define MAVLINK_SEEN_US       250000
#define MAVLINK_SEEN_MAX      CONFIG_PHAROS_ROUTE_FRAMES
#define MAVLINK_SEEN_LINK_MAX (MAVLINK_SEEN_MAX / 2)

/* FTP: open files, when an idle one may be closed for another, and the longest name of a file. */
#define MAVLINK_FTP_SESSIONS 4
#define MAVLINK_FTP_IDLE_US  10000000
#define MAVLINK_FTP_NAME_MAX 32
#define MAVLINK_FTP_DATA_MAX 239

/* A firmware image that is uploaded: what is handed to the flash at once, and the silence after
 * which it is given up.
 */
#define MAVLINK_UPLOAD_BLOCK   256
#define MAVLINK_UPLOAD_IDLE_US 60000000

_Static_assert(MAVLINK_FRAME_MAX == MAVLINK_V2_HEADER + MAVLINK_PAYLOAD_MAX +
                                            MAVLINK_CHECKSUM_BYTES + MAVLINK_SIGNATURE_BYTES,
               "the longest frame");
_Static_assert(MAVLINK_FRAMER_WINDOW >= 2 * MAVLINK_FRAME_MAX + MAVLINK_SIGNATURE_BYTES,
               "room beside a signature and an unfinished frame");
_Static_assert(MAVLINK_OUTBOX_FRAMES >= MAVLINK_STEP_FRAMES, "the answers to a frame fit");
_Static_assert(MAVLINK_OUTBOX_BYTES >= MAVLINK_STEP_BYTES, "the answers to a frame fit");
_Static_assert(MAVLINK_OUTBOX_BYTES <= UINT16_MAX, "offsets are 16 bits");
_Static_assert(MAVLINK_SIGNING_STORE_S < 60, "stored at least once a minute");
_Static_assert(MAVLINK_LINKS_MAX <= 8, "a set of links is 8 bits");
_Static_assert(MAVLINK_FTP_SESSIONS < UINT8_MAX, "a client has a number to spare");
_Static_assert(MAVLINK_FTP_DATA_MAX < MAVLINK_UPLOAD_BLOCK, "a write fills one block at most");
_Static_assert(MAVLINK_UPLOAD_IDLE_US > MAVLINK_FTP_IDLE_US, "taken over before it is given up");
_Static_assert(MAVLINK_MESSAGES_MAX <= 16, "a set of streams is 16 bits");

#endif
