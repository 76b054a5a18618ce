/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The machine of the native CAN controller: transmit mailboxes, arbitration, delivery to filters,
 * error counters and states (ISO 11898-1, fault confinement). can_host.c has Zephyr's API above it.
 *
 * Without ",paced" the bus is infinitely fast. With it, one frame after the other occupies the bus
 * for the time of its bits; the own mailbox and the foreign frame that wait when it becomes free
 * arbitrate by their ids. What is on the bus is seen from this one node: every other node runs a
 * clock of its own.
 *
 * Where a real controller is below (SocketCAN), it arbitrates and counts errors, and tells its
 * state.
 */
#ifndef CAN_CONTROLLER_H_
#define CAN_CONTROLLER_H_

#include <native/irq.h>
#include <zephyr/drivers/can.h>
#include <zephyr/kernel.h>

#include "can_host_bus.h"

#define CAN_CONTROLLER_FILTERS   28 /* of standard and of extended ids */
#define CAN_CONTROLLER_MAILBOXES 32

struct can_controller_mailbox {
	bool used;
	uint32_t order; /* of equal priority, the older one goes first */
	struct can_host_frame frame;
	can_tx_callback_t callback;
	void *user_data;
};

struct can_controller_filter {
	can_rx_callback_t callback; /* NULL: unused */
	void *user_data;
	struct can_filter filter;
};

struct can_controller {
	const struct device *dev;
	struct can_bus *bus;
	struct native_irq irq;
	bool started;
	can_mode_t mode;
	uint32_t bitrate;
	uint32_t bitrate_data;
	struct can_stats stats;
	struct can_controller_filter filters[CAN_CONTROLLER_FILTERS];
	/* transmitting */
	struct can_controller_mailbox mailboxes[CAN_CONTROLLER_MAILBOXES];
	uint32_t mailbox_count;
	uint32_t next_order;
	struct k_sem mailboxes_free;
	bool waiting; /* for the bus: until on_ready */
	/* fault confinement */
	enum can_state state; /* while started */
	uint32_t tx_errors;
	uint32_t rx_errors;
	can_state_change_callback_t state_callback;
	void *state_user_data;
	struct k_timer recovery_timer;
	struct k_sem recovered;
	uint64_t hold_until_us; /* recovery begins not before */
	/* paced */
	bool paced;
	bool occupied;
	int own; /* mailbox on the bus, or -1: `foreign` is */
	struct can_host_frame foreign;
	uint64_t free_ns; /* the end of the frame on the bus */
	struct k_timer frame_timer;
};

void can_controller_init(struct can_controller *self, const struct device *dev,
                         struct can_bus *bus);

/* Joins and leaves the bus. */
void can_controller_start(struct can_controller *self);
void can_controller_stop(struct can_controller *self);

/* Takes a mailbox, which k_sem_take(&mailboxes_free) has promised. Any context. */
void can_controller_post(struct can_controller *self, const struct can_host_frame *frame,
                         can_tx_callback_t callback, void *user_data);

/* Bus-off: error-active again after 128 times 11 recessive bits. */
void can_controller_recover(struct can_controller *self);

struct can_bus_err_cnt can_controller_errors(const struct can_controller *self);

#endif
