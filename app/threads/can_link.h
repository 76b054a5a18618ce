/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A CAN controller as a link: frames that pass the filters go to the command thread in buffers of a
 * pool; the command thread's frames go into the controller's mailboxes. It knows no meaning.
 *
 * Bus-off, an interface that goes, full queues: counted, never fatal. The controller recovers by
 * itself; the command thread is woken when it may send again.
 */
#ifndef PHAROS_THREADS_CAN_LINK_H
#define PHAROS_THREADS_CAN_LINK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <zephyr/drivers/can.h>

#include "proto/dronecan/transport.h"

/* Extended ids: those that equal id in the bits of mask. */
struct can_link_filter {
	uint32_t id;
	uint32_t mask;
};

struct can_link_stats {
	uint32_t rx_frames;
	uint32_t rx_overruns; /* frames lost because the queue was full */
	uint32_t tx_frames;
	uint32_t tx_failed;  /* given up by the controller, or refused by it */
	uint32_t tx_waits;   /* times that no mailbox was free */
	uint32_t bus_offs;   /* times that the controller left the bus because of errors */
	uint32_t bus_errors; /* that the controller has counted; 0 where it does not count */
};

struct can_link_status {
	struct can_link_stats stats;
	enum can_state state;
	struct can_bus_err_cnt errors;
};

/*
 * Opens the controller, if the board has one. fd: send and receive FD frames as well. A bit rate or
 * mode that it does not have is logged, and the devicetree's stays. 0, -ENODEV: no CAN, or -errno
 * of the driver, logged. Before the threads start.
 */
int can_link_init(uint32_t bitrate, bool fd);

/* Whether FD frames can be sent. After can_link_init(). */
bool can_link_has_fd(void);

/*
 * From now on only frames that match one of these, at most CAN_LINK_FILTERS_MAX. A controller with
 * fewer filters takes every frame. Command thread, or before the threads start.
 */
void can_link_listen(const struct can_link_filter *filters, size_t count);

/*
 * Puts a frame into a mailbox. False: none is free, or the controller is off the bus; the command
 * thread is woken when that has changed. A frame that the controller refuses counts as sent, so
 * that it does not block those behind it. Command thread.
 */
bool can_link_send(const struct dronecan_frame *frame);

/* Any thread. */
struct can_link_status can_link_status_get(void);

/* Thread entry, if the board has CAN and it has started. */
void can_link_run(void *p1, void *p2, void *p3);

#endif
