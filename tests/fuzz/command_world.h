/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What stands around the command thread in fuzz_command: links that take what is sent, a store, the
 * lamp's timer, servos, flash. They keep what the thread last wanted, so that it can be compared
 * with what the device says.
 */
#ifndef PHAROS_FUZZ_COMMAND_WORLD_H_
#define PHAROS_FUZZ_COMMAND_WORLD_H_

#include <stdbool.h>
#include <stdint.h>

#include "core/device.h"
#include "proto/mavlink/signing.h"
#include "threads/inbox.h"

/* The UART that speaks IMC; the others speak MAVLink. */
#define UART_OF_IMC 1

struct command_world {
	int64_t now_us;
	bool is_full;      /* UARTs take nothing */
	bool is_off_bus;   /* CAN takes nothing */
	bool fails;        /* the store does */
	bool driver_fault; /* the lamp's driver says so */
	bool restarts;     /* the thread wants a restart, which ends the run */
	uint32_t sent;     /* frames and packets on all links since this was last set to 0 */
	struct params stored;
	struct light_plan plan;
	struct mavlink_signing_record signing;
	void (*flashed)(const char *failure); /* of an update under way; NULL: there is none */
	bool is_flashing;
	bool is_last; /* what is flashed ends the update */
};

extern struct command_world world;

/* As after a power-up, with these parameters in the store. */
void command_world_init(const struct params *stored);

/* The thread's next item, which may be INBOX_WAKE; false: the run ends. */
bool command_next(int64_t deadline_us, struct inbox_item *item);

/* INBOX_CALL: something that another thread has the command thread run. */
void command_call(struct pharos_device *device);

/* Checks a frame of ours that the thread sends. */
void command_sent_mavlink(const uint8_t *bytes, size_t length);

/* Runs the thread until command_next() returns false or it restarts the device. */
void command_world_run(void);

#endif /* PHAROS_FUZZ_COMMAND_WORLD_H_ */
