/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Bounds of the threads and their queues, and how they relate. RAM on the smallest board is spent
 * here.
 */
#ifndef PHAROS_THREADS_LIMITS_H
#define PHAROS_THREADS_LIMITS_H

#include "proto/mavlink/framer.h"

#ifdef CONFIG_PHAROS_IMC
#include "proto/imc/limits.h"
#endif

/* MAVLink's links: the UARTs, then the tunnels over CAN. */
#define UART_LINKS_MAX CONFIG_PHAROS_UART_LINKS
#define TUNNEL_LINK0   UART_LINKS_MAX
#ifdef CONFIG_CAN
#define TUNNEL_LINKS_MAX CONFIG_PHAROS_CAN_TUNNELS
#else
#define TUNNEL_LINKS_MAX 0
#endif
#define LINKS_MAX (UART_LINKS_MAX + TUNNEL_LINKS_MAX)

/* Bytes of a UART's receive ring. */
#define UART_RX_RING_SIZE CONFIG_PHAROS_UART_RX_RING
/* Bytes of its transmit ring; each frame takes two more for its length. The longest frame. */
#ifdef CONFIG_PHAROS_IMC
#define UART_TX_RING_SIZE (IMC_OUTBOX_BYTES + 512)
#define UART_FRAME_MAX    IMC_PACKET_MAX
#else
#define UART_TX_RING_SIZE CONFIG_PHAROS_UART_TX_RING
#define UART_FRAME_MAX    MAVLINK_FRAME_MAX
#endif
/* Bytes of its ring of forwarded frames. */
#define UART_FORWARD_RING_SIZE 1024

/*
 * Bytes a second of a tunnel over CAN: what a UART of 115200 baud carries, which is about a sixth
 * of a classic bus of 1 Mbit/s.
 */
#define TUNNEL_RATE 11520u

/* Frames between the link threads and the command thread; a full pool makes a link thread wait. */
#define LINK_FRAMES_MAX (3 + UART_LINKS_MAX)
/* CAN frames on the same way. */
#ifdef CONFIG_CAN
#define CAN_FRAMES_MAX 8
#else
#define CAN_FRAMES_MAX 0
#endif
/* IMC packets. */
#ifdef CONFIG_PHAROS_IMC
#define IMC_FRAMES_MAX CONFIG_PHAROS_IMC_FRAMES
#else
#define IMC_FRAMES_MAX 0
#endif
/* Requests to the command thread: every frame, and a few reports and calls besides. */
#define COMMAND_QUEUE_MAX       (LINK_FRAMES_MAX + CAN_FRAMES_MAX + IMC_FRAMES_MAX + 8)
/* What a board may have of each kind. */
#define ACTUATOR_POWER_CHANNELS 4
#define ACTUATOR_GPIO_OUTPUTS   2
#define ACTUATOR_GPIO_INPUTS    2
#define ACTUATOR_PWMS           2
#define ACTUATOR_LEDS           2

/* What the light listens to on CAN: DroneCAN's messages and services. */
#define CAN_LINK_FILTERS_MAX 8

_Static_assert(LINKS_MAX == MAVLINK_LINKS_MAX, "the endpoint knows every link");
_Static_assert(COMMAND_QUEUE_MAX > LINK_FRAMES_MAX + CAN_FRAMES_MAX + IMC_FRAMES_MAX,
               "frames leave room for reports and calls");
_Static_assert(UART_FORWARD_RING_SIZE >= MAVLINK_FRAME_MAX + 2, "a forwarded frame fits");
_Static_assert(UART_FRAME_MAX >= MAVLINK_FRAME_MAX, "either protocol's frames fit");
_Static_assert(UART_TX_RING_SIZE >= 4 * (MAVLINK_FRAME_MAX + 2), "an answer and its streams fit");

#endif
