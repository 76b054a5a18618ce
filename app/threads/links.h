/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The links of MAVLink by their numbers, 0…LINKS_MAX - 1: the UARTs, then the tunnels over CAN. See
 * link.h.
 */
#ifndef PHAROS_THREADS_LINKS_H
#define PHAROS_THREADS_LINKS_H

#include <stddef.h>
#include <stdint.h>

#include "threads/limits.h"
#include "threads/link.h"

/*
 * frame: 1…MAVLINK_FRAME_MAX bytes, sent as one write. Command thread only. 0; -ENODEV: no such
 * link; -ENOBUFS: the queue is full, counted.
 */
int links_send(uint8_t link, const uint8_t *frame, size_t length);

/* The same, for a frame of others. Not without CONFIG_PHAROS_ROUTING. */
int links_forward(uint8_t link, const uint8_t *frame, size_t length);

/* Bit per link that is always there: this board's UARTs that speak MAVLink. Tunnels come and go. */
uint32_t links_mask(void);

/* Bytes a second that a link carries; 0: not known. */
uint32_t links_rate(uint8_t link);

/* Counters of a link. Any thread. -ENODEV: no such link. */
int links_stats_get(uint8_t link, struct link_stats *stats);

/* Short name of a link, "uart0", "tunnel0", … */
const char *links_name(uint8_t link);

#endif
