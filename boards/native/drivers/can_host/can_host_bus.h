/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Between the Zephyr side of the native CAN controller (can_host*.c) and the host's buses
 * (can_bus.c, and one back end for each kind of bus). No header of either side is included here.
 */
#ifndef CAN_HOST_BUS_H_
#define CAN_HOST_BUS_H_

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
	CAN_HOST_DATA_MAX = 64,
	CAN_HOST_CLASSIC_MAX = 8,
	CAN_HOST_STD_ID_MAX = 0x7FF,
	CAN_HOST_EXT_ID_MAX = 0x1FFFFFFF,
};

/* Flags of a frame, as Zephyr's CAN_FRAME_…. */
enum {
	CAN_HOST_EXTENDED = 1 << 0,
	CAN_HOST_REMOTE = 1 << 1,
	CAN_HOST_FD = 1 << 2,
	CAN_HOST_BRS = 1 << 3,
	CAN_HOST_ESI = 1 << 4,
};

struct can_host_frame {
	uint32_t id;
	uint8_t flags;
	uint8_t length; /* bytes; that of an FD frame is one that a length code has */
	uint8_t data[CAN_HOST_DATA_MAX];
};

enum can_host_event_kind {
	CAN_HOST_FRAME,
	/* what a controller sees on the bus */
	CAN_HOST_BIT0_ERROR,
	CAN_HOST_BIT1_ERROR,
	CAN_HOST_STUFF_ERROR,
	CAN_HOST_CRC_ERROR,
	CAN_HOST_FORM_ERROR,
	CAN_HOST_ACK_ERROR,
	CAN_HOST_OVERRUN,
	/* injected: tx_errors reaches 256 now; recovery begins hold_us later */
	CAN_HOST_FORCE_BUS_OFF,
	/* a real controller below: its state and its error counters */
	CAN_HOST_STATE,
};

enum can_host_state { /* as Zephyr's enum can_state */
	CAN_HOST_ACTIVE,
	CAN_HOST_WARNING,
	CAN_HOST_PASSIVE,
	CAN_HOST_BUS_OFF,
};

struct can_host_event {
	enum can_host_event_kind kind;
	union {
		struct can_host_frame frame;
		uint32_t hold_us;
		struct {
			enum can_host_state state;
			uint8_t tx_errors;
			uint8_t rx_errors;
		};
	};
};

enum can_host_result {
	CAN_HOST_SENT,
	CAN_HOST_DESTROYED, /* an error frame hit it; nobody has received it */
	CAN_HOST_NOBODY,    /* not acknowledged: no bus, no interface; on_ready() when there is */
	CAN_HOST_BUSY,      /* the host's queue is full; on_ready() when it is not */
};

/* What the bus calls, in interrupt context. */
struct can_host_client {
	void (*on_event)(void *arg); /* there is an event to take */
	void (*on_ready)(void *arg); /* what could not be sent may be tried again */
	void *arg;
};

struct can_bus;

/* The bus of that option ("can0"); NULL: there is none. */
struct can_bus *can_host_bus_find(const char *name);

void can_host_bus_open(struct can_bus *bus, const struct can_host_client *client);

/* Below it is a controller of its own, which arbitrates, retransmits and counts errors. */
bool can_host_bus_is_real(const struct can_bus *bus);

/* The option ",paced": frames take the time that the bit rate gives them. */
bool can_host_bus_is_paced(const struct can_bus *bus);

/* The oldest event, which stays; NULL: there is none. Then: drops it. */
const struct can_host_event *can_host_bus_peek(const struct can_bus *bus);
void can_host_bus_drop(struct can_bus *bus);

enum can_host_result can_host_bus_send(struct can_bus *bus, const struct can_host_frame *frame);

#endif
