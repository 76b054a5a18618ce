/* SPDX-License-Identifier: Apache-2.0 */
/* A bus that the test plays: what the controller sends is kept, and meets the fate that the test
 * wants. */
#ifndef FAKE_BUS_H_
#define FAKE_BUS_H_

#include "can_host/can_host_bus.h"

#define FAKE_BUS_FRAMES 64

struct fake_bus {
	enum can_host_result result; /* of each attempt */
	uint32_t attempts;
	struct can_host_frame sent[FAKE_BUS_FRAMES]; /* those with CAN_HOST_SENT */
	uint32_t sent_count;
};

extern struct fake_bus fake_bus;

/* can0 is on it. */
void fake_bus_attach(void);

/* Back to no bus. */
void fake_bus_detach(void);

/* Other nodes, and what a controller below tells. */
void fake_bus_receive(uint32_t id, uint8_t flags, uint8_t length);
void fake_bus_tell(enum can_host_event_kind kind);

/* The bus is there again, or has room. */
void fake_bus_ready(void);

void fake_bus_force_off(uint32_t hold_us);

#endif
