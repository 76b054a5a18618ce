/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The self-test as a command that takes time: MAV_CMD_USER_1 (31010) with param1 1, and in param2
 * the brightness that it goes up to, in percent (0 or NaN: 100). No command of common.xml means
 * this: RUN_PREARM_CHECKS (401) is an autopilot's, has no parameters and is done at once, and
 * stations send it to everybody. IN_PROGRESS comes with every tenth; the final result is ACCEPTED,
 * FAILED or CANCELLED, with enum self_test_state in result_param2, and a STATUSTEXT says the same.
 *
 * Context: the endpoint's. The device steps the self-test itself.
 */
#ifndef PHAROS_PROTO_MAVLINK_SELF_TEST_SERVICE_H
#define PHAROS_PROTO_MAVLINK_SELF_TEST_SERVICE_H

#include "core/device.h"
#include "proto/mavlink/endpoint.h"

struct mavlink_self_test {
	struct pharos_device *device;
	uint8_t lamp;
	bool asked; /* over MAVLink, and not yet answered for good */
	uint8_t told_percent;
};

/* device outlives it. */
void mavlink_self_test_init(struct mavlink_self_test *self, struct pharos_device *device,
                            uint8_t lamp);

/* A row of an illuminator's commands: run and cancel, and its part of step and deadline_us. */
uint8_t mavlink_self_test_run(const struct mavlink_context *context,
                              const struct mavlink_command *command, struct mavlink_reply *reply);
/* Other makers' USER_1 is something else. */
bool mavlink_self_test_knows(const struct mavlink_command *command);
bool mavlink_self_test_cancel(const struct mavlink_context *context);
bool mavlink_self_test_step(struct mavlink_self_test *self, const struct mavlink_context *context);
int64_t mavlink_self_test_deadline_us(const struct mavlink_self_test *self);

#endif
