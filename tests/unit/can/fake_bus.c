/* SPDX-License-Identifier: Apache-2.0 */
#include "fake_bus.h"

#include <string.h>

#include "can_host/can_bus.h"

struct fake_bus fake_bus;

static void start(struct can_bus *bus)
{
	(void)bus;
}

static enum can_host_result send_frame(struct can_bus *bus, const struct can_host_frame *frame)
{
	(void)bus;
	fake_bus.attempts++;
	if (fake_bus.result == CAN_HOST_SENT && fake_bus.sent_count < FAKE_BUS_FRAMES) {
		fake_bus.sent[fake_bus.sent_count++] = *frame;
	}
	return fake_bus.result;
}

static const struct can_bus_type type = {.scheme = "fake", .start = start, .send = send_frame};

void fake_bus_attach(void)
{
	fake_bus = (struct fake_bus){.result = CAN_HOST_SENT};
	can_host_bus_find("can0")->type = &type;
}

void fake_bus_detach(void)
{
	can_host_bus_find("can0")->type = &can_bus_none;
}

static void give(const struct can_host_event *event)
{
	struct can_bus *bus = can_host_bus_find("can0");

	can_bus_received(bus, event);
	can_bus_received_all(bus);
}

void fake_bus_receive(uint32_t id, uint8_t flags, uint8_t length)
{
	struct can_host_event event = {.kind = CAN_HOST_FRAME};

	event.frame = (struct can_host_frame){.id = id, .flags = flags, .length = length};
	for (uint8_t i = 0; i < length; i++) {
		event.frame.data[i] = i;
	}
	give(&event);
}

void fake_bus_tell(enum can_host_event_kind kind)
{
	give(&(struct can_host_event){.kind = kind});
}

void fake_bus_ready(void)
{
	can_bus_ready(can_host_bus_find("can0"));
}

void fake_bus_force_off(uint32_t hold_us)
{
	can_bus_force_off(can_host_bus_find("can0"), hold_us);
}
