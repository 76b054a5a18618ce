/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Self-test: the lamp's brightness goes up to a peak and down again, within SELF_TEST_STEPS steps
 * of SELF_TEST_STEP_US, while the temperature sensor and the lamp's driver are watched; then the
 * lamp is again as it was commanded. Heat limits the lamp as always, in the light driver.
 *
 *   if (self_test_obstacle(&test, &light) == SELF_TEST_NONE) {
 *           if the illuminator accepts self_test_first()
 *                   self_test_begin(&test, now_us, peak_ppm);
 *   }
 *   …
 *   while (self_test_step(&test, now_us, &light, &event)) {
 *           give the illuminator the event
 *   }
 *
 * Whatever ends the illuminator's test (a command, a thermal shutdown, the loss of power) ends the
 * self-test too, and then rules.
 *
 * Context: the thread that owns it.
 */
#ifndef PHAROS_CORE_SELF_TEST_H
#define PHAROS_CORE_SELF_TEST_H

#include "core/illuminator.h"

#include <stdbool.h>
#include <stdint.h>

/* The numbers are those of COMMAND_ACK.result_param2. */
enum self_test_state {
	SELF_TEST_NONE, /* since the start */
	SELF_TEST_RUNNING,
	SELF_TEST_PASSED,
	SELF_TEST_SENSOR_FAILED,
	SELF_TEST_DRIVER_FAILED,
	SELF_TEST_TOO_HOT,     /* thermal shutdown */
	SELF_TEST_NO_POWER,    /* of the lamp's driver */
	SELF_TEST_INTERRUPTED, /* by another command */
	SELF_TEST_CANCELLED,
};

/* Readable by the owner; only the functions below write. */
struct self_test {
	enum self_test_state state;
	bool driver_fault;
	uint32_t peak_ppm;
	uint32_t step; /* of SELF_TEST_STEPS */
	int64_t step_us;
};

void self_test_init(struct self_test *self);

/* What the lamp's driver says of itself, whenever it changes. */
void self_test_driver(struct self_test *self, bool fault);

/*
 * What stands against a test now: RUNNING (one is), SENSOR_FAILED, DRIVER_FAILED, TOO_HOT or
 * NO_POWER; NONE: nothing.
 */
enum self_test_state self_test_obstacle(const struct self_test *self,
                                        const struct illuminator *light);

/* The event for the illuminator that begins a test. */
struct illuminator_event self_test_first(void);

/* There is no obstacle and the illuminator has taken self_test_first. peak_ppm 1…PPM_ONE. */
void self_test_begin(struct self_test *self, int64_t now_us, uint32_t peak_ppm);

/* true: the illuminator is to be given *event. At any time; nothing happens unless RUNNING. */
bool self_test_step(struct self_test *self, int64_t now_us, const struct illuminator *light,
                    struct illuminator_event *event);

/* Ends a running test (asserted); the illuminator is to be given the event. */
struct illuminator_event self_test_cancel(struct self_test *self);

/* When step has something to do; TIME_NEVER_US: no test runs. */
int64_t self_test_deadline_us(const struct self_test *self);

/* How much of the test is done, 0…100. */
uint8_t self_test_percent(const struct self_test *self);

/* For people, constant and never NULL: "passed", "the temperature sensor has failed", … */
const char *self_test_text(enum self_test_state state);

#endif
